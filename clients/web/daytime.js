// The section of time: what makes it run, pause and steps, UTC of now, the day
// as a slider with what Sun and Moon do on it.

import { Gone, inTurn, perform, Problem } from "/api.js";
import { three } from "/geo.js";
import { button } from "/panel.js";

const byId = (id) => document.getElementById(id);
const DAY_S = 86400;
const AGAIN_MS = 10000;
const STEPS = [[0.1, "0.1 s"], [1, "1 s"], [10, "10 s"], [60, "1 min"],
  [600, "10 min"], [3600, "1 h"]];
const SUN_FREE = { sunElevation: null, sunAzimuth: null, moonElevation: null,
  moonAzimuth: null, moonPhase: null };

const epochMs = (state) => Date.parse(state.clock?.utc ?? "");
export const utcMs = (state, time) => epochMs(state) + 1000 * time;
const iso = (ms) => new Date(ms).toISOString().replace(".000Z", "Z");
const clock = (text) => text === undefined ? "–" : text.slice(11, 16);
const share = (text) => text === undefined ? undefined
  : (Date.parse(text) % (DAY_S * 1000)) / (DAY_S * 1000);

export class Daytime {
  // panel: Sections; time(): simulated time of the pictures.
  constructor(panel, time) {
    this.panel = panel;
    this.store = panel.store;
    this.time = time;
    this.running = "FREE"; // what goes on after a pause
    this.build();
  }

  build() {
    const { panel } = this;
    const parent = byId("clock");
    panel.choice("clock", "clock-mode", "Time runs", "clock.mode");
    panel.range("clock", "Rate", "clock.rate", "×", 0.1, { id: "rate",
      depends: (s) => ["FREE", "PACED"].includes(s.clock?.mode) });
    const row = document.createElement("p");
    row.className = "tools-row";
    parent.append(row);
    this.pause = button(row, "Pause", "Pause simulated time", () => this.turn(),
      "clock.mode");
    this.steps = document.createElement("select");
    this.steps.className = "select";
    this.steps.setAttribute("aria-label", "Length of a step");
    this.steps.append(...STEPS.map(([s, text]) => new Option(text, s, s === 1,
      s === 1)));
    this.step = button(row, "Step", "Advance time by one step", () =>
      this.advance(), "POST v1/clock/step");
    this.steps.dataset.needs = "POST v1/clock/step";
    row.append(this.steps);
    this.note = document.createElement("p");
    this.note.className = "error";
    this.note.setAttribute("role", "alert");
    this.note.hidden = true;
    this.buildUtc(parent);
    this.buildDay(parent);
    parent.append(this.note);
    panel.add({ show: (state) => this.show(state),
      heard: () => this.fail("") });
    setInterval(() => this.tick(), 500);
  }

  fail(text) {
    this.note.textContent = text;
    this.note.hidden = text === "";
  }

  async attempt(work) {
    try {
      await work();
      this.fail("");
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.fail(error.line ?? "Not set: the server does not answer.");
    }
  }

  turn() {
    const { mode } = this.store.state.clock ?? {};
    if (mode !== "STEPPED") {
      this.running = mode === "PACED" ? "PACED" : "FREE";
    }
    const next = mode === "STEPPED" ? this.running : "STEPPED";
    this.attempt(() => this.store.ask("pause", () => ({ clock: { mode: next } })));
  }

  advance() {
    this.attempt(() => this.store.step(Number(this.steps.value)));
  }

  // --- UTC ------------------------------------------------------------------------

  buildUtc(parent) {
    const node = document.createElement("div");
    node.className = "control wide";
    const label = document.createElement("label");
    label.className = "label";
    label.htmlFor = "utc";
    label.textContent = "UTC now";
    this.utc = document.createElement("input");
    Object.assign(this.utc, { id: "utc", type: "datetime-local", step: 1,
      className: "text" });
    this.utc.dataset.needs = "clock.utc";
    node.append(label, this.utc);
    parent.append(node);
    // What is typed stays until it is committed: a browser tells each part of
    // it as a change.
    this.utc.addEventListener("input", () => {
      this.typed = true;
    });
    this.utc.addEventListener("keydown", (event) => {
      if (event.key === "Enter") {
        event.preventDefault();
        this.commit();
      } else if (event.key === "Escape" && this.typed) {
        event.stopPropagation();
        this.typed = false;
        this.tick();
      }
    });
    this.utc.addEventListener("blur", () => this.commit());
  }

  commit() {
    const ms = Date.parse(`${this.utc.value}Z`);
    if (this.typed && Number.isFinite(ms)) {
      this.setUtc(ms);
    }
    this.typed = false;
  }

  // So that it is that moment now; time itself, and all that moves, goes on.
  setUtc(ms, more = {}, pace = {}) {
    this.attempt(() => this.store.ask("utc", () => ({
      clock: { utc: iso(Math.round(ms - 1000 * this.time())) }, ...more }),
    pace));
  }

  // --- the day --------------------------------------------------------------------

  buildDay(parent) {
    const node = document.createElement("div");
    node.className = "control range day";
    node.innerHTML = `
      <label class="label" for="day">Time of day, UTC</label>
      <output class="entry-row" id="day-text">–</output>
      <input class="slider" id="day" data-needs="clock.utc" type="range" min="0" max="${DAY_S - 60}"
             step="60">
      <svg class="day-strip" viewBox="0 0 1000 60" preserveAspectRatio="none"
           aria-hidden="true"></svg>
      <ul class="day-list" id="day-list"></ul>`;
    parent.append(node);
    this.day = node.querySelector("#day");
    this.strip = node.querySelector("svg");
    this.day.addEventListener("pointerdown", () => {
      this.held = true;
      const end = () => {
        this.held = false;
        removeEventListener("pointerup", end, true);
        removeEventListener("pointercancel", end, true);
      };
      addEventListener("pointerup", end, true);
      addEventListener("pointercancel", end, true);
    });
    this.day.addEventListener("input", () => {
      const now = utcMs(this.store.state, this.time());
      const midnight = Math.floor(now / 1000 / DAY_S) * DAY_S;
      const { sky } = this.store.state;
      this.setUtc((midnight + Number(this.day.value)) * 1000,
        sky?.sunElevation === undefined && sky?.sunAzimuth === undefined ? {}
          : { sky: SUN_FREE }, { everyMs: 150 });
      this.showDay(Number(this.day.value));
      this.asked = 0;
    });
  }

  showDay(seconds) {
    const text = new Date(seconds * 1000).toISOString().slice(11, 19);
    byId("day-text").textContent = text;
    this.day.setAttribute("aria-valuetext", text.slice(0, 5));
    this.day.style.setProperty("--part", `${100 * seconds / DAY_S}%`);
  }

  // Twice a second: what goes on by itself.
  tick() {
    const ms = utcMs(this.store.state, this.time());
    if (!Number.isFinite(ms) || this.utc.offsetParent === null) {
      return;
    }
    if (!this.typed) {
      const text = new Date(ms).toISOString().slice(0, 19);
      if (document.activeElement !== this.utc) {
        this.utc.value = text;
      }
    }
    if (!this.held && !this.store.waits("utc")) {
      const seconds = Math.floor(ms / 1000) % DAY_S;
      this.day.value = seconds;
      this.showDay(seconds);
    }
    this.ask(ms);
  }

  async ask(ms) {
    const { origin } = this.store.told;
    const key = `${Math.floor(ms / 1000 / DAY_S)} ${JSON.stringify(origin)}`;
    const now = performance.now();
    if (this.asking || document.hidden ||
        (key === this.key && now - (this.asked ?? 0) < AGAIN_MS)) {
      return;
    }
    this.asking = true;
    try {
      const time = Math.max(0, Math.min(this.time(), 1e9));
      const answer = await inTurn(() => perform("GET",
        `/v1/almanac?time=${time.toFixed(3)}`));
      this.key = key;
      this.asked = now;
      this.showAlmanac(answer);
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
    }
    this.asking = false;
  }

  showAlmanac({ sun, moon }) {
    const { sky } = this.store.state;
    const fixed = sky?.sunElevation !== undefined;
    const events = (body) => body.rise === undefined && body.set === undefined
      ? body.highest > -1 ? "up all day" : "down all day"
      : `rises ${clock(body.rise)}, sets ${clock(body.set)}`;
    const line = (name, body, more) => {
      const node = document.createElement("li");
      node.textContent = `${name} ${events(body)}, highest ` +
        `${clock(body.culmination)}${body.highest === undefined ? ""
          : ` at ${body.highest.toFixed(0)}°`}; ${more}`;
      return node;
    };
    const place = (body) => `now ${body.elevation.toFixed(1)}° ` +
      `${body.elevation < 0 ? "(below the horizon)" : "high"}, in ` +
      three(body.azimuth);
    const list = [line("Sun", sun, place(sun)),
      line("Moon", moon, `${place(moon)}, ${Math.round(100 * moon.lit)} % lit`)];
    if (fixed) {
      const node = document.createElement("li");
      node.className = "set";
      node.textContent = "Drawn instead: a Sun set by hand, " +
        `${sky.sunElevation.toFixed(1)}° high in ${
          three(sky.sunAzimuth ?? 0)}; the slider lets it follow the clock.`;
      list.push(node);
    }
    byId("day-list").replaceChildren(...list);
    this.drawStrip(sun, moon);
  }

  // When each is up, as a bar under the slider; a mark where it is highest.
  drawStrip(sun, moon) {
    const bars = [];
    [[sun, "sun", 6], [moon, "moon", 36]].forEach(([body, name, y]) => {
      const [rise, set, top] = [share(body.rise), share(body.set),
        share(body.culmination)];
      const up = rise === undefined && set === undefined
        ? body.highest > -1 ? [[0, 1]] : []
        : rise === undefined ? [[0, set]] : set === undefined ? [[rise, 1]]
          : rise < set ? [[rise, set]] : [[0, set], [rise, 1]];
      bars.push(`<rect class="down" x="0" y="${y}" width="1000" height="18"/>`);
      bars.push(...up.map(([a, b]) => `<rect class="${name}" y="${y}" x="${
        1000 * a}" width="${1000 * (b - a)}" height="18"/>`));
      if (top !== undefined) {
        bars.push(`<rect class="top" y="${y - 4}" x="${1000 * top - 2
        }" width="4" height="26"/>`);
      }
    });
    this.strip.innerHTML = bars.join("");
  }

  show(state) {
    const { mode } = state.clock ?? {};
    this.pause.hidden = mode === "HOST";
    this.pause.textContent = mode === "STEPPED" ? "Go on" : "Pause";
    this.pause.setAttribute("aria-label", mode === "STEPPED"
      ? "Let simulated time go on" : "Pause simulated time");
    this.pause.title = this.pause.getAttribute("aria-label");
    this.step.hidden = this.steps.hidden = mode !== "STEPPED";
  }
}
