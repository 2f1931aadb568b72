// The trains of swell. The state has them as a plain list, which goes whole;
// here each keeps a mark of its own, so that what a person sets goes to the
// train that was meant, whatever became of the list meanwhile.

import { button } from "/panel.js";

const MARK = Symbol("train"); // copied along by {...train}, not sent
const FRESH = { height: 1, period: 10, direction: 270, spread: 10 };

let marks = 0;
let presses = 0;

export const trains = (state) => state.sea?.swell ?? [];
const listed = (list) => ({ sea: { swell: list } });
const alike = (a, b) => JSON.stringify(a) === JSON.stringify(b);

// Marks the trains of a new state by those before: alike ones are the same,
// and so, in a list of the same length, are those in the same place.
export function followTrains(before, after) {
  const left = new Set(trains(before));
  const list = trains(after);
  const take = (train, old) => {
    if (old && left.delete(old)) {
      train[MARK] = old[MARK];
    }
  };
  for (const train of list) {
    take(train, [...left].find((old) => alike(old, train)));
  }
  const same = trains(before).length === list.length;
  list.forEach((train, i) => {
    if (!train[MARK]) {
      take(train, same && trains(before)[i]);
      train[MARK] = train[MARK] ?? ++marks;
    }
  });
}

export class Swell {
  // panel: Sections, whose controls these are.
  constructor(panel) {
    this.panel = panel;
    this.mark = 0; // of the train that is chosen
    this.place = 0; // where it was
  }

  // The train that is chosen; another beside it when it is gone.
  chosen(state) {
    const list = trains(state);
    const at = list.findIndex((train) => train[MARK] === this.mark);
    this.place = at >= 0 ? at
      : Math.max(0, Math.min(this.place, list.length - 1));
    this.mark = list[this.place]?.[MARK] ?? 0;
    return list[this.place];
  }

  setOn(on) {
    const mark = ++marks;
    return (state) => on === trains(state).length > 0 ? null
      : listed(on ? [{ ...FRESH, [MARK]: mark }] : []);
  }

  add() {
    this.mark = ++marks;
    const { mark } = this;
    return (state) => trains(state).some((train) => train[MARK] === mark) ? null
      : listed([...trains(state), { ...FRESH, [MARK]: mark }]);
  }

  remove() {
    const { mark } = this;
    return (state) => this.without(state, mark);
  }

  without(state, mark) {
    const rest = trains(state).filter((train) => train[MARK] !== mark);
    return rest.length < trains(state).length ? listed(rest) : null;
  }

  set(change) {
    const { mark } = this;
    return (state) => trains(state).some((train) => train[MARK] === mark)
      ? listed(trains(state).map((train) =>
        train[MARK] === mark ? { ...train, ...change } : train))
      : null;
  }

  build() {
    const { panel } = this;
    const on = (state) => trains(state).length > 0;
    panel.check("swell", "swell-on", "A swell runs", {
      sure: 2, get: on, patch: (v) => this.setOn(v) });
    const choice = panel.pick("swell", "swell-train", "Train", {
      sure: 2, depends: on, local: true,
      get: (state) => String(this.chosen(state)?.[MARK]),
      options: (state) => trains(state).map((train, i) =>
        [String(train[MARK]), `${i + 1}: ${train.height ?? 1} m from ` +
          `${Math.round(train.direction ?? 270)}°`]),
      patch: (make) => make,
      chosen: (v) => {
        this.mark = Number(v);
        panel.show(true);
      } });
    choice.node.classList.add("with-button", "with-pair");
    const pair = document.createElement("span");
    pair.className = "pair";
    pair.dataset.needs = "sea.swell";
    choice.select.after(pair);
    // Each press counts: a key of its own.
    const press = (make) => choice.write(make, { key: ++presses });
    button(pair, "+", "Add a train of swell", () => press(this.add()));
    button(pair, "−", "Remove this train of swell", () => press(this.remove()));
    const range = (label, name, unit, step) =>
      panel.range("swell", label, `sea.swell.*.${name}`, unit, step, {
        id: `swell-${name}`, sure: 2, depends: on,
        get: (state) => this.chosen(state)?.[name],
        target: () => this.mark, targetName: "that train of swell",
        patch: (v) => this.set({ [name]: v }) });
    range("Height", "height", "m", 0.1);
    range("Period", "period", "s", 0.5);
    range("From", "direction", "°", 1);
    range("Spread", "spread", "°", 1);
  }
}
