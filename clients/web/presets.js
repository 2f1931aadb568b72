// Presets: seas, waters, weather and times of day that a teacher sets by one
// choice, and own ones, which the server keeps in the state.

import { Gone, Problem } from "/api.js";
import { reckoned, wrap } from "/geo.js";
import { button } from "/panel.js";
import { ownShip } from "/scenes.js";
import { BEAUFORT, words } from "/words.js";

const byId = (id) => document.getElementById(id);
const PARTS = ["sea", "sky", "water"];
// Other ways to write what the state keeps elsewhere.
const NOT_KEPT = ["sea.beaufort", "sea.douglas", "sky.metar"];

// Wind in the middle of each Beaufort number's class, m/s (WMO); 11's as much
// as the sea takes.
const WIND = [0, 0.9, 2.4, 4.4, 6.7, 9.3, 12.3, 15.5, 18.9, 22.6, 26.4, 30];
const seas = WIND.map((speed, i) => [`${i} ${BEAUFORT[i]}`,
  () => ({ sea: { windSpeed: speed, spectrum: "PIERSON_MOSKOWITZ",
    swell: [] } })]);

// What one weather sets and another must not leave.
const weather = (sky) => () => ({ sky: { cloudCover: 0, cloudGenus: "CUMULUS",
  cloudBase: null, cloudThickness: null, fog: [], rain: 0, snow: 0,
  lightning: 0, visibility: 40000, ...sky } });
const WEATHER = [
  ["Clear", weather({})],
  ["Overcast", weather({ cloudCover: 8, cloudGenus: "STRATUS",
    visibility: 15000 })],
  ["Fog", weather({ cloudCover: 0, visibility: 2000,
    fog: [{ visibility: 250, top: 60 }] })],
  ["Rain", weather({ cloudCover: 8, cloudGenus: "NIMBOSTRATUS", rain: 6,
    visibility: 8000 })],
  ["Snow", weather({ cloudCover: 8, cloudGenus: "NIMBOSTRATUS", snow: 1.5,
    visibility: 4000 })],
  ["Thunder", weather({ cloudCover: 7, cloudGenus: "CUMULONIMBUS", rain: 20,
    lightning: 8, visibility: 9000 })],
];

// Directions are off the bow, so that own ship's view has the light in it.
const light = (sun, moon) => (bow) => ({ sky: {
  sunElevation: sun[0], sunAzimuth: wrap(Math.round(bow + sun[1])),
  moonElevation: moon ? moon[0] : null,
  moonAzimuth: moon ? wrap(Math.round(bow + moon[1])) : null,
  moonPhase: moon ? 1 : null, stars: true } });
const TIMES = [
  ["Noon", light([58, 100])], ["Evening", light([7, 35])],
  ["Dusk", light([-5, 20])], ["Moonlit night", light([-35, 180], [28, 15])],
  ["Starlit night", light([-35, 180])],
];

// A name as the server takes it, of a title that may be any text.
export function nameOf(title) {
  const plain = title.normalize("NFKD").replaceAll("ß", "ss")
    .replace(/[\u0300-\u036f]/g, "").replace(/[^A-Za-z0-9_-]+/g, "-")
    .replace(/^-+|-+$/g, "").slice(0, 64);
  return plain || "preset";
}

// The merge patch that brings sea, sky and water back to what they are.
export function patchOf(state, paths) {
  const patch = {};
  for (const path of paths) {
    const [part, name] = path.split(".");
    if (PARTS.includes(part) && name && !NOT_KEPT.includes(path)) {
      patch[part] = patch[part] ?? {};
      patch[part][name] = state[part]?.[name] ?? null;
    }
  }
  return patch;
}

export class Presets {
  constructor(store, fields, time) {
    this.store = store;
    this.fields = fields;
    this.time = time;
    const box = byId("presets");
    this.list(box, "preset-sea", "Sea", [["Beaufort", seas]]);
    this.list(box, "preset-water", "Water", this.waters());
    this.list(box, "preset-weather", "Weather", [["", WEATHER]]);
    this.list(box, "preset-time", "Time of day", [["", TIMES]]);
    this.buildOwn();
  }

  waters() {
    const group = (name, text) => [text,
      (this.fields.get(`water.${name}`)?.values ?? []).map((value) => [
        words(value), () => ({ water: { ...this.noWater(), [name]: value } })])];
    return [group("named", "Known waters"), group("jerlov", "Jerlov's types")];
  }

  // Each of the ways to describe water leaves the others.
  noWater() {
    return Object.fromEntries([...this.fields.keys()].filter((path) =>
      /^water\.(named|jerlov|(absorption|scattering)\d+)$/.test(path))
      .map((path) => [path.slice(6), null]));
  }

  list(box, id, label, groups) {
    const row = document.createElement("div");
    row.className = "control wide";
    const name = document.createElement("label");
    name.className = "label";
    name.htmlFor = id;
    name.textContent = label;
    const select = document.createElement("select");
    select.className = "select";
    select.id = id;
    select.append(new Option("Choose …", ""));
    const made = [];
    for (const [text, options] of groups) {
      const parent = text ? document.createElement("optgroup") : select;
      parent.label = text;
      for (const [word, make] of options) {
        parent.append(new Option(word, String(made.push([word, make]) - 1)));
      }
      if (text) {
        select.append(parent);
      }
    }
    select.addEventListener("change", () => {
      const [word, make] = made[Number(select.value)] ?? [];
      if (make) {
        this.set(`${label}: ${word}`, (state) => make(this.bow(state)));
      }
    });
    row.append(name, select);
    box.append(row);
  }

  bow(state) {
    return reckoned(ownShip(state) ?? {}, this.time()).heading;
  }

  say(text, wrong = false) {
    const note = byId("preset-note");
    note.textContent = text;
    note.classList.toggle("error", wrong);
    note.hidden = text === "";
  }

  async set(what, make, done = `${what}, set.`) {
    try {
      await this.store.ask(`preset ${what}`, make, { sure: 2 });
      this.say(done);
      return true;
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.say(error instanceof Gone ? "Not set: the server does not answer."
        : error.line ?? error.message, true);
      return false;
    }
  }

  // --- own ones -----------------------------------------------------------------

  buildOwn() {
    this.own = byId("preset-own");
    this.title = byId("preset-title");
    const row = byId("preset-own-buttons");
    this.apply = button(row, "Apply", "Apply the chosen preset", () => {
      const preset = this.chosen();
      if (preset) {
        this.set(preset.title ?? preset.name,
          () => JSON.parse(preset.patch ?? "{}"));
      }
    });
    this.remove = button(row, "Delete", "Delete the chosen preset", () => {
      const preset = this.chosen();
      if (preset) {
        this.set(preset.name, () => ({ presets: { [preset.name]: null } }),
          `“${preset.title ?? preset.name}” is deleted.`);
      }
    });
    button(byId("preset-save-row"), "Save", "Save sea, sky and water as a preset",
      () => this.save());
    this.title.addEventListener("keydown", (event) => {
      if (event.key === "Enter") {
        event.preventDefault();
        this.save();
      }
    });
  }

  chosen() {
    return (this.store.state.presets ?? []).find((p) =>
      p.name === this.own.value);
  }

  async save() {
    const title = this.title.value.trim();
    if (!title) {
      this.say("A preset needs a name.", true);
      this.title.focus();
      return;
    }
    const name = nameOf(title);
    const good = await this.set(title, (state) => ({ presets: { [name]: { title,
      patch: JSON.stringify(patchOf(state, this.fields.keys())) } } }),
    `Sea, sky and water are saved as “${title}”.`);
    if (good) {
      this.title.value = "";
      this.show(this.store.state);
      this.own.value = name;
    }
  }

  show(state) {
    const list = state.presets ?? [];
    const key = JSON.stringify(list.map((p) => [p.name, p.title]));
    byId("preset-own-row").hidden = list.length === 0;
    if (key !== this.key) {
      this.key = key;
      const { value } = this.own;
      this.own.replaceChildren(...list.map((p) =>
        new Option(p.title ?? p.name, p.name)));
      if (list.some((p) => p.name === value)) {
        this.own.value = value;
      }
    }
  }
}
