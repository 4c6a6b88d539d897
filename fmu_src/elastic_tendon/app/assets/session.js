// What the browser does by itself: it keeps the session, sets the look, moves the focus, and tells
// when the server does not answer.
(function () {
  "use strict";
  const KEY = "elastic-tendon " + window.location.pathname; // the path holds this server's token
  const LOOK = "elastic-tendon look";

  function look() {
    const chosen = window.localStorage.getItem(LOOK);
    if (chosen) return chosen;
    return window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  }

  // A figure that was drawn while it was hidden has plotly's own width; not all others are redrawn.
  // One whose width has changed is drawn once more: plotly places legends by the width before.
  function fit() {
    if (window.matchMedia("print").matches) return; // see print.js
    document.querySelectorAll("section:not([hidden]) .js-plotly-plot").forEach(function (plot) {
      const drawn = plot.querySelector(".main-svg");
      const room = plot.parentElement.clientWidth;
      if (!drawn || !room) return;
      if (Math.abs(drawn.clientWidth - room) > 2) {
        window.Plotly.Plots.resize(plot);
        plot.placedFor = 0;
      } else if (plot.placedFor !== room) {
        if (plot.placedFor !== undefined) window.Plotly.redraw(plot);
        plot.placedFor = room;
      }
    });
  }
  window.setInterval(fit, 400);

  // The page asks now and then whether the server is there, and goes on when it is there again.
  const BEAT = 4000, LOST = 1000; // ms between questions
  const ask = window.fetch;
  let lost = false;
  let leaving = false;

  function tell(words) {
    window.dash_clientside.set_props("lost", { children: words });
  }

  function lose() {
    const place = document.getElementById("lost");
    if (lost || leaving || !place) return;
    lost = true;
    tell(place.dataset.words);
  }

  function listen() {
    if (document.hidden && !lost) return;
    ask(window.location.pathname, { method: "HEAD", cache: "no-store" }).then(function (answer) {
      if (!answer.ok) lose();
      else if (lost && !leaving) window.location.reload();
    }, lose);
  }

  window.fetch = function () {
    return ask.apply(this, arguments).catch(function (error) {
      if (error.name !== "AbortError") lose();
      throw error;
    });
  };
  window.addEventListener("pagehide", function () { leaving = true; });
  document.addEventListener("visibilitychange", listen);
  let beats = 0;
  window.setInterval(function () {
    beats += 1;
    if (lost || beats % (BEAT / LOST) === 0) listen();
  }, LOST);

  // The focus goes to the head of a step as soon as that can be seen; before, it cannot have it.
  let awaited = "";

  function arrive(open) {
    if (open !== awaited) return; // another step was opened meanwhile
    const heading = document.getElementById(open + "-heading");
    if (!heading || !heading.offsetParent) {
      window.requestAnimationFrame(function () { arrive(open); });
      return;
    }
    heading.focus({ preventScroll: true });
    window.scrollTo(0, 0);
    fit();
  }

  let shown = false; // the first step that is shown after a reload is not the one it was at
  window.addEventListener("popstate", function (event) {
    if (event.state) window.dash_clientside.set_props("open", { data: event.state.step });
  });

  window.dash_clientside = window.dash_clientside || {};
  window.dash_clientside.elastic_tendon = {
    remember: function () {
      try {
        return JSON.parse(window.sessionStorage.getItem(KEY)) || {};
      } catch (error) {
        return {};
      }
    },
    keep: function (session, open) {
      if (session) {
        window.sessionStorage.setItem(KEY, JSON.stringify({ session: session, open: open }));
      }
      return window.dash_clientside.no_update;
    },
    // the session's news go on to the step that is open
    pass: function (session, open, ...ids) {
      return ids.map(function (id) {
        return session && id === open + "-session" ? session : window.dash_clientside.no_update;
      });
    },
    look: function (clicks) {
      if (clicks) {
        window.localStorage.setItem(LOOK, look() === "dark" ? "light" : "dark");
      }
      const now = look();
      document.documentElement.dataset.theme = now;
      return [now, now === "dark" ? "Light" : "Dark"];
    },
    show: function (open, sections) {
      const at = window.history.state;
      if (!at) window.history.replaceState({ step: open }, "");
      else if (shown && at.step !== open) window.history.pushState({ step: open }, "");
      shown = true;
      awaited = open;
      arrive(open);
      const opened = sections.map(function (section) { return section.section === open; });
      return [
        opened.map(function (is) { return !is; }),
        opened.map(function (is) { return is ? "step" : "false"; }),
      ];
    },
  };
})();
