// Fields that are made anew while one of them has the focus give it back to the same one.
(function () {
  "use strict";
  let last = null;

  document.addEventListener("focusin", function (event) {
    last = event.target.closest("#data-cards") ? event.target : null;
  });

  new MutationObserver(function () {
    if (!last || last.isConnected || !last.id) return;
    const field = document.getElementById(last.id);
    if (field && document.activeElement === document.body) field.focus({ preventScroll: true });
  }).observe(document.documentElement, { childList: true, subtree: true });
})();
