// What Dash's own components leave undone for those who use the keyboard or have the page read out.
(function () {
  "use strict";
  const mend = function () {
    const all = function (selector) { return document.querySelectorAll(selector); };
    // the button beside it takes the keyboard; this one only passes a click on the label on to it
    for (const target of all('.dash-dropdown-focus-target[tabindex="0"]')) {
      target.tabIndex = -1;
    }
    for (const list of all('button.dash-dropdown[tabindex="-1"]')) {
      list.tabIndex = 0;
    }
    for (const file of all('input[type="file"]:not([aria-label])')) {
      file.setAttribute("aria-label", file.parentElement.textContent.trim());
    }
    // each holds a radio button or a check box, which says all of this by itself
    for (const option of all('label[aria-selected]')) {
      if (option.closest('[class*="dash-dropdown"]')) { continue; } // a list to choose from
      option.removeAttribute("role");
      option.removeAttribute("aria-selected");
      const list = option.closest('[role="listbox"]');
      if (list) {
        list.setAttribute("role", option.querySelector('[type="radio"]') ? "radiogroup" : "group");
      }
    }
  };
  new MutationObserver(mend).observe(document.documentElement, {
    childList: true,
    subtree: true,
    attributes: true,
    attributeFilter: ["aria-selected"],
  });
})();
