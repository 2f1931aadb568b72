// The controls of the entity that is chosen: what it is, how it moves; and of
// the view, what it goes with.

import { angleOf, around, distanceOf, eyeNames, eyeOf, taken, usual, wayOf }
  from "/follow.js";
import { bearing, cameraOf, offset, reckoned, wrap } from "/geo.js";
import { button, Text } from "/panel.js";
import { words } from "/words.js";

const byId = (id) => document.getElementById(id);
const entities = (s) => s.entities ?? [];
const half = (angle) => wrap(angle + 180) - 180;
const hex = (colour) => `#${colour.toString(16).padStart(6, "0")}`;
const isOwn = (s, id) => String(s.ownShip?.entity ?? 1) === id;
const PARTS = ["length", "beam", "draught", "height", "colour"];

// What a view stands on, where that is no entity.
const PLACE = "place";
const WAY = "way";

function standOf(view) {
  const moves = view?.orbit || view?.satellite || view?.waypoints?.length;
  return view?.at ? PLACE : moves ? WAY : String(view?.entity ?? "");
}

export class Ship {
  // panel: Sections, whose controls these are; traffic: list and plan.
  constructor(panel, traffic) {
    this.panel = panel;
    this.traffic = traffic;
    this.catalogue = traffic.catalogue;
    // Shapes that nobody has used yet are listed without their eye points.
    this.waiting = null;
    traffic.shapesCame = () => this.moveLater();
    this.about = { target: () => panel.shipId, targetName: "that ship",
      sure: 1 };
  }

  of(state, id = this.panel.shipId) {
    return entities(state).find((e) => String(e.id ?? 0) === id);
  }

  // A patch of the entity that is chosen now.
  patch(make) {
    return (value) => {
      const id = this.panel.shipId;
      return (state) => this.of(state, id)
        ? { entities: { [id]: make(value, this.of(state, id)) } } : null;
    };
  }

  range(label, path, unit, step, { depends, ...more }) {
    this.panel.range("ship", label, `entities.*.${path}`, unit, step, {
      ...this.about, depends: (s) => this.of(s) !== undefined &&
        (depends?.(this.of(s)) ?? true), ...more });
  }

  build() {
    const { panel } = this;
    panel.pick("ship", "ship-id", "Ship", {
      get: () => panel.shipId, chosen: (v) => this.traffic.choose(Number(v)),
      options: (s) => entities(s).map((e) =>
        [String(e.id ?? 0), e.name || `entity ${e.id ?? 0}`]),
    });
    this.buildShape();
    const plain = (label, name, unit, step, id) => this.range(label, name,
      unit, step, { id, get: (s) => this.of(s)?.[name],
        patch: this.patch((v) => ({ [name]: v })) });
    plain("Heading", "heading", "°", 1, "heading");
    plain("Course", "course", "°", 1, "course");
    plain("Speed", "speed", "m/s", 0.1, "speed");
    plain("Turn rate", "turnRate", "°/s", 0.1, "turn-rate");
    plain("Pitch, bow up", "pitch", "°", 0.1, "ship-pitch");
    plain("Roll, starboard down", "roll", "°", 0.1, "ship-roll");
    this.buildOwn();
    this.buildLights();
    const row = document.createElement("p");
    row.className = "tools-row";
    byId("ship").append(row);
    button(row, "Look at it", "Turn the chosen view towards it",
      () => this.lookAt(), "views.*.yaw").id = "look-at";
    button(row, "Follow it", "The chosen view goes with it, behind it",
      () => this.followIt(), "views.*.entity").id = "follow-it";
    button(row, "Remove", "Remove it from the sea",
      () => this.traffic.remove(Number(panel.shipId)), "entities").id =
      "remove";
  }

  buildShape() {
    const { panel, catalogue } = this;
    const there = (s) => this.of(s) !== undefined;
    const name = panel.add(new Text(byId("ship"), { store: panel.store,
      id: "ship-name", label: "Name", ...this.about,
      get: (s) => this.of(s)?.name, patch: this.patch((v) => ({ name: v })),
    }), there);
    name.input.maxLength = 64;
    panel.pick("ship", "ship-model", "Shape", { ...this.about, depends: there,
      get: (s) => this.of(s)?.model?.name ?? "",
      options: (s) => this.shapes(this.of(s)),
      patch: (v) => this.shape(v) });
    const size = (label, part, step, more) => this.range(label,
      `model.${part}`, "m", step, { id: `ship-${part}`, scale: "log",
        get: (s) => {
          const value = catalogue.sizes(this.of(s))[part];
          return value > 0 ? value : undefined;
        },
        depends: (e) => e.model !== undefined, ...more,
        patch: this.patch((v) => ({ model: { [part]: v } })) });
    const own = (e) => catalogue.of(e)?.builtin === true;
    size("Length", "length", 0.1);
    size("Beam", "beam", 0.1);
    size("Draught", "draught", 0.1, { depends: own });
    size("Height above the water", "height", 0.1, { depends: own });
    panel.add(new Text(byId("ship"), { store: panel.store, id: "ship-colour",
      label: "Colour of the hull", type: "color", ...this.about,
      get: (s) => hex(this.of(s)?.model?.colour ?? 0x808890),
      patch: this.patch((v) =>
        ({ model: { colour: Number.parseInt(v.slice(1), 16) } })),
    }), (s) => own(this.of(s)));
    panel.check("ship", "afloat", "The waves move it", { ...this.about,
      depends: (s) => this.of(s)?.model !== undefined,
      get: (s) => Boolean(this.of(s)?.afloat),
      patch: this.patch((v) => ({ afloat: v })) });
  }

  // Views that it carries go to where one sees out of it.
  shape(name) {
    const id = this.panel.shipId;
    const { catalogue } = this;
    return (state) => {
      const entity = this.of(state, id);
      if (!entity) {
        return null;
      }
      const change = name === "" ? { model: null }
        : { afloat: entity.afloat || entity.model === undefined,
          model: { ...Object.fromEntries(PARTS.map((n) => [n, null])),
            name } };
      const was = { model: catalogue.of(entity),
        sizes: catalogue.sizes(entity) };
      const what = { id, name, was };
      this.waiting = name === "" || this.known(name) ? null : what;
      return { entities: { [id]: change },
        ...(this.waiting ? {} : this.moves(state, what)) };
    };
  }

  known(name) {
    const model = this.catalogue.byName.get(name);
    return Boolean(model?.bytes || model?.error);
  }

  // New places of the views that the ship carries, after a change of shape.
  moves(state, { id, name, was }) {
    const next = { model: { name } };
    const model = this.catalogue.of(next);
    const views = (state.views ?? []).filter((v) => name !== "" &&
      standOf(v) === id).map((v) =>
      [v.name, taken(v, was, model, this.catalogue.sizes(next))])
      .filter(([, place]) => place);
    return views.length ? { views: Object.fromEntries(views) } : {};
  }

  moveLater() {
    const { waiting, panel: { store } } = this;
    if (waiting && this.known(waiting.name) &&
        this.of(store.told, waiting.id)?.model?.name === waiting.name) {
      this.waiting = null;
      store.ask("eye points", (state) => {
        const change = this.moves(state, waiting);
        return change.views ? change : null;
      }, { sure: 1 }).catch(() => {});
    }
  }

  shapes(entity) {
    const names = this.catalogue.models.filter((m) => !m.error)
      .map((m) => m.name);
    const now = entity?.model?.name;
    return [["", "None"], ...[...new Set([...names, ...(now ? [now] : [])])]
      .map((n) => [n, this.catalogue.byName.get(n)?.builtin ? words(n) : n])];
  }

  // Its helm: ownShip where that names it, else the entity's own.
  helm(state) {
    return isOwn(state, this.panel.shipId) ? state.ownShip
      : this.of(state)?.helm;
  }

  buildOwn() {
    const { panel } = this;
    const order = (name) => (value) => {
      const id = panel.shipId;
      return (state) => isOwn(state, id) ? { ownShip: { [name]: value } }
        : { entities: { [id]: { helm: { [name]: value } } } };
    };
    panel.check("ship", "own-ship", "It answers rudder and engine", {
      ...this.about, depends: (s) => this.of(s) !== undefined,
      get: (s) => Boolean(this.helm(s)?.on), patch: order("on") });
    const turn = (label, name, unit, step) =>
      panel.range("ship", label, `ownShip.${name}`, unit, step, {
        ...this.about, depends: (s) => Boolean(this.helm(s)?.on),
        get: (s) => this.helm(s)?.[name], patch: order(name) });
    turn("Rudder", "rudder", "°", 1);
    turn("Throttle", "throttle", "", 0.05);
  }

  // What it shows by night.
  buildLights() {
    const { panel } = this;
    const there = (s) => this.of(s) !== undefined;
    const lit = (s) => ["AUTO", "ON"].includes(this.of(s)?.lights);
    const pick = (id, label, name, depends) => panel.pick("ship", id, label, {
      ...this.about, depends, get: (s) => this.of(s)?.[name],
      options: () => panel.named(`entities.*.${name}`),
      patch: this.patch((v) => ({ [name]: v })) });
    pick("ship-lights", "Lights", "lights", there);
    pick("ship-status", "What it does", "navigationStatus", lit);
    panel.add(new Text(byId("ship"), { store: panel.store, id: "ship-light",
      label: "A mark's light, as Fl(2) R 10s", ...this.about,
      get: (s) => this.of(s)?.light?.character,
      patch: this.patch((v) => ({ light: { character: v } })) }), lit);
    panel.check("ship", "deck-lights", "Deck lights", { ...this.about,
      depends: (s) => this.of(s)?.model !== undefined,
      get: (s) => Boolean(this.of(s)?.deckLights),
      patch: this.patch((v) => ({ deckLights: v })) });
    panel.check("ship", "searchlight", "Searchlight", { ...this.about,
      depends: there, get: (s) => Boolean(this.of(s)?.searchlight?.on),
      patch: this.patch((v) => ({ searchlight: { on: v } })) });
    const point = (label, name, id) => this.range(label, `searchlight.${name}`,
      "°", 1, { id, depends: (e) => Boolean(e.searchlight?.on),
        get: (s) => this.of(s)?.searchlight?.[name],
        patch: this.patch((v) => ({ searchlight: { [name]: v } })) });
    point("It points to", "bearing", "search-bearing");
    point("It points up", "elevation", "search-elevation");
  }

  // --- the view ---------------------------------------------------------------------

  view(state) {
    return (state.views ?? []).find((v) => v.name === this.panel.views.name);
  }

  lookAt() {
    const { state } = this.panel.store;
    const [view, ship] = [this.view(state), this.of(state)];
    if (view && ship) {
      const time = this.traffic.time();
      const eye = cameraOf(view, state, time);
      if (!eye || view.orbit || view.lookAt) {
        this.panel.views.chosen?.look.want({ pitch: 0, yaw: 0,
          lookAt: { entity: ship.id ?? 0 } });
        return;
      }
      const way = offset(eye, reckoned(ship, time, state.clock?.reckoning));
      const bow = eye.bearing - (view.yaw ?? 0);
      this.panel.views.chosen?.look.want({ pitch: 0,
        yaw: Math.round(half(bearing(way) - bow) * 10) / 10 });
    }
  }

  followIt() {
    const { state } = this.panel.store;
    const ship = this.of(state);
    if (ship) {
      this.panel.views.chosen?.look.want({ entity: ship.id ?? 0,
        ...around(this.catalogue.sizes(ship), 180) });
    }
  }

  carrier(state, view = this.view(state)) {
    return view?.entity === undefined ? undefined
      : entities(state).find((e) => (e.id ?? 0) === view.entity);
  }

  // about, patch: as sections.js has them for fields of the view.
  buildFollow(about, patch) {
    const { panel, catalogue } = this;
    panel.pick("view", "view-entity", "Goes with", { ...about,
      depends: (s) => this.view(s) !== undefined,
      get: (s) => standOf(this.view(s)),
      options: (s) => [["", "Nothing: fixed to the world"],
        [PLACE, "Nothing: a place on Earth"],
        ...(standOf(this.view(s)) === WAY ? [[WAY, "A way of its own"]] : []),
        ...entities(s).map((e) =>
          [String(e.id ?? 0), e.name || `entity ${e.id ?? 0}`])],
      patch: (v) => patch((view, state) => this.change(state, view, v)) });
    const carried = (s) => this.carrier(s) !== undefined;
    panel.pick("view", "view-way", "Seen from", { ...about, depends: carried,
      get: (s) => carried(s)
        ? this.wayNow(s) : "free",
      options: (s) => this.ways(s),
      patch: (v) => patch((view, state) =>
        this.place(state, view, v)) });
    const turns = (s) => carried(s) &&
      ["chase", "orbit"].includes(this.wayNow(s));
    const orbit = (view, state, angle, distance) =>
      around(catalogue.sizes(this.carrier(state, view)), angle, distance);
    panel.range("view", "Around it, from the bow", "views.*.yaw", "°", 1, {
      ...about, id: "orbit", minimum: 0, maximum: 360, depends: turns,
      get: (s) => this.view(s) && Math.round(angleOf(this.view(s))),
      patch: (v) => patch((view, state) =>
        orbit(view, state, v, distanceOf(view))) });
    panel.range("view", "Distance from it", "views.*.forward", "m", 1, {
      ...about, id: "orbit-distance", minimum: 5, maximum: 5000, scale: "log",
      depends: turns, get: (s) => this.view(s) && distanceOf(this.view(s)),
      patch: (v) => patch((view, state) =>
        orbit(view, state, angleOf(view), v)) });
  }

  wayNow(state, view = this.view(state)) {
    const carrier = this.carrier(state, view);
    return wayOf(view, this.catalogue.of(carrier),
      this.catalogue.sizes(carrier).length);
  }

  ways(state) {
    const eyes = eyeNames(this.catalogue.of(this.carrier(state)));
    return [...eyes.map((name, i) => [`eye ${i}`, `Its ${name}`]),
      ["chase", "Behind it"], ["orbit", "Around it"], ["free", "As set below"]];
  }

  // Another carrier: the same way where it has that, else behind it.
  change(state, view, value) {
    const nowhere = { ...(view.at && { at: null }),
      ...(view.orbit && { orbit: null }),
      ...(view.satellite && { satellite: null }),
      ...(view.waypoints?.length && { waypoints: [] }) };
    if (value === "") {
      return { ...nowhere, entity: null, forward: 0, right: 0, up: 15,
        level: false };
    }
    if (value === PLACE) {
      const eye = cameraOf(view, state, state.clock?.time ?? 0) ?? state.origin;
      return { ...nowhere, entity: null, level: false,
        at: { latitude: eye.latitude, longitude: eye.longitude } };
    }
    if (value === WAY) {
      return {};
    }
    const next = { ...view, entity: Number(value) };
    const model = this.catalogue.of(this.carrier(state, next));
    const was = this.wayNow(state, view);
    const way = was.startsWith("eye") && !model?.eyes?.length ? "chase"
      : was === "free" && model ? (model.eyes?.length ? "eye 0" : "chase")
        : was.startsWith("eye") ? "eye 0" : was;
    return { ...nowhere, entity: next.entity,
      ...this.place(state, next, way) };
  }

  place(state, view, way) {
    const carrier = this.carrier(state, view);
    const model = this.catalogue.of(carrier);
    const sizes = this.catalogue.sizes(carrier);
    return way.startsWith("eye")
      ? eyeOf(model, Number(way.slice(4)), sizes.length)
      : way === "chase" ? around(sizes, 180)
        : way === "orbit" ? around(sizes, 130, usual(sizes))
          : { level: false };
  }
}
