// Runs first, and in every browser: gives older ones what the page calls and
// they lack, and where the page cannot run at all says so, with pictures. No
// newer than ECMAScript 5.
(function () {
  "use strict";
  // The oldest that the page is for; tests/page_minimum_test.mjs holds it to it.
  var MINIMUM = { Chromium: 87, Firefox: 78, Safari: 15 };
  var AGAIN_MS = 200;

  // --- what older browsers lack -----------------------------------------------

  function give(on, name, work) {
    if (on && !(name in on)) {
      Object.defineProperty(on, name, { value: work, writable: true,
        configurable: true });
    }
  }

  function at(index) {
    var i = Math.trunc(index) || 0;
    return this[i < 0 ? this.length + i : i];
  }

  function findLastIndex(test, self) {
    for (var i = this.length - 1; i >= 0; i--) {
      if (test.call(self, this[i], i, this)) {
        return i;
      }
    }
    return -1;
  }

  give(Array.prototype, "at", at);
  give(Array.prototype, "findLastIndex", findLastIndex);
  give(Array.prototype, "findLast", function (test, self) {
    return this[findLastIndex.call(this, test, self)];
  });
  // Replaces a text, not a pattern.
  give(String.prototype, "replaceAll", function (what, by) {
    return this.split(what).join(by);
  });
  give(window.AbortSignal, "timeout", function (ms) {
    var control = new AbortController();
    setTimeout(function () {
      control.abort();
    }, ms);
    return control.signal;
  });
  give(window.CanvasRenderingContext2D && CanvasRenderingContext2D.prototype,
    "roundRect", function (x, y, w, h, r) {
      this.moveTo(x + r, y);
      this.arcTo(x + w, y, x + w, y + h, r);
      this.arcTo(x + w, y + h, x, y + h, r);
      this.arcTo(x, y + h, x, y, r);
      this.arcTo(x, y, x + w, y, r);
      this.closePath();
    });

  // Dialogs that are no element of this browser: style.css shows them by their
  // attribute.
  if (!window.HTMLDialogElement && window.HTMLUnknownElement) {
    document.documentElement.className += " no-dialog";
    var dialogs = HTMLUnknownElement.prototype;
    Object.defineProperty(dialogs, "open", { configurable: true,
      get: function () {
        return this.hasAttribute("open");
      } });
    give(dialogs, "showModal", function () {
      this.setAttribute("open", "");
      this.setAttribute("role", "dialog");
      this.setAttribute("aria-modal", "true");
    });
    give(dialogs, "close", function () {
      this.removeAttribute("open");
      this.dispatchEvent(new Event("close"));
    });
    document.addEventListener("keydown", function (event) {
      var open = document.querySelector("dialog[open]");
      if (event.key === "Escape" && open && open.dispatchEvent(
        new Event("cancel", { cancelable: true })) && !open.oncancel) {
        open.close();
      }
    });
  }

  // --- where the page does not run -----------------------------------------------

  var token = (/[#&]token=([^&]*)/.exec(location.hash) || [])[1] || "";
  var note;

  function say(text) {
    note.textContent = text;
  }

  function ask(path, type, done) {
    var request = new XMLHttpRequest();
    request.open("GET", path);
    request.responseType = type;
    if (token) {
      request.setRequestHeader("Authorization", "Bearer " + token);
    }
    request.onload = function () {
      done(request.status, request.response);
    };
    request.onerror = function () {
      done(0, null);
    };
    request.send();
  }

  // One picture after the other, for a token that an address of a picture
  // cannot carry and for browsers that play no Motion-JPEG.
  function single(image, view) {
    ask("/v1/views/" + encodeURIComponent(view) + "/frame.jpg", "blob",
      function (status, blob) {
        if (status === 200) {
          var url = URL.createObjectURL(blob);
          image.onload = image.onerror = function () {
            URL.revokeObjectURL(url);
          };
          image.src = url;
        }
        setTimeout(function () {
          single(image, view);
        }, status === 200 ? AGAIN_MS : 5 * AGAIN_MS);
      });
  }

  function show(views) {
    var place = document.getElementById("plain-views");
    for (var i = 0; i < views.length; i++) {
      var image = document.createElement("img");
      var name = views[i].name;
      image.alt = "View " + name;
      place.appendChild(image);
      if (token) {
        single(image, name);
      } else {
        image.onerror = (function (of, named) {
          return function () {
            of.onerror = null;
            single(of, named);
          };
        })(image, name);
        image.src = "/v1/views/" + encodeURIComponent(name) + "/mjpeg";
      }
    }
  }

  function askToken() {
    var form = document.createElement("form");
    var input = document.createElement("input");
    input.type = "password";
    input.setAttribute("aria-label", "Token");
    form.appendChild(input);
    form.onsubmit = function () {
      token = input.value.replace(/^\s+|\s+$/g, "");
      form.parentNode.removeChild(form);
      begin();
      return false;
    };
    note.parentNode.insertBefore(form, note.nextSibling);
    input.focus();
  }

  function begin() {
    ask("/v1/views", "text", function (status, body) {
      if (status === 0) {
        say("The server does not answer. Is pelagosd running? Load this page " +
          "again when it is.");
      } else if (status === 401) {
        say("The server asks for its token:");
        askToken();
      } else if (status !== 200) {
        say("The server refuses its list of views: HTTP " + status + ".");
      } else {
        // theme.js is as new as the page's other parts.
        say(document.documentElement.getAttribute("data-theme")
          ? "A part of this page did not begin, so here are its pictures " +
            "alone. Load it again."
          : "This browser is too old for this page: it takes Chromium, " +
            "Chrome, Edge or Qt WebEngine with Chromium " + MINIMUM.Chromium +
            ", Firefox " + MINIMUM.Firefox + " or Safari " + MINIMUM.Safari +
            ", or newer. Here are its pictures alone.");
        show(JSON.parse(body).views || []);
      }
    });
  }

  function onLoad() {
    if (!document.documentElement.hasAttribute("data-runs")) { // app.js
      note = document.getElementById("plain-note");
      document.body.className += " plain-page";
      begin();
    }
  }

  if (window.addEventListener) {
    window.addEventListener("load", onLoad, false);
  }
})();
