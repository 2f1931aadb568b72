// Recordings on the server, and the debrief: a second scene that is led through
// one of them, whose pictures are shown beside the live ones.

import { Gone, inTurn, perform, Problem } from "/api.js";
import { button } from "/panel.js";
import { may, needs } from "/rights.js";
import { Player } from "/player.js";
import { fitted } from "/views.js";

const LEADS = "PATCH v1/debrief";
const RECORDS = "POST v1/recording";
const JSON_TYPE = { "Content-Type": "application/json" };
const LOOK_MS = 400; // while it is open
const LIST_MS = 5000; // while the list is seen
const RATES = [0.25, 0.5, 1, 2, 4, 8];
const STEPS = [["−10 s", -10], ["−1 s", -1], ["+1 s", 1], ["+10 s", 10]];

const byId = (id) => document.getElementById(id);

function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className || "";
  node.textContent = text || "";
  return node;
}

export function duration(seconds) {
  const s = Math.max(0, seconds);
  const parts = [Math.floor(s / 3600), Math.floor(s / 60) % 60];
  const rest = (s % 60).toFixed(1).padStart(4, "0");
  return `${parts[0] ? `${parts[0]}:${String(parts[1]).padStart(2, "0")}`
    : parts[1]}:${rest}`;
}

// One picture of the debrief.
class ThenTile {
  constructor(view) {
    this.name = view.name;
    this.node = element("figure", "tile");
    this.node.dataset.then = view.name;
    this.node.style.setProperty("--aspect", `${view.width} / ${view.height}`);
    this.image = element("img", "picture");
    this.image.alt = `Then: the sea from view ${view.name}`;
    this.canvas = element("canvas", "picture");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", this.image.alt);
    this.note = element("p", "tile-note", "waiting for a picture");
    const caption = element("figcaption", "caption");
    this.time = element("span", "rate");
    caption.append(element("strong", "", `Then: ${view.name}`), this.time);
    this.node.append(this.image, this.canvas, this.note, caption);
    this.live = new Player(view.name, this.canvas, this.image,
      (frame) => this.told(frame), () => {}, "/v1/debrief");
    this.live.start();
    fitted(this.node, () => view);
  }

  told(frame) {
    this.note.hidden = frame !== null;
    this.note.textContent = "no picture, trying again";
    if (frame) {
      this.node.dataset.time = frame.time;
      this.time.textContent = `${frame.time.toFixed(1)} s`;
    }
  }

  remove() {
    this.live.stop();
    this.node.remove();
  }
}

export class Debrief {
  constructor(views) {
    this.views = views;
    this.bar = byId("debrief-bar");
    this.grid = byId("then");
    this.tiles = new Map();
    this.status = { state: "CLOSED" };
    this.build();
    this.look();
  }

  build() {
    this.title = element("p", "debrief-title");
    this.error = element("p", "error");
    this.error.setAttribute("role", "alert");
    this.slider = element("input", "slider");
    this.slider.type = "range";
    this.slider.min = 0;
    this.slider.step = 0.1;
    this.slider.setAttribute("aria-label", "Moment of the recording");
    this.slider.addEventListener("input", () => {
      this.held = true;
      this.say();
      this.seek(Number(this.slider.value));
    });
    this.slider.addEventListener("change", () => {
      this.held = false;
    });
    this.where = element("output", "debrief-where");
    const tools = element("p", "tools-row");
    this.play = button(tools, "Play", "Play the recording", () =>
      this.do({ playing: !this.status.playing }));
    this.play.id = "debrief-play";
    for (const [text, by] of STEPS) {
      button(tools, text, `Debrief: ${by > 0 ? "on" : "back"} by ${
        Math.abs(by)} s`, () => this.step(by));
    }
    this.rate = this.select(tools, "debrief-rate", "Rate of the recording",
      RATES.map((x) => [x, `${x} ×`]), () =>
        this.do({ rate: Number(this.rate.value) }));
    this.which = this.select(tools, "debrief-views", "Views of the debrief",
      [["chosen", "Chosen view"], ["all", "All views"]],
      () => this.showViews());
    button(tools, "Close", "Close the debrief", () => this.do({ close: true }))
      .id = "debrief-close";
    this.bar.append(this.title, this.slider, this.where, tools, this.error);
  }

  select(parent, id, label, options, changed) {
    const node = element("select", "select");
    node.id = id;
    node.setAttribute("aria-label", label);
    node.append(...options.map(([value, text]) => {
      const option = element("option", "", text);
      option.value = value;
      return option;
    }));
    node.addEventListener("change", changed);
    parent.append(node);
    return node;
  }

  // --- asking ------------------------------------------------------------------

  async do(command) {
    try {
      this.hear(await inTurn(() => perform("PATCH", "/v1/debrief", command,
        JSON_TYPE)));
      this.look();
      return true;
    } catch (error) {
      this.fail(error);
      return false;
    }
  }

  fail(error) {
    if (!(error instanceof Problem || error instanceof Gone)) {
      throw error;
    }
    this.error.textContent = error.line ?? "The server does not answer.";
  }

  // The newest place only, as fast as the server answers.
  async seek(position) {
    this.goal = position;
    if (this.seeking) {
      return;
    }
    this.seeking = true;
    while (this.goal !== undefined) {
      const to = this.goal;
      this.goal = undefined;
      await this.do({ position: to });
    }
    this.seeking = false;
  }

  step(by) {
    const { length } = this.status;
    const from = this.goal ?? this.aim ?? this.status.position;
    this.aim = Math.max(0, Math.min(length, from + by));
    this.seek(this.aim);
  }

  async look() {
    clearTimeout(this.timer);
    try {
      this.hear(await inTurn(() => perform("GET", "/v1/debrief")));
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
    }
    if (this.status.state !== "CLOSED") {
      this.timer = setTimeout(() => this.look(), LOOK_MS);
    }
  }

  // --- showing -----------------------------------------------------------------

  hear(status) {
    const before = this.status;
    this.status = status;
    const open = status.state === "OPEN";
    this.bar.hidden = status.state === "CLOSED";
    document.body.classList.toggle("debriefed", !this.bar.hidden);
    this.bar.classList.toggle("open", open);
    byId("pair").classList.toggle("two", open);
    this.grid.hidden = !open;
    const words = { OPENING: `is being read, ${
      Math.round(100 * (status.progress ?? 0))} %`, CLOSING: "closes",
    FAILED: "cannot be opened" }[status.state];
    this.title.textContent = `${status.recording ?? "Recording"}${
      words ? ` ${words}` : status.busy ? ", on its way …" : ""}`;
    this.title.title = open && !status.sameDevice
      ? `Recorded on ${status.device}: pictures differ in bits` : "";
    this.error.textContent = status.error ?? "";
    this.slider.max = status.length ?? 0;
    if (!status.busy) {
      this.aim = undefined;
    }
    if (!this.held && this.goal === undefined && this.aim === undefined) {
      this.slider.value = status.position;
    }
    this.say();
    this.play.textContent = status.playing ? "Pause" : "Play";
    this.play.setAttribute("aria-label", status.playing
      ? "Pause the recording" : "Play the recording");
    if (document.activeElement !== this.rate) {
      this.rate.value = RATES.includes(status.rate) ? status.rate : 1;
    }
    for (const node of this.bar.querySelectorAll("button, input, select")) {
      node.disabled = (!open && node.id !== "debrief-close") ||
        (node !== this.which && !may(LEADS));
    }
    if (open !== (before.state === "OPEN")) {
      this.views.lay();
    }
    this.followViews(open, before);
  }

  say() {
    const at = Number(this.slider.value);
    const part = at / Math.max(Number(this.slider.max), 1e-9);
    this.slider.style.setProperty("--part", `${100 * part}%`);
    const text = `${duration(at)} of ${duration(this.status.length ?? 0)}`;
    this.where.textContent = `${text} · simulated time ${
      (this.status.time ?? 0).toFixed(1)} s`;
    this.slider.setAttribute("aria-valuetext", text);
  }

  // Views may come and go in the recording.
  async followViews(open, before) {
    if (!open) {
      this.then = [];
      this.showViews();
    } else if (before.state !== "OPEN" || before.time !== this.status.time) {
      if (this.asking) {
        return;
      }
      this.asking = true;
      try {
        const state = await inTurn(() => perform("GET", "/v1/debrief/state"));
        this.then = state.views ?? [];
        this.showViews();
      } catch (error) {
        this.fail(error);
      } finally {
        this.asking = false;
      }
    }
  }

  showViews() {
    const all = this.which.value === "all";
    const there = this.then ?? [];
    const chosen = there.find((view) => view.name === this.views.name) ??
      there[0];
    const wanted = all ? there : there.filter((view) => view === chosen);
    for (const [name, tile] of this.tiles) {
      if (!wanted.some((view) => view.name === name)) {
        tile.remove();
        this.tiles.delete(name);
      }
    }
    for (const view of wanted) {
      if (!this.tiles.has(view.name)) {
        const tile = new ThenTile(view);
        this.tiles.set(view.name, tile);
        this.grid.append(tile.node);
      }
    }
  }
}

// The section of the panel.
export class Recordings {
  constructor(parent, debrief) {
    this.debrief = debrief;
    this.details = parent.closest("details");
    this.form = needs(element("p", "tools-row"), RECORDS);
    this.name = element("input", "text");
    this.name.id = "recording-name";
    this.name.placeholder = "named by the date";
    this.name.maxLength = 64;
    this.name.setAttribute("aria-label", "Name of the recording");
    this.form.append(this.name);
    this.record = button(this.form, "Record", "Begin a recording",
      () => this.toggle());
    this.record.id = "record";
    this.error = element("p", "error");
    this.error.setAttribute("role", "alert");
    this.note = element("p", "fine");
    this.note.setAttribute("role", "status");
    this.list = element("ul", "recording-rows");
    parent.append(this.form, this.error, this.note, this.list);
    this.details.addEventListener("toggle", () => this.look());
    this.look();
  }

  async ask(method, path, body) {
    try {
      this.show(await inTurn(() => perform(method, path, body, JSON_TYPE)));
      this.error.textContent = "";
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.error.textContent = error.message ||
        "The server does not answer.";
    }
  }

  async look() {
    clearTimeout(this.timer);
    if (this.details.open) {
      await this.ask("GET", "/v1/recordings");
      this.timer = setTimeout(() => this.look(), LIST_MS);
    }
  }

  toggle() {
    const name = this.name.value.trim();
    this.name.value = "";
    return this.ask("POST", "/v1/recording",
      this.writing ? { stop: true } : { start: name });
  }

  show({ recordings = [], writing, possible }) {
    this.writing = writing;
    this.record.textContent = writing ? "Stop recording" : "Record";
    this.record.title = writing ? "Stop recording" : "Begin a recording";
    this.record.setAttribute("aria-label", this.record.title);
    this.record.disabled = !possible && !writing;
    this.name.hidden = Boolean(writing) || !possible;
    this.note.textContent = writing ? `Recording to ${writing}.` : possible
      ? "" : "This server keeps no recordings: start pelagosd with " +
        "--recordings DIRECTORY.";
    const key = JSON.stringify(recordings);
    if (key === this.key) {
      return;
    }
    this.key = key;
    this.list.replaceChildren(...recordings.map((one) => {
      const node = element("li");
      const text = element("span", "recording-name", one.name);
      const facts = element("small", "", one.error ?? `${
        (one.began ?? "").slice(0, 16).replace("T", " ")} · ${
        duration(one.to - one.from)} · ${(one.bytes / 1000).toFixed(0)} kB`);
      text.append(facts);
      node.append(text);
      button(node, "Debrief", `Debrief of ${one.name}`, () =>
        this.debrief.do({ recording: one.name }), LEADS)
        .disabled = Boolean(one.error);
      return node;
    }));
  }
}
