// The page: the pictures first, then the state every second; what the controls
// need is loaded when a picture is there.

import { Gone, inTurn, perform, Problem } from "/api.js";
import { firstState } from "/early.js";
import { addView, clearSilent, silentInputs } from "/inputs.js";
import { link, missing } from "/link.js";
import { learn } from "/rights.js";
import { Store } from "/store.js";
import { videoKnown } from "/video.js";
import { Views } from "/views.js";

const POLL_MS = 1000;
const HEALTH_MS = 15000;
const MOVING_MS = 250; // while the ship's attitude changes by itself
const PATIENCE_MS = 700; // with a first picture, before the controls
const byId = (id) => document.getElementById(id);

let soon = null;
let fields = new Map();
let controls = null; // controls.js
let frame = null;

const store = new Store({
  shown: () => showSoon(),
  followed: (before, after) => controls?.followed(before, after),
});
const views = new Views(byId("views"), store, {
  limits: (name) => {
    const field = fields.get(`views.*.${name}`) ?? {};
    return [field.minimum ?? 1, field.maximum ?? 150];
  },
  chosen: () => controls?.show(true),
  frameShown: (shown) => {
    frame = shown;
    firstPicture();
  },
});

// Simulated time of the picture that is shown, else of what the server said;
// changes that are asked for are made by it, so it cannot be of their state.
const now = () => frame?.time ?? store.told.clock?.time ?? 0;

// --- showing ----------------------------------------------------------------

function timeText(s) {
  const seconds = now();
  const epoch = Date.parse(s.clock?.utc ?? "");
  if (Number.isNaN(epoch)) {
    return `${seconds.toFixed(1)} s`;
  }
  const at = new Date(epoch + 1000 * seconds).toISOString();
  return `${at.slice(0, 10)} ${at.slice(11, 19)} UTC`;
}

function show() {
  clearTimeout(soon);
  soon = null;
  const { state } = store;
  views.show();
  controls?.show();
  byId("no-views").hidden = (state.views ?? []).length > 0;
  const none = missing(state.views ?? []);
  byId("no-such").hidden = none.length === 0;
  byId("no-such").textContent = none.length === 0 ? "" :
    `The address asks for ${none.join(", ")}; the server has ${
      (state.views ?? []).map((view) => view.name).join(", ") || "no view"}.`;
  byId("revision").textContent = state.revision ?? "0";
  const silent = silentInputs(state);
  byId("silent").hidden = silent === "";
  byId("silent-names").textContent = silent;
}

// Show the server's words on edits that do not reach the disk.
async function showHealth() {
  const health = document.hidden ? null
    : await fetch("/healthz", { cache: "no-store" })
      .then((answer) => answer.json(), () => null).catch(() => null);
  if (health) {
    const reasons = (health.degraded ?? []).map((one) => one.reason);
    byId("degraded").hidden = reasons.length === 0;
    byId("degraded").textContent = reasons.length === 0 ? ""
      : `The server is not well: ${reasons.join("; ")}.`;
  }
}

// Once for all that is asked for within one frame of the screen.
function showSoon() {
  soon = soon ?? setTimeout(show, 8);
}

function showLink(up, text) {
  views.setUp(up);
  byId("link").dataset.state = up ? "up" : "down";
  byId("link").textContent = up ? "connected" : "no connection";
  byId("gone").hidden = up;
  byId("gone").textContent = text ?? "";
}

function refresh() {
  const total = views.refresh();
  byId("fps").textContent = total ? `${total.toFixed(total < 10 ? 1 : 0)} fps`
    : "–";
  byId("time").textContent = timeText(store.state);
  byId("host").hidden = !frame?.host;
  byId("host-frame").textContent = frame?.host ?? "–";
}

// --- what is shown besides pictures ---------------------------------------------

// given: what the address says, for this page only.
function toggle(name, initial, given, apply) {
  const key = `pelagos-${name}`;
  const node = byId(name);
  let on = given ?? (localStorage.getItem(key) ?? String(initial)) === "true";
  const show = () => {
    node.setAttribute("aria-pressed", String(on));
    apply(on);
  };
  node.addEventListener("click", () => {
    on = !on;
    localStorage.setItem(key, String(on));
    show();
  });
  show();
}

toggle("instruments", true, link.hud, (on) => views.setInstruments(on));
// The plan is small beside the pictures, or large above them.
toggle("large", false, link.plan, (on) => {
  byId(on ? "plan-large" : "plan-small").append(byId("plan-box"));
  byId("plan-large").hidden = !on;
  document.body.classList.toggle("planned", on);
  byId("plan-away").hidden = !on;
  views.lay();
});
const walled = link.view !== null || link.layout === "wall";
toggle("controls", true, link.panel ?? (walled ? false : null), (on) => {
  document.body.classList.toggle("bare", !on);
  byId("aside").hidden = !on;
  views.lay();
});

// --- keys -------------------------------------------------------------------

const TURNS = { ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, 2],
  ArrowDown: [0, -2] };
const ZOOMS = { "+": 1 / 1.15, "=": 1 / 1.15, "-": 1.15, "−": 1.15 };

function onKey(event) {
  const busy = event.target.closest("input, select, textarea, dialog");
  if (busy || event.ctrlKey || event.metaKey || event.altKey) {
    return;
  }
  const tile = views.chosen;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (key === "p") {
    byId("large").click();
  } else if (key === "o") {
    byId("instruments").click();
  } else if (key === "c") {
    byId("controls").click();
  } else if (key === "Escape") {
    views.leaveFull();
    return;
  } else if (tile && key === "f") {
    tile.fullScreen();
  } else if (tile && TURNS[key]) {
    const by = event.shiftKey ? 0.2 : 1;
    tile.look.turn(tile.view, ...TURNS[key].map((degrees) => degrees * by));
  } else if (tile && ZOOMS[key]) {
    tile.look.zoom(tile.view, ZOOMS[key]);
  } else {
    return;
  }
  event.preventDefault();
}

// --- life -------------------------------------------------------------------

let firstPicture;
const pictured = Promise.race([
  new Promise((resolve) => {
    firstPicture = resolve;
  }),
  new Promise((resolve) => {
    setTimeout(resolve, PATIENCE_MS);
  }),
]);

async function begin() {
  await pictured;
  const [{ Controls }, answer] = await Promise.all([import("/controls.js"),
    inTurn(() => perform("GET", "/v1/fields")), learn()]);
  fields = new Map(answer.fields.map((f) => [f.path, f]));
  controls = new Controls(fields, views, store, now);
  show();
  byId("panel").classList.remove("waiting");
  (await import("/tour.js")).showTour();
}

let beginning = null;

async function poll(first) {
  let next = POLL_MS;
  try {
    await store.read(first);
    show();
    const { ownShip, entities = [] } = store.told;
    next = ownShip?.on || entities.some((e) => e.helm?.on) ? MOVING_MS
      : POLL_MS;
    controls?.heard();
    showLink(true);
    beginning = beginning ?? begin().catch(() => {
      beginning = null; // again, with the next answer
    });
  } catch (error) {
    if (error instanceof Problem && error.status === 401) {
      showLink(false, "The server asks for a token.");
      (await import("/login.js")).askToken(error.message, () => {
        if (controls) {
          location.reload(); // another token may do other things
        } else {
          poll();
        }
      });
      next = null; // goes on with the token
    } else if (error instanceof Problem) {
      showLink(false, `The server refuses: ${error.message}`);
    } else if (error instanceof Gone) {
      showLink(false, "The server does not answer. Is pelagosd running? " +
        "This page goes on by itself as soon as it is back.");
    } else {
      throw error;
    }
  } finally {
    if (next !== null) {
      setTimeout(() => poll(), next);
    }
  }
}

document.addEventListener("keydown", onKey);
byId("silent-clear").addEventListener("click", () => clearSilent(store));
byId("add-view").addEventListener("click", () => addView(store));
byId("about-open").addEventListener("click", async () =>
  (await import("/about.js")).showAbout());
byId("panel").addEventListener("submit", (event) => event.preventDefault());
setInterval(refresh, 500);
setInterval(showHealth, HEALTH_MS);
setTimeout(showHealth, 1000); // after the pictures
videoKnown.then(() => poll(firstState));
document.documentElement.dataset.runs = ""; // for before.js
