// Fields that are made anew while one of them has the focus give it back to the same one; those in
// the table are named by their row and column.
(function () {
  "use strict";
  let last = null;

  function name(field) {
    const cell = field.closest("#data-cards td");
    if (!cell) return;
    const head = cell.closest("table").rows[0].cells[cell.cellIndex];
    const row = cell.parentElement.querySelector("th");
    field.setAttribute("aria-label", row.textContent + ", " + head.textContent);
  }

  document.addEventListener("focusin", function (event) {
    last = event.target.closest("#data-cards") ? event.target : null;
    if (last) name(last);
  });

  new MutationObserver(function () {
    if (!last || last.isConnected || !last.id) return;
    const field = document.getElementById(last.id);
    if (field && document.activeElement === document.body) field.focus({ preventScroll: true });
  }).observe(document.documentElement, { childList: true, subtree: true });
})();
