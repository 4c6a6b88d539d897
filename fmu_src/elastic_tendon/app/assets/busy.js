// The page looks at the work under way a few times a second; steps are told only when it begins or
// ends.
(function () {
  "use strict";
  window.dash_clientside = window.dash_clientside || {};
  window.dash_clientside.elastic_tendon_busy = {
    follow: function (hidden, told) {
      return !hidden === told ? window.dash_clientside.no_update : !hidden;
    },
  };
})();
