// What Dash's own components leave undone for those who use the keyboard or have the page read out.
(function () {
  "use strict";
  const mend = function () {
    const all = function (selector) { return document.querySelectorAll(selector); };
    // the button beside it takes the keyboard; this one only passes a click on the label on to it
    for (const target of all('.dash-dropdown-focus-target[tabindex="0"]')) {
      target.tabIndex = -1;
    }
    for (const file of all('input[type="file"]:not([aria-label])')) {
      file.setAttribute("aria-label", file.parentElement.textContent.trim());
    }
    // each holds a radio button, which says all of this by itself
    for (const option of all('label[class*="dash-radioitems"][aria-selected]')) {
      option.removeAttribute("role");
      option.removeAttribute("aria-selected");
      const list = option.closest('[role="listbox"]');
      if (list) { list.setAttribute("role", "radiogroup"); }
    }
  };
  new MutationObserver(mend).observe(document.documentElement, {
    childList: true,
    subtree: true,
    attributes: true,
    attributeFilter: ["aria-selected"],
  });
})();
