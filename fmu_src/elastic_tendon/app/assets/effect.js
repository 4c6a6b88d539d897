// What was tried comes into sight once, when its curves are there.
(function () {
  "use strict";
  let seen = 0;
  window.dash_clientside = window.dash_clientside || {};
  window.dash_clientside.elastic_tendon_effect = {
    show: function (tried, pressed) {
      if (tried && tried.length && (pressed || 0) > seen) {
        seen = pressed;
        window.requestAnimationFrame(function () {
          document.getElementById("effect-tried").scrollIntoView({ block: "start" });
        });
      }
      return window.dash_clientside.no_update;
    },
  };
})();
