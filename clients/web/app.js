// The page: reads the state every second, shows it, writes what people set.

import { getFields, getState, Gone, Problem, stepClock } from "/api.js";
import { button, Check, Choice, Range, Text } from "/panel.js";
import { Rose } from "/rose.js";
import { Views } from "/views.js";

const POLL_MS = 1000;
const byId = (id) => document.getElementById(id);

let state = {};
let fields = new Map();
let shipId = null;
let controls = [];
let frame = null;

const rose = new Rose(byId("rose"));
const views = new Views(byId("views"), () => showState(state), (shown) => {
  frame = shown;
});

// --- what the state holds ---------------------------------------------------

const entities = (s) => s.entities ?? [];
const ship = (s) => entities(s).find((e) => String(e.id ?? 0) === shipId);
const view = (s) => (s.views ?? []).find((v) => v.name === views.name);
const sunFixed = (s) => s.sky?.sunElevation !== undefined &&
  s.sky?.sunAzimuth !== undefined;
const swell = (s) => (s.sea?.swell ?? [])[0];

function patchSwell(change) {
  const trains = structuredClone(state.sea?.swell ?? []);
  trains[0] = { ...trains[0], ...change };
  return { sea: { swell: trains } };
}

const patchShip = (change) => ({ entities: { [shipId]: change } });
const patchView = (change) => ({ views: { [views.name]: change } });

// --- controls ---------------------------------------------------------------

const unitNames = { "m/s": "metres per second", "°": "degrees", m: "metres",
  s: "seconds", "×": "times", "": "" };

// path: of the field that gives the range; narrow: what the slider shows of it.
function range(parent, label, path, unit, step, get, patch, more = {}) {
  const field = fields.get(path) ?? {};
  const control = new Range(byId(parent), {
    id: more.id, label, unit, unitName: unitNames[unit] ?? unit, step,
    minimum: more.minimum ?? field.minimum ?? 0,
    maximum: more.maximum ?? field.maximum ?? 100,
    scale: more.scale, get, patch,
  });
  control.depends = more.depends;
  controls.push(control);
  return control;
}

function add(control, depends) {
  control.depends = depends;
  controls.push(control);
  return control;
}

function buildSea() {
  range("sea", "Wind speed", "sea.windSpeed", "m/s", 0.1,
    (s) => s.sea?.windSpeed, (v) => ({ sea: { windSpeed: v } }),
    { id: "wind-speed" });
  range("sea", "Wind from", "sea.windDirection", "°", 1,
    (s) => s.sea?.windDirection, (v) => ({ sea: { windDirection: v } }),
    { id: "wind-direction" });
  const seed = add(new Text(byId("sea"), {
    id: "seed", label: "Seed of the waves", type: "number",
    get: (s) => String(s.sea?.seed ?? 1),
    patch: (v) => ({ sea: { seed: Number(v) } }),
  }));
  seed.node.classList.add("with-button");
  seed.input.after(button(seed.node, "⚄", "Another seed", () => {
    seed.input.value = Math.floor(Math.random() * 100000);
    seed.write(seed.input.value);
  }));

  const on = (s) => swell(s) !== undefined;
  add(new Check(byId("swell"), {
    id: "swell-on", label: "A swell runs", get: on,
    patch: (v) => (v ? patchSwell({}) : { sea: { swell: [] } }),
  }));
  range("swell", "Height", "sea.swell.*.height", "m", 0.1,
    (s) => swell(s)?.height, (v) => patchSwell({ height: v }),
    { id: "swell-height", depends: on, maximum: 8 });
  range("swell", "Period", "sea.swell.*.period", "s", 0.5,
    (s) => swell(s)?.period, (v) => patchSwell({ period: v }),
    { depends: on });
  range("swell", "From", "sea.swell.*.direction", "°", 1,
    (s) => swell(s)?.direction, (v) => patchSwell({ direction: v }),
    { depends: on });
}

function buildSky() {
  add(new Check(byId("sky"), {
    id: "sun-clock", label: "Sun from the clock",
    get: (s) => !sunFixed(s),
    patch: (v) => (v
      ? { sky: { sunElevation: null, sunAzimuth: null } }
      : { sky: { sunElevation: 30, sunAzimuth: 200 } }),
  }));
  range("sky", "Sun elevation", "sky.sunElevation", "°", 0.5,
    (s) => s.sky?.sunElevation, (v) => ({ sky: { sunElevation: v } }),
    { id: "sun-elevation", depends: sunFixed, minimum: -18 });
  range("sky", "Sun azimuth", "sky.sunAzimuth", "°", 1,
    (s) => s.sky?.sunAzimuth, (v) => ({ sky: { sunAzimuth: v } }),
    { id: "sun-azimuth", depends: sunFixed });
  range("sky", "Visibility", "sky.visibility", "m", 100,
    (s) => s.sky?.visibility, (v) => ({ sky: { visibility: v } }),
    { id: "visibility", scale: "log" });
}

function buildShip() {
  add(new Choice(byId("ship"), {
    id: "ship-id", label: "Ship", get: () => shipId,
    chosen: (v) => {
      shipId = v;
      showState(state);
    },
  }));
  const there = (s) => ship(s) !== undefined;
  range("ship", "Heading", "entities.*.heading", "°", 1,
    (s) => ship(s)?.heading, (v) => patchShip({ heading: v }),
    { id: "heading", depends: there });
  range("ship", "Speed", "entities.*.speed", "m/s", 0.1,
    (s) => ship(s)?.speed, (v) => patchShip({ speed: v }),
    { depends: there, maximum: 25 });
}

function buildView() {
  add(new Choice(byId("view"), {
    id: "view-name", label: "Chosen view", get: () => views.name,
    chosen: (v) => views.choose(v),
  }));
  const there = (s) => view(s) !== undefined;
  range("view", "Yaw, to starboard of the bow", "views.*.yaw", "°", 1,
    (s) => view(s)?.yaw, (v) => patchView({ yaw: v }),
    { id: "yaw", depends: there, minimum: -180, maximum: 180 });
  range("view", "Pitch, upward", "views.*.pitch", "°", 0.5,
    (s) => view(s)?.pitch, (v) => patchView({ pitch: v }),
    { id: "pitch", depends: there, minimum: -60, maximum: 60 });
  range("view", "Height above the sea", "views.*.up", "m", 0.5,
    (s) => view(s)?.up, (v) => patchView({ up: v }),
    { depends: there, minimum: 1, maximum: 20000, scale: "log" });
  range("view", "Field of view", "views.*.fieldOfView", "°", 1,
    (s) => view(s)?.fieldOfView, (v) => patchView({ fieldOfView: v }),
    { depends: (s) => there(s) && view(s).frustum === undefined });
}

function buildClock() {
  add(new Choice(byId("clock"), {
    id: "clock-mode", label: "Time runs",
    options: [["FREE", "with the wall clock"], ["PACED", "frame by frame"],
      ["STEPPED", "by steps only"], ["HOST", "as a simulator says"]],
    get: (s) => s.clock?.mode, patch: (v) => ({ clock: { mode: v } }),
  }));
  range("clock", "Rate", "clock.rate", "×", 0.1,
    (s) => s.clock?.rate, (v) => ({ clock: { rate: v } }),
    { id: "rate", maximum: 10,
      depends: (s) => ["FREE", "PACED"].includes(s.clock?.mode) });
  add(new Text(byId("clock"), {
    id: "utc", label: "UTC at simulated time 0", type: "datetime-local",
    get: (s) => (s.clock?.utc ?? "").replace(/(\.\d+)?Z$/, ""),
    patch: (v) => ({ clock: { utc: `${v.length === 16 ? `${v}:00` : v}Z` } }),
  }));
  const step = button(byId("clock"), "Step 1 s", "Advance time by one second",
    async () => {
      try {
        showState(await stepClock(1));
      } catch (error) {
        if (!(error instanceof Problem || error instanceof Gone)) {
          throw error;
        }
      }
    });
  controls.push({
    show: () => {},
    depends: (s) => s.clock?.mode === "STEPPED",
    set enabled(enabled) {
      step.hidden = !enabled;
    },
  });
}

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
  if (!ship(state)) {
    const first = entities(state)[0];
    shipId = first ? String(first.id ?? 0) : null;
  }
  views.show(state.views ?? []);
  byId("no-views").hidden = (state.views ?? []).length > 0;
  byId("revision").textContent = state.revision ?? "0";
  for (const control of controls) {
    if (control.id === "ship-id") {
      control.setOptions(entities(state).map((e) =>
        [String(e.id ?? 0), e.name || `entity ${e.id ?? 0}`]));
    }
    if (control.id === "view-name") {
      control.setOptions((state.views ?? []).map((v) => [v.name, v.name]));
    }
    control.show(state);
    if (control.depends) {
      control.enabled = control.depends(state);
    }
  }
  rose.show({
    wind: state.sea?.windDirection ?? 0,
    speed: state.sea?.windSpeed ?? 0,
    sun: sunFixed(state) ? state.sky.sunAzimuth : undefined,
    ship: ship(state)?.heading,
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

// --- keys -------------------------------------------------------------------

const STEPS = { ArrowLeft: ["yaw", -5], ArrowRight: ["yaw", 5],
  ArrowUp: ["pitch", 2], ArrowDown: ["pitch", -2] };
const LIMITS = { yaw: 180, pitch: 90 };

function onKey(event) {
  const busy = event.target.closest("input, select, textarea");
  if (busy || event.ctrlKey || event.metaKey || event.altKey) {
    return;
  }
  if (event.key === "f" || event.key === "F") {
    views.chosen?.fullScreen();
    event.preventDefault();
  } else if (event.key === "Escape") {
    views.chosen?.node.classList.remove("filled");
  } else if (STEPS[event.key] && view(state)) {
    const [name, step] = STEPS[event.key];
    const control = controls.find((c) => c.id === name);
    let value = (control.pending ?? view(state)[name] ?? 0) +
      (event.shiftKey ? step / 5 : step);
    const limit = LIMITS[name];
    if (name === "yaw") {
      value = value > limit ? value - 360 : value < -limit ? value + 360 : value;
    }
    value = Math.max(-limit, Math.min(limit, value));
    control.set(value);
    control.write(value);
    event.preventDefault();
  }
}

// --- life -------------------------------------------------------------------


async function poll() {
  try {
    if (controls.length === 0) {
      const answer = await getFields();
      fields = new Map(answer.fields.map((f) => [f.path, f]));
      [buildSea, buildSky, buildShip, buildView, buildClock].forEach((b) => b());
    }
    showState(await getState());
    showLink(true);
  } catch (error) {
    if (error instanceof Problem) {
      showLink(false, `The server refuses: ${error.message}`);
    } else if (error instanceof Gone) {
      showLink(false, "The server does not answer. Is pelagosd running? " +
        "This page goes on by itself as soon as it is back.");
    } else {
      throw error;
    }
  } finally {
    setTimeout(poll, POLL_MS);
  }
}

document.addEventListener("state", (event) => showState(event.detail));
document.addEventListener("keydown", onKey);
byId("panel").addEventListener("submit", (event) => event.preventDefault());
setInterval(refresh, 500);
poll();
