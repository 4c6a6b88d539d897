// A table is copied with a tab between cells, so that a sheet or a report can take it; its numbers
// with all their digits, as is one alone that is selected and copied.
(function () {
  "use strict";
  const TOLD = 2000; // ms for which the button says that it was done

  function words(cell) {
    const field = cell.querySelector("input"), { copied, shown } = cell.dataset;
    if (copied !== undefined && (!field || field.value === shown)) return copied;
    if (cell.matches("td:has(button)")) return "";
    const text = (field ? field.value : cell.innerText).trim().replace(/\s+/g, " ");
    return text.replace(/−(?=\d)/g, "-"); // as sheets read it
  }

  function selectedCell(selection) { // the one number that is selected, if it is one
    const text = selection.toString().trim(), at = selection.anchorNode;
    const cell = at && (at.closest ? at : at.parentElement).closest("td[data-copied]");
    return text && cell && cell.innerText.includes(text) ? cell : null;
  }

  document.addEventListener("copy", function (event) {
    const cell = selectedCell(document.getSelection());
    if (!cell) return;
    event.clipboardData.setData("text/plain", cell.dataset.copied);
    event.preventDefault();
  });

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
