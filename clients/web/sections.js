// The sections of the panel: which field of the state each control sets. What
// is legal comes from the schema (/v1/fields).

import { perform } from "/api.js";
import { Daytime } from "/daytime.js";
import { silentInputs } from "/inputs.js";
import { button, Check, Choice, Range, Text } from "/panel.js";
import { Ship } from "/ship.js";
import { Swell } from "/swell.js";
import { words } from "/words.js";

const byId = (id) => document.getElementById(id);
const UNITS = { "m/s": "metres per second", "°": "degrees", m: "metres",
  km: "kilometres", s: "seconds", "×": "times", "°/s": "degrees per second",
  "mg/m³": "milligrams per cubic metre", "1/m": "per metre", "": "" };

export const entities = (s) => s.entities ?? [];
export const sunFixed = (s) => s.sky?.sunElevation !== undefined &&
  s.sky?.sunAzimuth !== undefined;

// Wind speeds at which each Beaufort number begins [m/s] (WMO).
const BEAUFORT = [0.3, 1.6, 3.4, 5.5, 8, 10.8, 13.9, 17.2, 20.8, 24.5, 28.5];
export const beaufort = (speed) => BEAUFORT.filter((v) => speed >= v).length;

export class Sections {
  // fields: Map of /v1/fields; views: the grid; traffic: plan and list.
  constructor(fields, views, store, traffic, time) {
    this.fields = fields;
    this.views = views;
    this.store = store;
    this.controls = [];
    this.shipControls = new Ship(this, traffic);
    this.buildSea();
    new Swell(this).build();
    this.buildSky();
    this.buildWater();
    this.buildView();
    this.shipControls.build();
    new Daytime(this, time);
    this.buildSources();
  }

  // --- building blocks --------------------------------------------------------

  add(control, depends) {
    control.depends = depends;
    this.controls.push(control);
    return control;
  }

  check(parent, id, label, { depends, ...more }) {
    return this.add(new Check(byId(parent), { store: this.store, id, label,
      ...more }), depends);
  }

  // One of a list that may change: options(state).
  pick(parent, id, label, { depends, options, ...more }) {
    const control = this.add(new Choice(byId(parent), { store: this.store, id,
      label, ...more }), depends);
    control.options = options;
    return control;
  }

  // path: of the field that gives the range, and the value unless `get` and
  // `patch` say otherwise.
  range(parent, label, path, unit, step, { depends, ...more } = {}) {
    const field = this.fields.get(path) ?? {};
    const keys = path.split(".");
    return this.add(new Range(byId(parent), { store: this.store,
      path, label, unit, unitName: UNITS[unit] ?? unit, step,
      minimum: field.minimum ?? 0, maximum: field.maximum ?? 100,
      get: (s) => keys.reduce((at, key) => at?.[key], s),
      patch: (v) => keys.reduceRight((value, key) => ({ [key]: value }), v),
      ...more,
    }), depends);
  }

  // The values of a field that can be chosen, with words for them.
  named(path) {
    const { values = [], unusable = [] } = this.fields.get(path) ?? {};
    return values.filter((v) => !unusable.includes(v)).map((v) =>
      [v, words(v)]);
  }

  choice(parent, id, label, path, depends) {
    const [part, name] = path.split(".");
    const control = new Choice(byId(parent), {
      store: this.store, id, label, get: (s) => s[part]?.[name],
      options: this.named(path), patch: (v) => ({ [part]: { [name]: v } }),
    });
    control.node.dataset.path = path;
    return this.add(control, depends);
  }

  // --- wind and swell -----------------------------------------------------------

  buildSea() {
    // Shown with the spectra that depend on it.
    const shape = (label, path, unit, step, more) => {
      const kinds = this.fields.get(path)?.spectra ?? [];
      this.range("sea", label, path, unit, step, { ...more,
        depends: (s) => kinds.includes(s.sea?.spectrum) });
    };
    this.range("sea", "Wind speed", "sea.windSpeed", "m/s", 0.1,
      { id: "wind-speed" });
    this.range("sea", "Wind from", "sea.windDirection", "°", 1,
      { id: "wind-direction" });
    this.buildSpectrum();
    this.range("sea", "Depth of the sea", "sea.depth", "m", 1, { id: "sea-depth",
      scale: "log", depends: (s) => s.sea?.spectrum === "TMA" ||
        s.sea?.depth !== undefined });
    shape("Fetch", "sea.fetch", "m", 1000, { scale: "log" });
    shape("Peak enhancement", "sea.gamma", "", 0.1);
    shape("Significant height", "sea.height", "m", 0.1);
    shape("Peak period", "sea.period", "s", 0.1);
    this.choice("sea", "synthesiser", "Waves made by", "sea.synthesiser");
    this.range("sea", "Level of the sea", "sea.level", "m", 0.1);
    const seed = this.add(new Text(byId("sea"), { store: this.store,
      id: "seed", label: "Seed of the waves", type: "number",
      get: (s) => String(s.sea?.seed ?? 1),
      patch: (v) => ({ sea: { seed: Number(v) } }),
    }));
    seed.node.classList.add("with-button");
    seed.input.after(button(seed.node, "⚄", "Another seed", () => {
      seed.input.value = Math.floor(Math.random() * 100000);
      seed.write(seed.input.value);
    }));
  }

  // A buoy's record is asked for by its station, TMA is about a depth. What is
  // wanted is so until the server has it: a refusal is said at the station.
  buildSpectrum() {
    let wanted = false;
    const wants = () => {
      wanted = wanted && this.store.told.sea?.spectrum !== "MEASURED";
      return wanted;
    };
    const spectrum = this.add(new Choice(byId("sea"), { store: this.store,
      id: "spectrum", label: "Spectrum", options: this.named("sea.spectrum"),
      get: (s) => wants() ? undefined : s.sea?.spectrum,
      chosen: (v) => {
        wanted = v === "MEASURED" && !this.store.state.sea?.measured;
        if (!wanted) {
          spectrum.write(v);
        }
        this.show();
        if (wanted) {
          station.input.focus();
        }
      },
      patch: (v) => (s) => ({ sea: { spectrum: v,
        ...(v === "TMA" && s.sea?.depth === undefined ? { depth: 20 } : {}) } }),
    }));
    spectrum.node.dataset.path = "sea.spectrum";
    const station = this.add(new Text(byId("sea"), { store: this.store,
      id: "measured", label: "Buoy's station", get: (s) => s.sea?.measured ?? "",
      patch: (v) => ({ sea: { spectrum: "MEASURED", measured: v } }),
    }), (s) => wants() || s.sea?.spectrum === "MEASURED");
  }

  // --- light and water ----------------------------------------------------------

  buildSky() {
    this.check("sky", "sun-clock", "Sun from the clock", {
      get: (s) => !sunFixed(s),
      patch: (v) => ({ sky: v ? { sunElevation: null, sunAzimuth: null,
        moonElevation: null, moonAzimuth: null, moonPhase: null }
        : { sunElevation: 30, sunAzimuth: 200 } }),
    });
    this.range("sky", "Sun elevation", "sky.sunElevation", "°", 0.5,
      { id: "sun-elevation", depends: sunFixed });
    this.range("sky", "Sun azimuth", "sky.sunAzimuth", "°", 1,
      { id: "sun-azimuth", depends: sunFixed });
    this.range("sky", "Moon elevation", "sky.moonElevation", "°", 0.5,
      { id: "moon-elevation", depends: sunFixed });
    this.range("sky", "Moon azimuth", "sky.moonAzimuth", "°", 1,
      { id: "moon-azimuth", depends: sunFixed });
    this.range("sky", "Moon's lit share", "sky.moonPhase", "", 0.01,
      { id: "moon-phase", depends: sunFixed });
    this.check("sky", "stars", "Stars and the night's own light", {
      get: (s) => s.sky?.stars !== false,
      patch: (v) => ({ sky: { stars: v } }),
    });
    this.showBodies(document.createElement("p"));
    const pictured = (s) => !!s.sky?.file;
    this.choice("sky", "picture-sun", "Sun of the sky's picture",
      "sky.fileSun", pictured);
    this.range("sky", "Picture's direction", "sky.fileAzimuth", "°", 1,
      { id: "picture-azimuth", depends: pictured });
    this.range("sky", "Picture's brightness", "sky.fileScale", "cd/m²", 1,
      { id: "picture-scale", scale: "log", depends: pictured });
    this.range("sky", "Visibility", "sky.visibility", "m", 100,
      { id: "visibility", scale: "log" });
    const cloudy = (s) => (s.sky?.cloudCover ?? 0) > 0;
    this.range("sky", "Clouds", "sky.cloudCover", "okta", 1,
      { id: "cloud-cover" });
    this.choice("sky", "cloud-genus", "Clouds are", "sky.cloudGenus", cloudy);
    this.range("sky", "Rain", "sky.rain", "mm/h", 0.5, { id: "rain" });
    this.range("sky", "Snow", "sky.snow", "mm/h", 0.1, { id: "snow" });
    this.range("sky", "Lightning", "sky.lightning", "/min", 0.5,
      { id: "lightning" });
    this.buildFog();
  }

  // The first of sky.fog.
  buildFog() {
    let fogs = [];
    const foggy = (s) => (fogs = s.sky?.fog ?? []).length > 0;
    this.check("sky", "fog", "Fog", { get: foggy,
      patch: (v) => ({ sky: { fog: v ? [{}] : [] } }) });
    const range = (name, label, key, step) => this.range("sky", label,
      `sky.fog.*.${key}`, "m", step, { id: name, scale: "asinh",
        depends: foggy, get: (s) => s.sky?.fog?.[0]?.[key],
        patch: (v) => ({ sky: { fog: [{ ...fogs[0], [key]: v },
          ...fogs.slice(1)] } }) });
    range("fog-visibility", "Visibility in it", "visibility", 10);
    range("fog-top", "Its top", "top", 5);
  }

  // Where Sun and Moon stand now, as long as the section is seen.
  showBodies(line) {
    line.className = "hint";
    line.id = "bodies";
    byId("sky").append(line);
    const height = (e) => `${Math.abs(e).toFixed(1)}° ${e < 0 ? "below" : "above"}`;
    const ask = async () => {
      if (document.hidden || line.offsetParent === null) {
        return;
      }
      try {
        const now = await perform("GET", "/v1/optics/brdf");
        line.textContent = `Sun ${height(now.sunElevation)}` +
          (now.moonElevation === undefined ? "" :
            `, Moon ${height(now.moonElevation)} the horizon, ` +
            `${Math.round(100 * now.moonPhase)} % lit`);
      } catch {
        line.textContent = "";
      }
    };
    setInterval(ask, 5000);
    setTimeout(ask, 500);
  }

  // Water is described in one of four ways; going over to one clears the rest.
  buildWater() {
    const names = ["absorption680", "absorption550", "absorption440",
      "scattering680", "scattering550", "scattering440"];
    const way = (s) => s.water?.jerlov !== undefined ? "jerlov"
      : s.water?.named !== undefined ? "named"
        : names.some((n) => s.water?.[n] !== undefined) ? "numbers"
          : "chlorophyll";
    const is = (kind) => (s) => way(s) === kind;
    const nothing = Object.fromEntries(
      ["jerlov", "named", ...names].map((n) => [n, null]));
    const clear = [0.46, 0.06, 0.02, 0.03, 0.03, 0.04];
    const given = {
      chlorophyll: {}, jerlov: { jerlov: "IB" },
      named: { named: "NORTH_ATLANTIC" },
      numbers: Object.fromEntries(names.map((n, i) => [n, clear[i]])),
    };
    this.add(new Choice(byId("water"), { store: this.store,
      id: "water-way", label: "Described by",
      options: [["chlorophyll", "Chlorophyll"], ["jerlov", "Jerlov's type"],
        ["named", "A known water"], ["numbers", "Coefficients"]],
      get: way, patch: (v) => ({ water: { ...nothing, ...given[v] } }),
    }));
    this.range("water", "Chlorophyll", "water.chlorophyll", "mg/m³", 0.01,
      { id: "chlorophyll", scale: "log", depends: is("chlorophyll") });
    this.choice("water", "jerlov", "Jerlov's type", "water.jerlov",
      is("jerlov"));
    this.choice("water", "named", "Known water", "water.named", is("named"));
    for (const name of names) {
      const [, kind, band] = name.match(/^(\w+?)(\d+)$/);
      this.range("water", `${words(kind.toUpperCase())} at ${band} nm`,
        `water.${name}`, "1/m", 0.001,
        { scale: kind === "absorption" ? "log" : "asinh",
          depends: is("numbers") });
    }
    this.range("water", "Depth, for its colour", "water.depth", "m", 0.1,
      { id: "water-depth", scale: "log" });
    this.choice("water", "bottom", "Bottom", "water.bottom");
  }

  // --- camera --------------------------------------------------------------

  buildView() {
    const view = (s, name = this.views.name) =>
      (s.views ?? []).find((v) => v.name === name);
    const there = (s) => view(s) !== undefined;
    // Of the view that is chosen now, even when another is when it is sent.
    const about = { target: () => this.views.name,
      targetName: "that view", sure: 1 };
    const patch = (field) => (v) => {
      const { name } = this.views;
      return (s) => view(s, name) ? { views: { [name]: { [field]: v } } } : null;
    };
    const range = (label, name, unit, step, more = {}) =>
      this.range("view", label, `views.*.${name}`, unit, step, {
        depends: there, get: (s) => view(s)?.[name], patch: patch(name),
        ...about, ...more });
    this.pick("view", "view-name", "View", {
      get: () => this.views.name, chosen: (v) => this.views.choose(v),
      options: (s) => (s.views ?? []).map((v) => [v.name, v.name]),
    });
    this.shipControls.buildFollow(about, (make) => {
      const { name } = this.views;
      return (s) => {
        const there = view(s, name);
        return there ? { views: { [name]: make(there, s) } } : null;
      };
    });
    for (const [label, name] of [["Latitude", "latitude"],
      ["Longitude", "longitude"]]) {
      range(label, `at.${name}`, "°", 0.0001, { id: `view-${name}`,
        depends: (s) => view(s)?.at !== undefined,
        get: (s) => view(s)?.at?.[name],
        patch: (v) => patch("at")({ [name]: v }) });
    }
    range("Yaw, to starboard of the bow", "yaw", "°", 1, { id: "yaw" });
    range("Pitch, upward", "pitch", "°", 0.5, { id: "pitch" });
    range("Roll, right side down", "roll", "°", 0.5, { id: "roll" });
    range("Field of view", "fieldOfView", "°", 1, { id: "field-of-view",
      depends: (s) => there(s) && view(s).frustum === undefined });
    // A place may have its own.
    range("Height above the ship's reference", "up", "m", 0.5,
      { id: "up", scale: "asinh",
        get: (s) => view(s)?.at?.height ?? view(s)?.up,
        patch: (v) => {
          const { name } = this.views;
          return (s) => view(s, name) ? { views: { [name]:
            view(s, name).at?.height === undefined ? { up: v }
              : { at: { height: v } } } } : null;
        } });
    range("Towards the bow", "forward", "m", 0.5, { scale: "asinh" });
    range("To starboard", "right", "m", 0.5, { scale: "asinh" });
    this.check("view", "auto-exposure", "Exposure by what it sees", { ...about,
      depends: there, get: (s) => view(s)?.exposure === undefined,
      patch: (v) => patch("exposure")(v ? null : 14),
    });
    range("Exposure", "exposure", "EV", 0.1, { id: "exposure",
      depends: (s) => view(s)?.exposure !== undefined });
    this.check("view", "meter", "Exposed like the other views that say so", {
      ...about, depends: (s) => view(s) && view(s).exposure === undefined,
      get: (s) => view(s)?.meter !== undefined,
      patch: (v) => patch("meter")(v ? "all" : null),
    });
    const tone = this.add(new Choice(byId("view"), { store: this.store,
      id: "tone", label: "Tone", ...about, get: (s) => view(s)?.tone,
      options: this.named("views.*.tone"), patch: patch("tone") }), there);
    tone.node.dataset.path = "views.*.tone";
    const vision = this.add(new Choice(byId("view"), { store: this.store,
      id: "vision", label: "Seen by", ...about, get: (s) => view(s)?.vision,
      options: this.named("views.*.vision"), patch: patch("vision") }),
    there);
    vision.node.dataset.path = "views.*.vision";
    range("Glare, share of light", "glare", "", 0.005, { id: "glare" });
    range("Shutter", "shutter", "s", 0.0005, { id: "shutter" });
    range("Drops on the lens", "wetLens", "", 0.05, { id: "wet-lens" });
    this.check("view", "antialiasing", "Smooth outlines", { ...about,
      get: (s) => view(s)?.antialiasing, patch: patch("antialiasing") });
    this.add(new Choice(byId("view"), { store: this.store, id: "sensor",
      label: "Sensor", ...about, get: (s) => view(s)?.sensor?.kind ?? "",
      options: [["", "None"], ...this.named("views.*.sensor.kind")],
      patch: (v) => patch("sensor")(v ? { kind: v } : null) }), there);
    this.check("view", "radar", "Radar", { ...about, depends: there,
      get: (s) => view(s)?.radar !== undefined,
      patch: (v) => patch("radar")(v ? {} : null) });
    this.range("view", "Its range", "views.*.radar.range", "nmi", 0.25, {
      ...about, scale: "asinh", depends: (s) => view(s)?.radar !== undefined,
      get: (s) => view(s)?.radar?.range,
      patch: (v) => patch("radar")({ range: v }) });
    const level = button(byId("view"), "Ahead and level",
      "Look ahead, level, with a field of view of 60 degrees", () => {
        this.views.chosen?.look.want({ yaw: 0, pitch: 0, roll: 0,
          ...(this.views.chosen.view.frustum ? {} : { fieldOfView: 60 }) });
      }, "views.*.yaw");
    level.id = "level";
  }

  ship(s, id = this.shipId) {
    return this.shipControls.of(s, id);
  }

  buildSources() {
    this.check("sources", "mark", "Pictures say which one is silent", {
      get: (s) => Boolean(s.sources?.mark),
      patch: (v) => ({ sources: { mark: v } }),
    });
    this.add({ show: (s) => {
      const silent = silentInputs(s);
      byId("inputs").textContent = silent ? `silent: ${silent}`
        : "none is silent";
    } });
  }

  // --- showing ----------------------------------------------------------------------

  // renewed: another view, ship or train is chosen.
  show(renewed = false) {
    const { state } = this.store;
    if (!this.ship(state)) {
      const first = entities(state)[0];
      this.shipId = first ? String(first.id ?? 0) : null;
    }
    const ship = this.ship(state);
    document.getElementById("ship-edited").textContent =
      ship?.name || `entity ${this.shipId}`;
    for (const control of this.controls) {
      if (renewed) {
        control.renew?.();
      }
      if (control.options instanceof Function) {
        control.setOptions(control.options(state));
      }
      control.show(state);
      if (control.depends) {
        control.enabled = control.depends(state);
      }
    }
  }

  // The server answers.
  heard() {
    for (const control of this.controls) {
      control.heard?.();
    }
  }
}
