// What Dash's own components leave undone: for those who use the keyboard or have the page read out,
// and for those who type a number twice.
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
  // When a field of a number is left, Dash compares what was typed with what stood there when the
  // field was left before: typed again after the page emptied it, a number would be lost. Dash looks
  // anew when this count changes.
  let entered = 0;
  document.addEventListener("focusin", function (event) {
    const field = event.target;
    if (!field.matches('.dash-input-element[type="number"]')) return;
    entered -= 1; // never what Dash itself counts
    const id = field.id.startsWith("{") ? JSON.parse(field.id) : field.id;
    window.dash_clientside.set_props(id, { n_blur: entered });
  });
})();
