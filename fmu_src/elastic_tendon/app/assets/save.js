// Figures are saved from where they are: as pictures, or as the numbers of the curves drawn.
(function () {
  "use strict";

  function plain(text) { // of a title, which may hold marks of its look
    const page = new DOMParser().parseFromString((text || "").replace(/<br>/g, " "), "text/html");
    return page.body.textContent.trim();
  }

  function quoted(cell) {
    const none = cell === undefined || cell === null || Number.isNaN(cell);
    const text = none ? "" : String(cell);
    return /[",\n]/.test(text) ? '"' + text.replace(/"/g, '""') + '"' : text;
  }

  function columns(trace, layout) { // of one curve: what heads each, and its numbers
    function title(letter) {
      const axis = layout[(trace[letter + "axis"] || letter).replace(letter, letter + "axis")];
      return plain(axis && axis.title && axis.title.text) || letter;
    }
    const name = plain(trace.name), x = Array.from(trace.x || []), y = Array.from(trace.y || []);
    function head(words) { return name ? name + ": " + words : words; }
    if (!trace.z) return [[head(title("x")), x], [head(title("y")), y]];
    const rows = Array.from(trace.z, function (row) { return Array.from(row); });
    return [
      [head(title("x")), rows.flatMap(function () { return x; })],
      [head(title("y")), rows.flatMap(function (row, i) { return row.map(function () { return y[i]; }); })],
      [head("value"), rows.flat()],
    ];
  }

  function table(figure) {
    const drawn = figure._fullData.filter(function (trace) { return trace.visible === true; });
    const all = drawn.flatMap(function (trace) { return columns(trace, figure.layout); });
    const longest = Math.max(0, ...all.map(function (column) { return column[1].length; }));
    const lines = [all.map(function (column) { return quoted(column[0]); }).join(",")];
    for (let i = 0; i < longest; i += 1) {
      lines.push(all.map(function (column) { return quoted(column[1][i]); }).join(","));
    }
    return lines.join("\n") + "\n";
  }

  function download(text, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
    link.download = name;
    link.click();
    window.setTimeout(function () { URL.revokeObjectURL(link.href); }, 1000);
  }

  document.addEventListener("click", function (event) {
    const button = event.target.closest("button.save");
    if (!button) return;
    const figure = button.closest(".saveable").querySelector(".js-plotly-plot");
    const format = button.textContent.toLowerCase(), name = button.value;
    if (!figure) return; // not drawn yet
    if (format === "csv") download(table(figure), name + ".csv");
    else window.Plotly.downloadImage(figure, { format: format, filename: name, scale: 2 });
  });
})();
