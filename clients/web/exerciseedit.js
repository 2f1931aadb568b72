// An exercise as text: its events are added by templates, one for each kind of
// condition; what the server refuses is said, and shown where it stands.

import { Gone, inTurn, perform, Problem } from "/api.js";
import { element } from "/exercises.js";
import { button } from "/panel.js";
import { nameOf } from "/presets.js";

const JSON_TYPE = { "Content-Type": "application/json" };

// Ships are given by their numbers, or as a list.
const listed = ({ entities = [] }) => Array.isArray(entities) ? entities
  : Object.entries(entities).map(([id, e]) => ({ id: Number(id), ...e }));
const own = ({ state = {}, ownShip = 1 }) =>
  listed(state).find((e) => (e.id ?? 0) === ownShip) ?? {};
const fine = (x) => Math.round(x * 1e4) / 1e4;
const place = (exercise) => {
  const { latitude = 52.6, longitude = 5.2 } = own(exercise);
  return { latitude: fine(latitude), longitude: fine(longitude) };
};
const circle = (exercise) => ({ ...place(exercise), radius: 500 });
function corners(exercise) {
  const { latitude, longitude } = place(exercise);
  return [[0.01, -0.01], [0.01, 0.01], [0.02, 0.01]].map(([up, right]) =>
    `${fine(latitude + up)} ${fine(longitude + right)}`).join(", ");
}
const other = ({ state = {}, ownShip = 1 }) => listed(state)
  .map((e) => e.id ?? 0).find((id) => id !== ownShip);

// Each makes a condition for the exercise as it is.
const TEMPLATES = [
  ["Time", [
    ["At a time", () => ({ at: 60 })],
    ["After another event", (e) => ({ after: e.events?.[0]?.name, delay: 30 })],
  ]],
  ["Place of own ship", [
    ["North of a latitude", (e) => ({ northOf: fine(place(e).latitude + 0.01) })],
    ["South of a latitude", (e) => ({ southOf: fine(place(e).latitude - 0.01) })],
    ["East of a meridian", (e) => ({ eastOf: fine(place(e).longitude + 0.01) })],
    ["West of a meridian", (e) => ({ westOf: fine(place(e).longitude - 0.01) })],
    ["Inside a circle", (e) => ({ inside: circle(e) })],
    ["Inside an area with corners", (e) => ({ inside: { corners: corners(e) } })],
    ["Outside a circle", (e) => ({ outside: circle(e) })],
  ]],
  ["Motion of own ship", [
    ["Slower than", () => ({ speedBelow: 1 })],
    ["Faster than", () => ({ speedAbove: 8 })],
    ["Little water under the keel", () => ({ underKeelBelow: 2 })],
  ]],
  ["Another ship", [
    ["Closer than", (e) => ({ other: other(e), rangeBelow: 1852 })],
    ["Farther than", (e) => ({ other: other(e), rangeAbove: 9260 })],
    ["CPA below", (e) => ({ other: other(e), cpaBelow: 926 })],
    ["TCPA below", (e) => ({ other: other(e), tcpaBelow: 360 })],
  ]],
];

// The own ships, ownShip first.
const shipsOf = ({ ownShip = 1, ships }) => [ownShip,
  ...(Array.isArray(ships) ? ships : []).map((s) => s?.id)
    .filter((id) => id !== undefined)];

// A condition that `make` has for the exercise, about one of its own ships.
function conditionOf(make, exercise, ship) {
  const when = make({ ...exercise, ownShip: ship });
  const about = ship !== (exercise.ownShip ?? 1) && !("at" in when) &&
    !("after" in when);
  return about ? { entity: ship, ...when } : when;
}

// Where in the text the field stands that a path names, as [from, to].
export function find(text, path) {
  let at = 0;
  let found = null;
  for (const part of path.split(".")) {
    const next = /^\d+$/.test(part) ? -1 : text.indexOf(`"${part}"`, at);
    if (next >= 0) {
      found = [next, next + part.length + 2];
      // Of an element that is named: all of it.
      at = /"name"\s*:\s*$/.test(text.slice(0, next)) ? opening(text, next)
        : next;
    }
  }
  return found;
}

function opening(text, from) {
  for (let at = from, depth = 0; at > 0; at--) {
    depth += text[at] === "}" ? 1 : text[at] === "{" ? -1 : 0;
    if (depth < 0) {
      return at;
    }
  }
  return 0;
}

export class Editor {
  // saved(name): it was.
  constructor(box, saved) {
    this.box = box;
    this.saved = saved;
    box.setAttribute("role", "group");
    box.setAttribute("aria-labelledby", "exercise-edited");
    this.head = element("h2");
    this.head.id = "exercise-edited";
    this.error = element("p", "error");
    this.error.id = "exercise-error";
    this.error.setAttribute("role", "alert");
    this.note = element("p", "plan-note");
    this.note.setAttribute("role", "status");
    box.append(this.head, ...this.buildText(), this.error, this.note,
      this.buildShips(), this.buildTemplates(), this.buildTools());
  }

  buildText() {
    const label = element("label", "label", "Exercise as JSON");
    label.htmlFor = "exercise-text";
    this.text = element("textarea", "exercise-text");
    this.text.id = "exercise-text";
    this.text.spellcheck = false;
    this.text.rows = 16;
    this.text.setAttribute("aria-describedby", "exercise-error");
    this.text.addEventListener("input", () => {
      this.fail("");
      this.offerShips();
    });
    return [label, this.text];
  }

  // Which own ship the events that are added are about, of several.
  buildShips() {
    this.about = element("div", "control");
    this.about.hidden = true;
    const label = element("label", "label", "Events about own ship");
    label.htmlFor = "exercise-about";
    this.ship = element("select", "select");
    this.ship.id = "exercise-about";
    this.about.append(label, this.ship);
    return this.about;
  }

  offerShips() {
    let ships = [];
    try {
      ships = shipsOf(JSON.parse(this.text.value));
    } catch {
      return; // as it was, until it is JSON again
    }
    const before = this.ship.value;
    this.ship.replaceChildren(...ships.map((id) => new Option(id, id)));
    if (ships.map(String).includes(before)) {
      this.ship.value = before;
    }
    this.about.hidden = ships.length < 2;
  }

  buildTemplates() {
    const row = element("div", "control");
    const label = element("label", "label", "Add an event");
    label.htmlFor = "exercise-template";
    const select = element("select", "select");
    select.id = "exercise-template";
    const made = [];
    select.append(new Option("When …", ""));
    for (const [text, kinds] of TEMPLATES) {
      const group = document.createElement("optgroup");
      group.label = text;
      group.append(...kinds.map(([word, make]) =>
        new Option(word, String(made.push(make) - 1))));
      select.append(group);
    }
    select.addEventListener("change", () => {
      const make = made[Number(select.value || NaN)];
      select.value = "";
      if (make) {
        this.add(make);
      }
    });
    row.append(label, select);
    return row;
  }

  buildTools() {
    const row = element("p", "tools-row");
    const tool = (id, text, label, action) => {
      button(row, text, label, action).id = `exercise-${id}`;
    };
    tool("check", "Check", "Ask the server whether this exercise is a good one",
      () => this.check());
    tool("keep", "Save", "Save this exercise", () => this.save(this.name));
    tool("copy", "Save as …", "Save this exercise under its title as another",
      () => this.saveAs());
    tool("close", "Close", "Close the editor without saving", () => {
      this.box.hidden = true;
      document.getElementById("exercise-edit").focus();
    });
    return row;
  }

  open(name, exercise) {
    this.name = name;
    this.head.textContent = `Editing ${name}`;
    this.put(exercise);
    this.fail("");
    this.note.textContent = "";
    this.box.hidden = false;
    this.text.focus();
    this.text.setSelectionRange(0, 0);
    this.text.scrollTop = 0;
  }

  put(exercise) {
    this.text.value = JSON.stringify(exercise, null, 2);
    this.offerShips();
  }

  fail(text, path = "") {
    this.error.textContent = text;
    this.text.setAttribute("aria-invalid", String(Boolean(text)));
    const where = path ? find(this.text.value, path) : null;
    if (where) {
      this.select(...where);
    }
  }

  select(from, to) {
    const lines = this.text.value.slice(0, from).split("\n").length;
    const height = this.text.scrollHeight /
      Math.max(this.text.value.split("\n").length, 1);
    this.text.focus();
    this.text.setSelectionRange(from, to);
    this.text.scrollTop = Math.max(0, (lines - 3) * height);
  }

  // null: it is said what is wrong.
  read() {
    try {
      return JSON.parse(this.text.value);
    } catch (error) {
      this.fail(`This is no JSON: ${error.message}`);
      return null;
    }
  }

  add(make) {
    const exercise = this.read();
    if (!exercise) {
      return;
    }
    const when = conditionOf(make, exercise, Number(this.ship.value));
    if ("after" in when && !when.after) {
      this.fail("There is no other event yet: add one first.");
      return;
    }
    if ("other" in when && when.other === undefined) {
      this.fail("There is no other ship: add one to state.entities first.");
      return;
    }
    const events = exercise.events ?? [];
    const names = new Set(events.map((e) => e.name));
    let number = events.length + 1;
    while (names.has(`event-${number}`)) {
      number++;
    }
    const name = `event-${number}`;
    this.put({ ...exercise, events: [...events, { name, when: [when],
      patch: { state: { sky: { visibility: 800 } } } }] });
    this.fail("");
    this.note.textContent = `${name} is added; say what changes in its patch.`;
    this.select(...find(this.text.value, `events.${name}`));
  }

  // --- asking -----------------------------------------------------------------------

  async ask(work, done) {
    const exercise = this.read();
    if (!exercise) {
      return;
    }
    try {
      await inTurn(() => work(exercise));
      this.fail("");
      this.note.textContent = done;
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.note.textContent = "";
      this.fail(error instanceof Problem ? error.message
        : "The server does not answer.", error.path?.replace(/^exercise\./, ""));
    }
  }

  check() {
    return this.ask((exercise) => perform("POST", "/v1/exercise",
      { action: "CHECK", exercise }, JSON_TYPE), "It is a good one.");
  }

  save(name) {
    return this.ask(async (exercise) => {
      await perform("PUT", `/v1/exercises/${encodeURIComponent(name)}`,
        exercise, JSON_TYPE);
      this.name = name;
      this.head.textContent = `Editing ${name}`;
      this.saved(name);
    }, `Saved as ${name}. Load it to begin.`);
  }

  saveAs() {
    const title = this.read()?.title;
    if (title === undefined) {
      this.fail(this.error.textContent ||
        "Give it a title first: its name is made of that.");
      return;
    }
    this.save(nameOf(title));
  }
}
