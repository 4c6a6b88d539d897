// Which stretch of time is seen is decided by the browser alone: no answer of the server, early or
// late, can undo what the user did.
(function () {
  "use strict";
  const ALL = [null, null];

  function round(value, span) {
    return Number(value.toFixed(span.decimals));
  }

  // As far as there was a recording; null where that is all of it, or nothing.
  function within(span, ends) {
    const given = ends.map(function (one) { return typeof one === "number"; });
    const low = Math.max(given[0] ? round(ends[0], span) : span.first, span.first);
    const high = Math.min(given[1] ? round(ends[1], span) : span.last, span.last);
    if (low >= high || (low === span.first && high === span.last)) return null;
    return [low, high];
  }

  window.dash_clientside = window.dash_clientside || {};
  window.dash_clientside.elastic_tendon_compare = {
    // A figure tells much that the user did not do, as that its size has changed. What is forgotten
    // may come again.
    gesture: function (told) {
      const same = window.dash_clientside.no_update;
      if (told && told["xaxis.autorange"]) return [ALL, null];
      if (!told || !("xaxis.range[0]" in told)) return [same, same];
      return [[told["xaxis.range[0]"], told["xaxis.range[1]"]], null];
    },
    zoom: function (here, there, from, to, reset, resetThere, mark, spans, seen) {
      const same = window.dash_clientside.no_update;
      if (!spans) return [same, same, same];
      const typed = ["compare", [from, to]];
      const asked = {
        "compare-gesture": ["compare", here],
        "where-gesture": ["where", there],
        "compare-from": typed,
        "compare-to": typed,
        "compare-reset": ["compare", ALL],
        "where-reset": ["where", ALL],
      };
      // a mark undoes the stretch that hid it, and no later one
      const hid = mark && mark.undoes && JSON.stringify(mark.undoes) === JSON.stringify(seen);
      if (hid) asked["where-mark"] = ["where", ALL];
      let now = seen;
      window.dash_clientside.callback_context.triggered.forEach(function (one) {
        const [step, ends] = asked[one.prop_id.split(".")[0]] || [];
        const span = spans[step];
        if (span) now = { recording: span.recording, window: within(span, ends) };
      });
      const looked = spans.compare && now && now.recording === spans.compare.recording;
      const [low, high] = (looked && now.window) || ["", ""];
      return [now === seen ? same : now, low === from ? same : low, high === to ? same : high];
    },
  };
})();
