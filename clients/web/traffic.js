// The plan and the list of what is on the sea: adding, choosing, moving,
// removing. The controls of the one that is chosen are sections.js's.

import { Gone, Problem } from "/api.js";
import { Catalogue, GROUPS, isAdrift, isMark } from "/catalogue.js";
import { bearing, cameraOf, knots, metres, offset, reckoned, three }
  from "/geo.js";
import { Ground } from "/ground.js";
import { Measure } from "/measure.js";
import { button } from "/panel.js";
import { Plan } from "/plan.js";
import { PlanHands } from "/planhands.js";
import { mayPatch } from "/rights.js";
import { buildScenes, freeId, LONG_S, ownShip } from "/scenes.js";
import { words } from "/words.js";

const DRAGGING_MS = 150;
const LIST_MS = 500;
const SURE_MS = 4000;
const byId = (id) => document.getElementById(id);
const entities = (s) => s.entities ?? [];

function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className || "";
  node.textContent = text || "";
  return node;
}

export class Traffic {
  // chosen(id): another entity is; time(): simulated time of the pictures.
  constructor({ store, views, time, chosen }) {
    Object.assign(this, { store, views, time, chosen });
    this.catalogue = new Catalogue(() => {
      this.offer();
      this.show();
      chosen();
      this.shapesCame?.();
    });
    this.rows = new Map();
    this.armed = false;
    this.plan = new Plan(byId("plan"), { store, views, time,
      catalogue: this.catalogue });
    new PlanHands(this.plan, {
      adding: () => this.armed,
      cancel: () => this.arm(false),
      choose: (id) => this.choose(id),
      next: (by) => this.next(by),
      move: (id, place, done) => this.move(id, place, done),
      moves: (entity) => mayPatch({ entities: { [entity.id ?? 0]:
        { latitude: 0, longitude: 0 } } }, store.state),
      put: (place, motion) => this.put(place, motion),
      remove: () => this.remove(),
    });
    this.buildTools();
    buildScenes(byId("scenes"), store, { time,
      done: (name) => {
        this.say("");
        if (name === "Harbour") {
          this.plan.fit();
        }
      },
      failed: (error) => this.fail(error) });
    addEventListener("pelagos-notice", (event) => this.say(event.detail));
    this.catalogue.load();
    setInterval(() => this.list(), LIST_MS);
  }

  // --- tools ------------------------------------------------------------------------

  buildTools() {
    const tools = byId("plan-tools");
    button(tools, "−", "Plan: show more of the sea", () => this.plan.zoom(1.5));
    button(tools, "+", "Plan: show it larger", () => this.plan.zoom(1 / 1.5));
    button(tools, "All", "Plan: show everything", () => this.plan.fit());
    button(tools, "Own", "Plan: stay with own ship",
      () => this.plan.home());
    this.up = button(tools, "North up", "Plan: north up or head up", () => {
      this.plan.headUp = !this.plan.headUp;
      this.up.textContent = this.plan.headUp ? "Head up" : "North up";
      this.plan.soon();
    });
    this.up.id = "plan-up";
    this.measure = new Measure(this.plan, button(tools, "Measure",
      "Plan: range and bearing between two points (M)", () => {}),
    (text) => this.say(text));
    this.measure.node.id = "plan-measure";
    this.ground = new Ground(this.plan);
    this.kind = byId("add-model");
    // Files that came since are listed too.
    this.kind.addEventListener("focus", () => this.catalogue.load());
    // Choosing arms; who then presses the button means the same.
    this.kind.addEventListener("change", () => {
      this.arm(true);
      this.chose = true;
    });
    byId("add").addEventListener("click", () =>
      this.arm(this.chose || !this.armed));
    byId("go-on").addEventListener("click", () => this.goOn());
    byId("clear").addEventListener("click", () => this.askClear());
  }

  offer() {
    const before = this.kind.value;
    this.kind.replaceChildren(...GROUPS.map(([label, holds]) => {
      const group = document.createElement("optgroup");
      group.label = label;
      group.append(...this.catalogue.models.filter(holds).map((m) => {
        const option = element("option", "",
          m.error ? `${m.name} (${m.error.message.replace(`${m.name}: `, "")})`
            : m.builtin ? words(m.name) : m.name);
        option.value = m.name;
        option.disabled = Boolean(m.error);
        option.title = m.text ?? "";
        return option;
      }));
      return group;
    }).filter((group) => group.children.length > 0));
    this.kind.value = this.catalogue.byName.has(before) ? before : "ferry";
  }

  arm(on) {
    this.chose = false;
    this.armed = on && this.catalogue.models.length > 0;
    byId("add").setAttribute("aria-pressed", String(this.armed));
    this.plan.canvas.classList.toggle("adding", this.armed);
    this.plan.adding = null;
    this.say(this.armed ? "Click its place on the plan, and pull away to give " +
      "it course and speed. With keys: arrows, Enter; Esc ends." : "");
    this.plan.soon();
  }

  say(text, wrong = false) {
    const note = byId("plan-note");
    note.textContent = text;
    note.classList.toggle("error", wrong);
    note.hidden = !text;
  }

  fail(error) {
    if (!(error instanceof Problem || error instanceof Gone)) {
      throw error;
    }
    this.say(error.line ?? "Not sent: the server does not answer.", true);
  }

  // --- what is done ------------------------------------------------------------------

  async do(key, make, pace = {}) {
    try {
      await this.store.ask(key, make, pace);
      this.say("");
      return true;
    } catch (error) {
      this.fail(error);
      return false;
    }
  }

  async put(place, { course, speed }) {
    const model = this.catalogue.byName.get(this.kind.value);
    const still = isMark(model) || isAdrift(model);
    let id;
    this.arm(false);
    const there = await this.do(`put ${this.puts = (this.puts ?? 0) + 1}`,
      (state) => {
        id = freeId(state);
        return { entities: { [id]: { name: this.nameOf(model, state),
          model: { name: model.name }, afloat: true, lights: "AUTO", ...place,
          heading: course, course, speed: still ? 0 : speed } } };
      }, { sure: 2 });
    if (there) {
      this.choose(id);
    }
  }

  // "ferry 2", where there is a ferry.
  nameOf(model, state) {
    const base = model.name.split("/").at(-1).replace(/\.\w+$/, "")
      .replaceAll("-", " ");
    const names = new Set(entities(state).map((e) => e.name));
    for (let i = 1; ; i++) {
      const name = i > 1 ? `${base} ${i}` : base;
      if (!names.has(name)) {
        return name;
      }
    }
  }

  async move(id, place, done) {
    await this.do(`place ${id}`, (state) => {
      if (!entities(state).some((e) => (e.id ?? 0) === id)) {
        return null;
      }
      const sails = state.ownShip?.on && (state.ownShip.entity ?? 1) === id;
      const { helm } = entities(state).find((e) => (e.id ?? 0) === id);
      return { entities: { [id]: { ...place,
        ...(helm?.on ? { helm: { on: true } } : {}) } },
        ...(sails ? { ownShip: { on: true } } : {}) };
    }, { everyMs: DRAGGING_MS, sure: 1 });
    done();
  }

  remove(id = this.plan.selected) {
    return mayPatch({ entities: { [id]: null } }, {}) && this.do(`remove ${id}`, (state) =>
      entities(state).some((e) => (e.id ?? 0) === id)
        ? { entities: { [id]: null } } : null, { sure: 1 });
  }

  // The second press within some seconds does it.
  askClear() {
    const node = byId("clear");
    const ask = (on) => {
      clearTimeout(this.sure);
      this.sure = on ? setTimeout(() => ask(false), SURE_MS) : null;
      node.textContent = on ? `Really remove ${
        entities(this.store.state).length - 1}? Press again`
        : "Remove all but own ship";
    };
    if (this.sure) {
      this.clear();
    }
    ask(!this.sure);
  }

  // All but own ship.
  clear() {
    return this.do("clear", (state) => {
      const own = ownShip(state);
      const rest = entities(state).filter((e) => e !== own);
      return rest.length === 0 ? null : { entities: Object.fromEntries(
        rest.map((e) => [e.id ?? 0, null])) };
    }, { sure: 2 });
  }

  // From where they stand.
  goOn() {
    return this.do("go on", (state) => ({ clock: { reckoning: LONG_S },
      entities: Object.fromEntries(this.standing(state).map((e) => {
        const { latitude, longitude, heading, course } =
          reckoned(e, this.time(), state.clock?.reckoning);
        return [e.id ?? 0, { latitude, longitude, heading, course }];
      })) }), { sure: 2 });
  }

  standing(state) {
    return state.clock?.mode === "HOST" ? [] : entities(state).filter((e) =>
      reckoned(e, this.time(), state.clock?.reckoning).stood);
  }

  choose(id) {
    if (id !== null) {
      this.plan.selected = id;
      this.plan.soon();
      this.list();
      byId("ship-edit").open = true;
      this.chosen(id);
    }
  }

  next(by) {
    const ids = entities(this.store.state).map((e) => e.id ?? 0);
    const at = ids.indexOf(this.plan.selected);
    this.choose(ids.at((at + by) % ids.length) ?? null);
  }

  // --- showing -----------------------------------------------------------------------

  show() {
    this.plan.record();
    this.list();
  }

  list() {
    const { state } = this.store;
    const body = byId("traffic");
    const standing = this.standing(state).length;
    byId("standing").hidden = standing === 0;
    byId("standing-text").textContent = `${standing === 1 ? "One that moved " +
      "stands" : `${standing} that moved stand`}: no new pose for ` +
      `${state.clock?.reckoning ?? 60} s.`;
    byId("clear").disabled = entities(state).length < 2;
    if (body.offsetParent === null) {
      return;
    }
    const view = (state.views ?? []).find((v) => v.name === this.views.name);
    const eye = view && cameraOf(view, state, this.time());
    const there = new Set();
    for (const entity of entities(state)) {
      const id = entity.id ?? 0;
      there.add(id);
      const row = this.rows.get(id) ?? this.makeRow(id);
      const way = eye && offset(eye, this.plan.at(entity));
      const values = [entity.name || `entity ${id}`,
        this.catalogue.what(entity), way ? metres(Math.hypot(...way)) : "–",
        way ? three(bearing(way)) : "–", knots(entity.speed ?? 0)];
      values.forEach((text, i) => {
        if (row.texts[i].textContent !== text) {
          row.texts[i].textContent = text;
        }
      });
      row.name.setAttribute("aria-pressed", String(id === this.plan.selected));
    }
    for (const [id, row] of this.rows) {
      if (!there.has(id)) {
        row.node.remove();
        this.rows.delete(id);
      }
    }
  }

  makeRow(id) {
    const node = element("tr");
    const head = element("th");
    head.scope = "row";
    const name = element("button", "thing");
    name.type = "button";
    const texts = [element("span"), element("small")];
    name.append(...texts);
    name.addEventListener("click", () => this.choose(id));
    head.append(name);
    const cells = [1, 2, 3].map(() => element("td"));
    node.append(head, ...cells);
    byId("traffic").append(node);
    const row = { node, name, texts: [...texts, ...cells] };
    this.rows.set(id, row);
    return row;
  }
}
