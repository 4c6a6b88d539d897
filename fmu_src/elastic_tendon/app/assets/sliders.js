// A slider moves faster than the page's callbacks answer. So its curves are asked of the server
// directly, one question at a time, the latest last; the callbacks, which also keep what was moved
// and fill the tables, follow once the hand rests.
(function () {
  "use strict";
  const DIGITS = 4; // of a number that was moved
  const SHOWN = 6; // of one that was not, as in the step Model
  const PATIENCE = 3000; // ms for an answer, which may be that nothing has to be drawn
  const REST = 250; // ms without a move, after which the callbacks follow
  const SLIDERS = "#compare-sliders input[type=range]";
  let next; // what is to be asked of the callbacks, undefined where that is nothing
  let waiting = 0; // timer
  let taken = null; // the button by which they were taken: it is hidden until all is compared anew
  let known = null; // numbers of the model
  let drawn = null; // what the curves show
  let asking = false; // the server for curves
  let again = false;
  const held = new Set(); // sliders that were moved and of which the callbacks know nothing yet
  let resting = 0; // timer

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

  function valueOf(path, place) {
    const given = known.values[path];
    return Number(place) === given ? given : Number(Number(place).toPrecision(DIGITS));
  }

  function told(path, value) {
    const text = String(Number(value.toPrecision(SHOWN))).replace(/-/g, "−");
    return (text + " " + known.units[path]).trim();
  }

  // Those that were moved, of [path, place] of all.
  function movedOf(places) {
    const moved = {};
    places.forEach(function ([path, place]) {
      const value = valueOf(path, place);
      if (value !== known.values[path]) moved[path] = value;
    });
    return moved;
  }

  function pathOf(slider) {
    return JSON.parse(slider.id)["compare-slider"];
  }

  // ---- while the hand moves ----------------------------------------------------------------

  function follow() {
    if (asking) {
      again = true;
      return;
    }
    asking = true;
    const places = Array.from(document.querySelectorAll(SLIDERS), function (slider) {
      return [pathOf(slider), slider.value];
    });
    const body = JSON.stringify({ id: drawn.id, key: drawn.rest, values: movedOf(places) });
    const headers = { "Content-Type": "application/json" };
    window.fetch("moved", { method: "POST", headers, body }).then(function (response) {
      return response.status === 200 ? response.json().then(show) : letGo();
    }).catch(letGo).finally(function () {
      asking = false;
      if (again) {
        again = false;
        follow();
      }
    });
  }

  function show(found) {
    const graph = document.querySelector("#compare-overlay .js-plotly-plot");
    const changed = {};
    ["x", "y", "name"].forEach(function (part) {
      changed[part] = found.curves.map(function (curve) { return unpacked(curve[part]); });
    });
    const places = found.curves.map(function (_, index) { return found.first + index; });
    return window.Plotly.restyle(graph, changed, places);
  }

  function unpacked(part) {
    if (!part || !part.bdata) return part;
    const bytes = window.atob(part.bdata);
    return new Float64Array(Uint8Array.from(bytes, function (one) {
      return one.charCodeAt(0);
    }).buffer);
  }

  // The callbacks get to know what was moved.
  function letGo() {
    window.clearTimeout(resting);
    const moved = Array.from(held);
    held.clear();
    moved.forEach(function (slider) {
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    });
  }

  document.addEventListener("input", function (event) {
    const quick = event.isTrusted && event.target.matches(SLIDERS) && known && drawn;
    if (!quick || !drawn.curves) return;
    event.stopPropagation();
    const path = pathOf(event.target);
    document.getElementById(JSON.stringify({ "compare-moved-to": path })).textContent =
      told(path, valueOf(path, event.target.value));
    held.add(event.target);
    window.clearTimeout(resting);
    resting = window.setTimeout(letGo, REST);
    follow();
  }, true);

  // the end of a move, of which the callbacks would make another one
  document.addEventListener("change", function (event) {
    if (held.has(event.target)) event.stopPropagation();
  }, true);

  document.addEventListener("focusout", letGo, true);
  document.addEventListener("pointerdown", letGo, true);
  document.addEventListener("click", function (event) {
    if (event.target.id === "compare-take") taken = event.target;
  });

  // ---- once it rests -----------------------------------------------------------------------

  window.dash_clientside = window.dash_clientside || {};
  window.dash_clientside.elastic_tendon_sliders = {
    move: function (places, ids, numbers, before) {
      known = numbers;
      if (!numbers) return []; // no sliders yet
      const all = places.map(function (place, i) { return [ids[i]["compare-slider"], place]; });
      const moved = movedOf(all);
      const now = Object.keys(moved).length ? { of: numbers.of, values: moved } : null;
      const asked = next === undefined ? before || null : next;
      if (JSON.stringify(now) !== JSON.stringify(asked)) {
        next = now;
        ask();
      }
      return all.map(function ([path, place]) { return told(path, valueOf(path, place)); });
    },
    drawn: function (now) {
      drawn = now || null;
      go();
      if (now && taken) window.requestAnimationFrame(giveFocusBack);
    },
  };
})();
