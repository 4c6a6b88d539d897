// Before printing figures are drawn as wide as the paper and in the colours of the light theme, which
// the page's element holds by those of the dark; afterwards as they were.
(function () {
  "use strict";
  const PAPER = 920; // width in pixels; print.css shrinks it to what lies between margins of A4
  let before = []; // figures, their curves and their layouts on the screen

  function inLight(part, light) {
    if (typeof part === "string") return light[part.toLowerCase()] || part;
    if (Array.isArray(part)) return part.map(function (one) { return inLight(one, light); });
    // numbers of curves are arrays of another kind
    if (!part || Object.getPrototypeOf(part) !== Object.prototype) return part;
    return Object.fromEntries(Object.entries(part).map(function ([key, value]) {
      return [key, inLight(value, light)];
    }));
  }

  function draw(plot, data, layout) {
    window.Plotly.react(plot, data, layout);
    window.Plotly.redraw(plot); // plotly places legends by the width before
  }

  window.addEventListener("beforeprint", function () {
    const dark = document.documentElement.dataset.theme === "dark";
    const light = dark ? JSON.parse(document.getElementById("page").dataset.light) : {};
    before = Array.from(
      document.querySelectorAll("section:not([hidden]) .js-plotly-plot"),
      function (plot) { return [plot, plot.data, plot.layout]; },
    );
    before.forEach(function ([plot, data, layout]) {
      const wide = Object.assign(inLight(layout, light), { width: PAPER });
      draw(plot, inLight(data, light), wide);
    });
  });
  window.addEventListener("afterprint", function () {
    before.forEach(function ([plot, data, layout]) { draw(plot, data, layout); });
    before = [];
  });
})();
