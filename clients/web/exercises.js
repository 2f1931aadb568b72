// Exercises for an instructor: which there are, how far the one that is loaded
// has come, what happened in it, and the facts. What the server does with them
// is in docs/exercises.md.

import { Gone, headers, inTurn, perform, Problem } from "/api.js";
import { duration } from "/debrief.js";
import { hand } from "/keep.js";
import { button } from "/panel.js";
import { nameOf } from "/presets.js";
import { may } from "/rights.js";

const LOOK_MS = 1000;
const SURE_MS = 4000;
const JSON_TYPE = { "Content-Type": "application/json" };
const PHASES = { IDLE: "none is loaded", READY: "ready", RUNNING: "running",
  PAUSED: "paused", ENDED: "ended" };

// Columns of the facts that are shown, of the newest line.
const FIGURES = [["speed_mps", "Speed", "m/s"],
  ["speed_max_mps", "Highest speed", "m/s"],
  ["over_limit_s", "Above a limit for", "s"],
  ["under_keel_m", "Under the keel", "m"],
  ["under_keel_min_m", "Least so far", "m"],
  ["groundings", "Groundings", ""], ["collisions", "Collisions", ""],
  ["closest_m", "Closest so far", "m"]];
const TARGET = ["range", "cpa", "tcpa", "closest"];

export function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className || "";
  node.textContent = text || "";
  return node;
}

// --- words for conditions -----------------------------------------------------

const OWN = "own ship";
const ship = (id) => id === undefined ? OWN : `ship ${id}`;
const area = (a) => a.corners ? "an area"
  : `${a.radius ?? 0} m about ${a.latitude ?? 0}°, ${a.longitude ?? 0}°`;
const PARTS = {
  at: (v) => `at ${duration(v)}`,
  after: (v, w) => w.delay ? `${w.delay} s after ${v}` : `after ${v}`,
  northOf: (v) => `north of ${v}°`, southOf: (v) => `south of ${v}°`,
  eastOf: (v) => `east of ${v}°`, westOf: (v) => `west of ${v}°`,
  inside: (v) => `inside ${area(v)}`, outside: (v) => `outside ${area(v)}`,
  speedBelow: (v) => `slower than ${v} m/s`,
  speedAbove: (v) => `faster than ${v} m/s`,
  underKeelBelow: (v) => `less than ${v} m under the keel`,
  rangeBelow: (v, w) => `within ${v} m of ${ship(w.other)}`,
  rangeAbove: (v, w) => `farther than ${v} m from ${ship(w.other)}`,
  cpaBelow: (v, w) => `CPA to ${ship(w.other)} below ${v} m`,
  tcpaBelow: (v, w) => `TCPA to ${ship(w.other)} below ${v} s`,
};

function condition(when) {
  const parts = Object.keys(PARTS).filter((key) => when[key] !== undefined);
  const moved = parts.some((key) => key !== "at" && key !== "after");
  return `${moved ? `${ship(when.entity)} ` : ""}${
    parts.map((key) => PARTS[key](when[key], when)).join(", ")}`;
}

const conditions = (event) => (event.when ?? []).map(condition).join(", or ");

// The state as an exercise begins: what is another's is left out, and views
// stay as they are.
export function stateOf({ revision, sources, presets, exercise, views, clock,
  ...state }) {
  const { mode, rate, ...kept } = clock ?? {};
  return { ...state, clock: rate ? { ...kept, rate } : kept };
}

export class Exercises {
  constructor(details, store) {
    this.details = details;
    this.store = store;
    this.box = details.querySelector("#exercise-card");
    this.rows = new Map(); // of events
    this.build();
    details.addEventListener("toggle", () => this.lookAtList());
    this.lookAtList();
  }

  // --- building -----------------------------------------------------------------

  build() {
    this.buildList();
    this.buildRun();
    this.buildFacts();
    const row = element("div", "control with-button");
    const label = element("label", "label", "Save the scene as");
    label.htmlFor = "exercise-title";
    this.title = element("input", "text");
    this.title.id = "exercise-title";
    this.title.maxLength = 64;
    row.append(label, this.title);
    button(row, "Save", "Save the scene as it is now as a new exercise",
      () => this.saveScene()).id = "exercise-save";
    this.title.addEventListener("keydown", (event) => {
      if (event.key === "Enter") {
        event.preventDefault();
        this.saveScene();
      }
    });
    this.editor = element("div", "exercise-editor");
    this.editor.id = "exercise-editor";
    this.editor.hidden = true;
    this.box.append(row, this.editor);
  }

  buildList() {
    const row = element("div", "control");
    const label = element("label", "label", "Exercise");
    label.htmlFor = "exercise-list";
    this.list = element("select", "select");
    this.list.id = "exercise-list";
    row.append(label, this.list);
    const tools = element("p", "tools-row");
    const tool = (id, text, what, action) => {
      this[id] = button(tools, text, what, action);
      this[id].id = `exercise-${id}`;
    };
    tool("load", "Load", "Load the chosen exercise: the scene becomes its " +
      "beginning", () => this.act("LOAD", { name: this.list.value }));
    tool("edit", "Edit", "Edit the chosen exercise",
      () => this.openEditor(this.list.value));
    tool("remove", "Delete", "Delete the chosen exercise", () => this.erase());
    this.empty = element("p", "fine", "There is no exercise yet. Save the " +
      "scene as one; a server that was started without --exercises DIRECTORY " +
      "keeps none.");
    this.empty.hidden = true;
    this.note = element("p", "plan-note");
    this.note.id = "exercise-note";
    this.note.setAttribute("role", "status");
    this.note.hidden = true;
    this.list.addEventListener("change", () => this.offer());
    this.list.addEventListener("focus", () => this.lookAtList());
    this.box.append(row, tools, this.empty, this.note);
  }

  buildRun() {
    this.run = element("div", "exercise-run");
    this.run.hidden = true;
    const head = element("p", "exercise-head");
    this.name = element("strong");
    this.phase = element("span", "phase");
    this.phase.id = "exercise-phase";
    this.phase.setAttribute("role", "status");
    head.append(this.name, this.phase);
    this.about = element("p", "fine");
    this.clock = element("output", "exercise-time", "0:00.0");
    this.clock.id = "exercise-time";
    this.next = element("p", "fine");
    this.next.id = "exercise-next";
    const tools = element("p", "tools-row");
    this.start = button(tools, "Start", "Start the exercise",
      () => this.act("START"));
    this.start.id = "exercise-start";
    this.pause = button(tools, "Pause", "Pause the exercise",
      () => this.act("PAUSE"));
    this.pause.id = "exercise-pause";
    this.stop = button(tools, "Stop", "Stop the exercise: the scene goes on " +
      "without it", () => this.act("STOP"));
    this.stop.id = "exercise-stop";
    this.run.append(head, this.about, this.clock, this.next, tools);
    this.buildRewind();
    this.run.append(element("h2", "", "Events"));
    this.events = element("ol", "exercise-events");
    this.run.append(this.events);
    this.box.append(this.run);
  }

  buildRewind() {
    const row = element("div", "control range rewind");
    const label = element("label", "label", "Rewind to");
    label.htmlFor = "exercise-to";
    this.to = element("output", "entry-row");
    this.slider = element("input", "slider");
    Object.assign(this.slider, { id: "exercise-to", type: "range", step: 1 });
    this.slider.addEventListener("input", () => {
      this.aimed = true;
      this.sayTo();
    });
    row.append(label, this.to, this.slider);
    const tools = element("p", "tools-row");
    this.back = button(tools, "Rewind", "Rewind the exercise to the chosen " +
      "time, and pause", () => this.rewind(Number(this.slider.value)));
    this.back.id = "exercise-rewind";
    this.run.append(row, tools);
  }

  buildFacts() {
    this.facts = element("div", "exercise-facts");
    this.facts.hidden = true;
    this.figures = element("dl", "figures");
    this.targets = element("table", "traffic");
    this.targets.innerHTML = `<caption>Other ships</caption><thead><tr>
      <th scope="col">Number</th><th scope="col">Range</th>
      <th scope="col">CPA</th><th scope="col">TCPA</th>
      <th scope="col">Closest</th></tr></thead><tbody></tbody>`;
    const row = element("p", "tools-row");
    this.csv = element("a", "button", "Facts as CSV");
    this.csv.id = "exercise-csv";
    this.csv.addEventListener("click", (event) => this.saveFacts(event));
    row.append(this.csv);
    this.facts.append(element("h2", "", "Facts"), this.buildShips(),
      this.figures, this.targets, row);
    this.box.append(this.facts);
  }

  // Whose facts they are, where there are several own ships.
  buildShips() {
    this.shipRow = element("div", "control");
    this.shipRow.hidden = true;
    const label = element("label", "label", "Own ship");
    label.htmlFor = "exercise-ship";
    this.ship = element("select", "select");
    this.ship.id = "exercise-ship";
    this.ship.addEventListener("change", () => {
      this.forgetLines();
      this.look();
    });
    this.shipRow.append(label, this.ship);
    return this.shipRow;
  }

  // --- asking ---------------------------------------------------------------------

  say(text, wrong = false) {
    this.note.textContent = text;
    this.note.classList.toggle("error", wrong);
    this.note.hidden = !text;
  }

  // What came of it, or undefined: it is said why not.
  async ask(work) {
    try {
      return await inTurn(work);
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.say(error.line ?? "The server does not answer.", true);
      return undefined;
    }
  }

  async act(action, more = {}) {
    const status = await this.ask(() => perform("POST", "/v1/exercise",
      { action, ...more }, JSON_TYPE));
    if (status) {
      this.say("");
      this.aimed = false;
      this.hear(status);
      this.look();
    }
    return Boolean(status);
  }

  rewind(time) {
    return this.act("REWIND", { time });
  }

  async look() {
    clearTimeout(this.timer);
    if (!this.details.open || !may("GET v1/exercise") || this.looking) {
      return;
    }
    this.looking = true;
    try {
      await this.read();
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.listed = false; // another may have loaded one meanwhile
    }
    this.looking = false;
    this.timer = setTimeout(() => this.look(), LOOK_MS);
  }

  // Facts bring the status along; the state says when another loads one. The
  // list is asked for when it is opened, and when something was done to it.
  async read() {
    const { exercise = {} } = this.store.state;
    if (!this.listed || (exercise.digest ?? "") !== this.digest) {
      const status = await inTurn(() => perform("GET", "/v1/exercises"));
      this.listed = true;
      this.digest = status.run?.digest ?? "";
      this.showList(status);
      this.hear(status);
    }
    if (this.leads) {
      await this.readFacts();
    } else if (exercise.name) { // a replay's
      this.hear(await inTurn(() => perform("GET", "/v1/exercise")));
    }
  }

  lookAtList() {
    this.listed = false;
    return this.look();
  }

  // --- what there is --------------------------------------------------------------

  showList({ exercises = [] }) {
    const key = JSON.stringify(exercises);
    this.empty.hidden = exercises.length > 0;
    if (key !== this.key) {
      this.key = key;
      const before = this.wanted ?? this.list.value;
      this.wanted = undefined;
      this.exercises = new Map(exercises.map((e) => [e.name, e]));
      this.list.replaceChildren(...exercises.map((e) => new Option(
        e.title ? `${e.name}: ${e.title}` : e.name, e.name)));
      this.list.value = this.exercises.has(before) ? before
        : exercises[0]?.name ?? "";
    }
    this.offer();
  }

  offer() {
    const chosen = this.exercises?.get(this.list.value);
    this.load.disabled = !chosen || Boolean(chosen.error);
    this.edit.disabled = this.remove.disabled = this.list.disabled = !chosen;
    const wrong = chosen?.error?.message;
    if (wrong !== this.wrong) {
      this.wrong = wrong;
      this.say(wrong ? `${chosen.name} cannot be loaded: ${wrong}` : "",
        Boolean(wrong));
    }
  }

  // The second press within some seconds does it.
  async erase() {
    const name = this.list.value;
    const ask = (on) => {
      clearTimeout(this.sure);
      this.sure = on ? setTimeout(() => ask(false), SURE_MS) : null;
      this.remove.textContent = on ? "Sure?" : "Delete";
    };
    const again = Boolean(this.sure) && this.doomed === name;
    this.doomed = name;
    ask(!again);
    if (again && await this.ask(() => perform("DELETE",
      `/v1/exercises/${encodeURIComponent(name)}`))) {
      this.say(`${name} is deleted.`);
      this.lookAtList();
    }
  }

  async saveScene() {
    const title = this.title.value.trim();
    if (!title) {
      this.say("An exercise needs a name.", true);
      this.title.focus();
      return;
    }
    const name = nameOf(title);
    if (this.exercises?.has(name)) {
      this.say(`There is an exercise ${name} already: choose another name.`,
        true);
      return;
    }
    const state = await this.ask(() => perform("GET", "/v1/state"));
    if (state && await this.save(name, { title, state: stateOf(state) })) {
      this.title.value = "";
      this.say(`The scene is saved as ${name}. Edit it to add events.`);
    }
  }

  async save(name, exercise) {
    const saved = await this.ask(() => perform("PUT",
      `/v1/exercises/${encodeURIComponent(name)}`, exercise, JSON_TYPE));
    if (saved) {
      this.saved(name);
    }
    return Boolean(saved);
  }

  saved(name) {
    this.wanted = name;
    this.key = "";
    this.lookAtList();
  }

  async openEditor(name) {
    const exercise = await this.ask(() => perform("GET",
      `/v1/exercises/${encodeURIComponent(name)}`));
    if (exercise) {
      const { Editor } = await import("/exerciseedit.js");
      this.say("");
      this.form = this.form ?? new Editor(this.editor, (saved) => this.saved(saved));
      this.form.open(name, exercise);
    }
  }

  // --- how far it is ----------------------------------------------------------------

  hear(status) {
    const { run = {}, time = 0 } = status;
    const phase = run.phase ?? "IDLE";
    const loaded = Boolean(run.name) && phase !== "IDLE";
    this.status = status;
    this.leads = loaded && status.leads;
    this.run.hidden = !loaded;
    this.name.textContent = run.name ?? "";
    this.about.textContent = status.title ?? "";
    if (this.phase.textContent !== PHASES[phase]) {
      this.phase.textContent = PHASES[phase];
      this.phase.dataset.phase = phase;
    }
    this.clock.textContent = duration(time);
    this.next.textContent = loaded && !status.leads
      ? "Another leads it, as a replay does." : status.next
        ? `Next: ${status.next} at ${duration(status.nextTime ?? 0)}` : "";
    this.start.textContent = phase === "PAUSED" ? "Go on" : "Start";
    this.start.setAttribute("aria-label", phase === "PAUSED"
      ? "Let the exercise go on" : "Start the exercise");
    this.start.title = this.start.getAttribute("aria-label");
    this.start.disabled = !this.leads || !["READY", "PAUSED"].includes(phase);
    this.pause.disabled = !this.leads || phase !== "RUNNING";
    this.stop.disabled = !this.leads || phase === "ENDED";
    this.showRewind(status.earliest ?? 0, time);
    this.showShips(status.ships ?? []);
    this.showEvents(run);
  }

  showShips(ships) {
    const { entities = [] } = this.store.state;
    const options = ships.map((id) => {
      const name = entities.find((e) => (e.id ?? 0) === id)?.name;
      return new Option(name ? `${id}, ${name}` : id, id);
    });
    const key = options.map((option) => option.text).join("; ");
    if (key === this.shipKey) {
      return;
    }
    this.shipKey = key;
    const before = this.ship.value;
    this.ship.replaceChildren(...options);
    if (ships.map(String).includes(before)) {
      this.ship.value = before;
    }
    this.shipRow.hidden = ships.length < 2;
  }

  showRewind(earliest, time) {
    this.slider.min = Math.ceil(earliest);
    this.slider.max = Math.max(Math.floor(time), Math.ceil(earliest));
    this.slider.disabled = this.back.disabled = !this.leads ||
      time <= earliest;
    if (!this.aimed) {
      this.slider.value = time;
    }
    this.sayTo();
  }

  sayTo() {
    const at = Number(this.slider.value);
    const low = Number(this.slider.min);
    const span = Math.max(Number(this.slider.max) - low, 1);
    this.slider.style.setProperty("--part", `${100 * (at - low) / span}%`);
    this.to.textContent = duration(at);
    this.slider.setAttribute("aria-valuetext", duration(at));
  }

  // --- events -----------------------------------------------------------------------

  // Those of the file as it is now, and those that happened.
  async showEvents(run) {
    const key = `${run.name} ${run.digest}`;
    if (run.name && key !== this.loaded) {
      this.loaded = key;
      this.plan = [];
      this.forgetFacts();
      const file = await inTurn(() => perform("GET",
        `/v1/exercises/${encodeURIComponent(run.name)}`)).catch(() => null);
      if (this.loaded !== key) {
        return;
      }
      this.plan = file?.events ?? [];
      this.rows.clear();
      this.events.replaceChildren();
    }
    const done = new Map((run.events ?? []).map((d) => [d.event, d]));
    const names = new Set([...(this.plan ?? []).map((e) => e.name),
      ...done.keys()]);
    for (const name of names) {
      this.showEvent(name, done.get(name));
    }
  }

  showEvent(name, done) {
    let row = this.rows.get(name);
    if (!row) {
      const event = (this.plan ?? []).find((e) => e.name === name) ?? {};
      const node = element("li");
      const text = element("span", "recording-name", name);
      text.append(element("small", "", conditions(event)));
      text.title = event.text ?? "";
      row = { node, when: element("span", "event-when") };
      row.back = button(node, "↶", `Rewind to just before ${name}`,
        () => this.rewind(row.before));
      node.prepend(text, row.when);
      this.rows.set(name, row);
      this.events.append(node);
    }
    const count = done?.count ?? 0;
    row.before = Math.max(this.status.earliest ?? 0, (done?.time ?? 0) - 0.1);
    row.node.classList.toggle("fired", count > 0);
    row.when.textContent = count === 0 ? "waits"
      : `${duration(done.time ?? 0)}${count > 1 ? `, ${count} ×` : ""}`;
    row.back.disabled = count === 0 || !this.leads;
  }

  // --- facts ------------------------------------------------------------------------

  forgetLines() {
    this.head = null;
    this.line = null;
    this.since = 0;
  }

  forgetFacts() {
    this.forgetLines();
    this.facts.hidden = true;
  }

  // {}: there is one own ship.
  chosen() {
    return this.ship.length > 1 ? { ship: Number(this.ship.value) } : {};
  }

  async readFacts() {
    const { time = 0 } = this.status;
    if (this.line && Number(this.line[0]) > time) { // after a rewind
      this.since = Math.max(0, Math.floor(time) - 0.5);
    }
    const of = this.chosen();
    for (let more = this.head ? this.since : 0; more !== undefined;) {
      const status = await inTurn(() => perform("POST", "/v1/exercise",
        { action: "FACTS", time: more, ...of }, JSON_TYPE));
      this.hear(status);
      if (this.chosen().ship !== of.ship) {
        return; // another was chosen meanwhile
      }
      const { facts = "" } = status;
      const lines = facts.split("\n").filter(Boolean);
      if (more === 0 && lines.length > 0) {
        this.head = lines.shift().split(",");
      }
      if (lines.length > 0) {
        this.line = lines.at(-1).split(",");
        this.since = Number(this.line[0]) + 0.5;
      }
      more = status.more;
    }
    this.showFacts();
  }

  fact(name) {
    const text = this.line[this.head.indexOf(name)] ?? "";
    return text === "" ? NaN : Number(text);
  }

  showFacts() {
    this.facts.hidden = !this.head || !this.line;
    if (this.facts.hidden) {
      return;
    }
    const shown = (value, unit) => Number.isNaN(value) ? "–"
      : `${unit === "m/s" || Math.abs(value) < 10 && unit
        ? value.toFixed(1) : value.toFixed(0)}${unit && ` ${unit}`}`;
    this.figures.replaceChildren(...FIGURES.map(([name, label, unit]) => {
      const node = element("div");
      node.dataset.fact = name;
      node.append(element("dt", "", label),
        element("dd", "", shown(this.fact(name), unit)));
      return node;
    }));
    const ids = this.head.map((name) => name.match(/^range_(\d+)_m$/)?.[1])
      .filter(Boolean);
    this.targets.hidden = ids.length === 0;
    this.targets.tBodies[0].replaceChildren(...ids.map((id) => {
      const row = element("tr");
      const head = element("th", "", id);
      head.scope = "row";
      row.append(head, ...TARGET.map((what) => element("td", "", shown(
        this.fact(`${what}_${id}_${what === "tcpa" ? "s" : "m"}`),
        what === "tcpa" ? "s" : "m"))));
      return row;
    }));
    const { ship: which } = this.chosen();
    this.csv.href = which === undefined ? "/v1/exercise.csv"
      : `/v1/exercise.csv?ship=${which}`;
    this.csv.download = `${this.status.run.name}${
      which === undefined ? "" : `-${which}`}.csv`;
  }

  // A link takes no token along.
  async saveFacts(event) {
    if (!headers().Authorization) {
      return;
    }
    event.preventDefault();
    try {
      const answer = await fetch(this.csv.href, { cache: "no-store",
        headers: headers() });
      if (!answer.ok) {
        throw new Problem(await answer.json(), answer.status);
      }
      hand(await answer.blob(), this.csv.download);
    } catch (error) {
      this.say(error instanceof Problem ? error.message
        : "Not saved: the server does not answer.", true);
    }
  }
}
