// Files that are too large to be sent are told at once; without this nothing would happen.
(function () {
  "use strict";

  function place(event) {
    return event.target.closest ? event.target.closest("[data-most]") : null;
  }

  function words(bytes) {
    return bytes >= 1048576 ? bytes / 1048576 + " MB" : bytes / 1024 + " kB";
  }

  function look(event, files) {
    const where = place(event);
    if (!where || !files) return;
    const most = Number(where.dataset.most);
    const large = Array.from(files).filter(function (one) { return one.size > most; });
    const all = Array.from(files).reduce(function (sum, one) { return sum + one.size; }, 0);
    let sentence = "";
    if (large.length) {
      sentence = large[0].name + ": it is larger than " + words(most) +
        "; name it on the command line instead.";
    } else if (all > most) {
      sentence = "Together these files are larger than " + words(most) +
        "; add them one after the other.";
      event.stopPropagation();
      event.preventDefault();
    }
    window.dash_clientside.set_props(where.dataset.tell, { children: sentence });
  }

  document.addEventListener("change", function (event) { look(event, event.target.files); }, true);
  document.addEventListener("drop", function (event) {
    if (event.dataTransfer) look(event, event.dataTransfer.files);
  }, true);
  document.addEventListener("focusin", function (event) { // the field itself has no name
    const where = place(event);
    if (where) event.target.setAttribute("aria-label", where.textContent);
  });
})();
