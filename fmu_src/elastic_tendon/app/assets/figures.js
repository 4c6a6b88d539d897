// What draws figures is large, and while it begins nothing else moves. Figures wait for
// window.Plotly: so that is a promise until the page shows what it asked for first.
(function () {
  "use strict";
  const QUIET = 50, LATEST = 1000; // ms: without a question to the server; after the session came
  const ask = window.fetch;
  let waiting = 0;
  let latest = 0; // timer
  let begin;

  window.Plotly = new Promise(function (resolve, reject) {
    begin = function () {
      const script = document.createElement("script");
      script.src = window._dashPlotlyJSURL;
      script.onload = resolve;
      script.onerror = reject;
      document.head.appendChild(script);
      begin = function () {};
    };
  });

  function look() {
    const place = document.getElementById("where-we-are"); // filled with the session
    if (!place || !place.textContent) return;
    latest = latest || window.setTimeout(function () { begin(); }, LATEST);
    if (!waiting) begin();
  }

  window.fetch = function () {
    waiting += 1;
    return ask.apply(this, arguments).finally(function () {
      waiting -= 1;
      window.setTimeout(look, QUIET);
    });
  };
})();
