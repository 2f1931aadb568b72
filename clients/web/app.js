// The page: reads the state every second, shows it, writes what people set.

import { getFields, getState, Gone, Problem } from "/api.js";
import { askToken } from "/login.js";
import { Rose } from "/rose.js";
import { beaufort, Sections, sunFixed } from "/sections.js";
import { Views } from "/views.js";

const POLL_MS = 1000;
const MOVING_MS = 250; // while the ship's attitude changes by itself
const byId = (id) => document.getElementById(id);

let state = {};
let fields = new Map();
let sections = null;
let frame = null;

const rose = new Rose(byId("rose"));
const views = new Views(byId("views"), {
  limits: (name) => {
    const field = fields.get(`views.*.${name}`) ?? {};
    return [field.minimum ?? 1, field.maximum ?? 150];
  },
  chosen: () => sections?.show(state, true),
  told: (next) => showState(next),
  frameShown: (shown) => {
    frame = shown;
  },
  expect: (name, change) => {
    for (const [field, value] of Object.entries(change)) {
      const control = name === views.name &&
        sections?.find(field === "fieldOfView" ? "field-of-view" : field);
      if (control) {
        control.touched = performance.now();
        control.set(value);
      }
    }
  },
});

// --- showing ----------------------------------------------------------------

function timeText(s) {
  const seconds = frame?.time ?? s.clock?.time ?? 0;
  const epoch = Date.parse(s.clock?.utc ?? "");
  if (Number.isNaN(epoch)) {
    return `${seconds.toFixed(1)} s`;
  }
  const at = new Date(epoch + 1000 * seconds).toISOString();
  return `${at.slice(0, 10)} ${at.slice(11, 19)} UTC`;
}

function showState(next) {
  state = next;
  views.show(state);
  sections.show(state);
  byId("no-views").hidden = (state.views ?? []).length > 0;
  byId("revision").textContent = state.revision ?? "0";
  const wind = state.sea?.windSpeed ?? 0;
  rose.show({
    wind: state.sea?.windDirection ?? 0, speed: wind, force: beaufort(wind),
    sun: sunFixed(state) ? state.sky.sunAzimuth : undefined,
    ship: sections.ship(state)?.heading,
  });
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
  byId("time").textContent = timeText(state);
}

// --- what is shown besides pictures ---------------------------------------------

function toggle(name, initial, apply) {
  const key = `pelagos-${name}`;
  const node = byId(name);
  let on = (localStorage.getItem(key) ?? String(initial)) === "true";
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

toggle("instruments", true, (on) => views.setInstruments(on));
toggle("controls", true, (on) => {
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
  if (key === "o") {
    byId("instruments").click();
  } else if (key === "c") {
    byId("controls").click();
  } else if (key === "Escape") {
    tile?.node.classList.remove("filled");
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

function begin(answer) {
  fields = new Map(answer.fields.map((f) => [f.path, f]));
  sections = new Sections(fields, views, showState);
}

async function poll() {
  let next = state.ownShip?.on ? MOVING_MS : POLL_MS;
  try {
    if (!sections) {
      begin(await getFields());
    }
    showState(await getState());
    showLink(true);
  } catch (error) {
    if (error instanceof Problem && error.status === 401) {
      showLink(false, "The server asks for a token.");
      askToken(error.message, poll);
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
      setTimeout(poll, next);
    }
  }
}

document.addEventListener("state", (event) => showState(event.detail));
document.addEventListener("keydown", onKey);
byId("panel").addEventListener("submit", (event) => event.preventDefault());
setInterval(refresh, 500);
poll();
