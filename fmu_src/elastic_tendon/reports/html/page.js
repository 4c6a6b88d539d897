// Figures are drawn when they come near the window, so that the page opens at once; before printing
// all of them are, in the light theme and as wide as the paper.
"use strict";
(() => {
  const PAPER = 920; // width in pixels; the style shrinks it to what lies between margins of A4
  const LOW = 0.75; // of the height of a tall figure, so that more of them share a sheet
  const TALL = 300; // pixels
  const NEAR = "300px";
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const holders = [...document.querySelectorAll(".drawing")];
  const drawn = new Set();
  let printing = false;

  const read = (id) => JSON.parse(document.getElementById(id).textContent);

  function change(tree, changes) {
    for (const [key, value] of Object.entries(changes)) {
      const within = tree[key] !== null && typeof tree[key] === "object";
      if (within && value !== null && typeof value === "object" && !Array.isArray(value)) {
        change(tree[key], value);
      } else {
        tree[key] = value;
      }
    }
  }

  function draw(holder) {
    const figure = read(holder.dataset.figure);
    if (dark.matches && !printing) {
      change(figure, read(`${holder.dataset.figure}-dark`));
    }
    if (printing) {
      figure.layout.width = PAPER;
    }
    const { height } = holder.dataset;
    figure.layout.height = height * (printing && height > TALL ? LOW : 1);
    holder.style.height = `${figure.layout.height}px`;
    drawn.add(holder);
    Plotly.react(holder, figure.data, figure.layout, CONFIG);
  }

  const watcher = new IntersectionObserver(
    (entries) => {
      for (const { target, isIntersecting } of entries) {
        if (isIntersecting && !drawn.has(target)) {
          watcher.unobserve(target);
          draw(target);
        }
      }
    },
    { rootMargin: NEAR },
  );
  holders.forEach((holder) => watcher.observe(holder));

  dark.addEventListener("change", () => [...drawn].forEach(draw));
  window.addEventListener("beforeprint", () => {
    printing = true;
    holders.forEach(draw);
  });
  window.addEventListener("afterprint", () => {
    printing = false;
    holders.forEach(draw);
  });
})();
