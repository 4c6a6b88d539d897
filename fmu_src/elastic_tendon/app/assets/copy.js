// A table is copied as it is read, a tab between cells, so that a sheet or a report can take it.
(function () {
  "use strict";
  const TOLD = 2000; // ms for which the button says that it was done

  function words(cell) {
    const field = cell.querySelector("input");
    return (field ? field.value : cell.innerText).trim().replace(/\s+/g, " ");
  }

  function copy(text) { // also where the page has no right to the clipboard by itself
    document.addEventListener("copy", function (event) {
      event.clipboardData.setData("text/plain", text);
      event.preventDefault();
    }, { once: true });
    return document.execCommand("copy");
  }

  document.addEventListener("click", function (event) {
    const button = event.target.closest("button.copy");
    if (!button) return;
    const rows = Array.from(button.parentElement.querySelector("table").rows);
    const text = rows.map(function (row) {
      return Array.from(row.cells).map(words).join("\t");
    }).join("\n");
    const said = button.textContent;
    if (!copy(text) || said === "Copied") return;
    button.textContent = "Copied";
    window.setTimeout(function () { button.textContent = said; }, TOLD);
  });
})();
