// What sliders are moved to is asked of the server one at a time, the latest last: a slider moves
// faster than curves are drawn.
(function () {
  "use strict";
  const DIGITS = 4; // of a number that was moved
  const SHOWN = 6; // of one that was not, as in the step Model
  const PATIENCE = 3000; // ms for an answer, which may be that nothing has to be drawn
  let next; // what is to be asked, undefined where that is nothing
  let waiting = 0; // timer
  let taken = null; // the button by which they were taken: it is hidden until all is compared anew

  document.addEventListener("click", function (event) {
    if (event.target.id === "compare-take") taken = event.target;
  });

  function giveFocusBack() {
    if (taken && document.activeElement === document.body) taken.focus({ preventScroll: true });
    taken = null;
  }

  function ask() {
    if (waiting || next === undefined) return;
    waiting = window.setTimeout(go, PATIENCE);
    window.dash_clientside.set_props("compare-moved", { data: next });
    next = undefined;
  }

  function go() {
    window.clearTimeout(waiting);
    waiting = 0;
    ask();
  }

  window.dash_clientside = window.dash_clientside || {};
  window.dash_clientside.elastic_tendon_sliders = {
    move: function (places, ids, numbers, held) {
      if (!numbers) return []; // no sliders yet
      const moved = {};
      const told = places.map(function (place, i) {
        const path = ids[i]["compare-slider"], given = numbers.values[path];
        const value = Number(place) === given ? given : Number(Number(place).toPrecision(DIGITS));
        if (value !== given) moved[path] = value;
        const text = String(Number(value.toPrecision(SHOWN))).replace(/-/g, "−");
        return (text + " " + numbers.units[path]).trim();
      });
      const now = Object.keys(moved).length ? { of: numbers.of, values: moved } : null;
      const asked = next === undefined ? held || null : next;
      if (JSON.stringify(now) !== JSON.stringify(asked)) {
        next = now;
        ask();
      }
      return told;
    },
    drawn: function (now) {
      go();
      if (now && taken) window.requestAnimationFrame(giveFocusBack);
    },
  };
})();
