// The controls: each is a field of the state by its path. What they offer
// comes from the schema (/v1/fields), what the server refuses is said next to
// the control that asked for it.

import { Gone, Problem } from "/api.js";
import { everything, mayPatch, needs } from "/rights.js";

const TYPING_MS = 150;
const DRAGGING_MS = 150;

let numbers = 0;

function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className || "";
  node.textContent = text || "";
  return node;
}

function round(value, step) {
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  return Number(value.toFixed(Math.min(digits, 6)));
}

// What all controls share: a label, a place for errors, writing, and holding
// still while a person has hold of it.
export class Control {
  // get(state): the value; patch(value): the merge patch that sets it, or a
  // function that makes it of a state; target(): which of several things
  // (views, ships, trains) it is about now, and what to call that; sure: as
  // Store.ask says; local: choosing changes nothing but the page.
  constructor(parent, { store, id, label, patch, get, target, targetName,
    sure, local = false }) {
    this.store = store;
    this.local = local || !patch;
    this.able = true;
    this.barred = false;
    this.id = id || `control-${numbers++}`;
    this.patch = patch;
    this.get = get;
    this.target = target ?? (() => "");
    this.targetName = targetName;
    this.sure = sure;
    this.writes = 0;
    this.held = false; // while a person has hold of it
    this.meant = undefined; // the target when the person took it
    this.node = element("div", "control");
    this.label = element("label", "label", label);
    this.label.htmlFor = this.id;
    this.error = element("p", "error");
    this.error.id = `${this.id}-error`;
    this.error.setAttribute("role", "alert");
    this.error.hidden = true;
    this.node.append(this.label);
    parent.append(this.node);
  }

  // The input that carries the name, and the error below everything.
  adopt(input, ...others) {
    input.id = this.id;
    input.setAttribute("aria-describedby", this.error.id);
    this.inputs = [input, ...others].filter((n) => n.matches("input,select"));
    this.node.append(input, ...others, this.error);
    this.node.classList.toggle("wide", input.matches(".select, .text"));
    this.node.addEventListener("focusin", () => {
      this.meant = this.target();
    });
    this.node.addEventListener("focusout", () => {
      this.meant = undefined;
      this.left();
    });
  }

  // What does not apply is not shown.
  set enabled(enabled) {
    this.node.hidden = !enabled;
    this.able = enabled;
    this.settle();
  }

  // Whether the page's token may set it, by what setting it now would send.
  mine(state) {
    const made = this.patch(this.sample(state));
    const patch = typeof made === "function" ? made(state) : made;
    return Boolean(patch) && mayPatch(patch, state);
  }

  sample(state) {
    return this.get(state);
  }

  settle() {
    this.node.classList.toggle("rests", this.barred);
    for (const input of this.inputs) {
      input.disabled = !this.able || this.barred;
    }
    for (const node of this.node.querySelectorAll("button:not([data-needs])")) {
      node.classList.toggle("barred", this.barred);
    }
  }

  // From pointerdown on, wherever the pointer is let go.
  hold() {
    this.held = true;
    this.meant = this.target();
    const end = () => {
      this.held = false;
      removeEventListener("pointerup", end, true);
      removeEventListener("pointercancel", end, true);
      this.show(this.store.state);
    };
    addEventListener("pointerup", end, true);
    addEventListener("pointercancel", end, true);
  }

  fail(text, passing = false) {
    this.passing = passing; // until the server answers again
    this.error.textContent = text;
    this.error.hidden = !text;
    for (const input of this.inputs) {
      input.setAttribute("aria-invalid", text ? "true" : "false");
    }
  }

  // Sets what was meant when the person took hold of it, or nothing.
  async write(value, { key = "", ...pace } = {}) {
    const target = this.target();
    if (this.meant !== undefined && this.meant !== target) {
      this.fail(`Not sent: ${this.targetName} is gone.`, true);
      return;
    }
    const made = this.patch(value);
    const mine = ++this.writes;
    const current = () => mine === this.writes && target === this.target();
    try {
      await this.store.ask(`${this.id} ${target} ${key}`,
        typeof made === "function" ? made : () => made,
        { sure: this.sure, ...pace });
      if (current()) {
        this.fail("");
      }
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      if (current()) {
        this.fail(error.line ?? "Not sent: the server does not answer.",
          error instanceof Gone);
      }
    }
  }

  // The person goes elsewhere: what was refused gives way to what is.
  left() {
    this.fail("");
    this.show(this.store.state);
  }

  // Another view, ship or train is shown: what was said is not about it.
  renew() {
    this.writes += 1;
    this.fail("");
  }

  show(state) {
    const value = this.get(state);
    const barred = !this.local && !everything() && !this.mine(state);
    if (barred !== this.barred) {
      this.barred = barred;
      this.settle();
    }
    if (!this.held && this.error.hidden) {
      this.set(value);
    }
  }

  // The server answers.
  heard() {
    if (this.passing) {
      this.fail("");
    }
  }
}

// For ranges over decades, evenly spread: their logarithm, or where zero is
// among them, what is linear around it.
const CURVES = {
  log: [Math.log, Math.exp],
  asinh: [(x) => Math.asinh(x / 5), (x) => 5 * Math.sinh(x)],
};

// A number: slider and entry. `scale`: of the slider.
export class Range extends Control {
  constructor(parent, options) {
    super(parent, options);
    this.options = options;
    this.step = options.step;
    this.curved = Boolean(options.scale);
    this.minimum = options.minimum;
    this.maximum = options.maximum;
    const name = options.label;
    this.entry = element("input", "entry");
    this.entry.type = "number";
    this.entry.step = "any";
    this.entry.inputMode = "decimal";
    this.entry.setAttribute("aria-label", `${name}, ${options.unitName}`);
    this.unit = element("span", "unit", options.unit);
    Object.assign(this.node.dataset, { path: options.path,
      minimum: options.minimum, maximum: options.maximum });
    this.slider = element("input", "slider");
    this.slider.type = "range";
    this.setLimits(options.minimum, options.maximum);
    const row = element("div", "entry-row");
    row.append(this.entry, this.unit);
    this.adopt(this.slider, row);
    this.inputs = [this.slider, this.entry];
    this.node.classList.add("range");
    this.slider.addEventListener("pointerdown", () => this.hold());
    this.slider.addEventListener("input", () => {
      const value = this.fromSlider();
      this.entry.value = value;
      this.speak(value);
      this.known = value;
      this.write(value, { everyMs: DRAGGING_MS });
    });
    this.entry.addEventListener("input", () => {
      const value = Number.parseFloat(this.entry.value);
      if (Number.isFinite(value)) {
        this.toSlider(value);
        this.known = value;
        this.write(value, { afterMs: TYPING_MS });
      }
    });
  }

  left() {
    this.known = NaN; // another number may stand in the entry
    super.left();
  }

  setLimits(minimum, maximum) {
    this.minimum = minimum;
    this.maximum = maximum;
    const curve = CURVES[this.options.scale];
    if (curve) {
      const [low, high] = [curve[0](minimum), curve[0](maximum)];
      this.bend = (value) => 1000 * (curve[0](value) - low) / (high - low);
      this.unbend = (x) => curve[1](low + (high - low) * x / 1000);
    }
    this.slider.min = curve ? 0 : minimum;
    this.slider.max = curve ? 1000 : maximum;
    this.slider.step = curve ? 1 : this.step;
  }

  // A bent slider counts in thousandths of its length: three digits, so that
  // each of its steps is another value, and its ends are the range's.
  fromSlider() {
    const x = Number(this.slider.value);
    if (!this.curved) {
      return round(x, this.step);
    }
    return x <= 0 ? this.minimum : x >= 1000 ? this.maximum
      : Number(this.unbend(x).toPrecision(3));
  }

  toSlider(value) {
    this.slider.value = this.curved ? this.bend(value) : value;
    const low = Number(this.slider.min);
    const high = Number(this.slider.max);
    const part = (Number(this.slider.value) - low) / (high - low);
    this.slider.style.setProperty("--part", `${100 * part}%`);
  }

  speak(value) {
    this.slider.setAttribute("aria-valuetext",
      `${value} ${this.options.unitName}`);
    this.toSlider(value);
  }

  set(value) {
    if (value === this.known) {
      return;
    }
    this.known = value;
    if (value === undefined) {
      this.entry.value = "";
      this.toSlider(this.minimum);
      return;
    }
    const shown = this.curved ? Number(value.toPrecision(6))
      : round(value, this.step);
    if (document.activeElement !== this.entry) {
      this.entry.value = shown;
    }
    this.speak(shown);
  }
}

export class Choice extends Control {
  constructor(parent, options) {
    super(parent, options);
    this.select = element("select", "select");
    this.setOptions(options.options || []);
    this.adopt(this.select);
    // Its list stays as it is while it is open.
    this.select.addEventListener("pointerdown", () => {
      this.held = true;
    });
    for (const type of ["change", "blur", "keyup"]) {
      this.select.addEventListener(type, () => {
        this.held = false;
      });
    }
    this.select.addEventListener("change", () => {
      if (options.chosen) {
        options.chosen(this.select.value);
      } else {
        this.write(this.select.value);
      }
    });
  }

  // options: [[value, text], …]
  setOptions(options) {
    const key = JSON.stringify(options);
    if (key !== this.key && !this.held) {
      this.key = key;
      const value = this.select.value;
      this.select.replaceChildren(...options.map(([v, text]) => {
        const option = element("option", "", text);
        option.value = v;
        return option;
      }));
      this.select.value = value;
    }
  }

  set(value) {
    if (value !== undefined && this.select.value !== value) {
      this.select.value = value;
    }
  }
}

export class Check extends Control {
  constructor(parent, options) {
    super(parent, options);
    this.box = element("input", "box");
    this.box.type = "checkbox";
    this.adopt(this.box);
    this.node.classList.add("check");
    this.box.addEventListener("change", () => this.write(this.box.checked));
  }

  sample(state) {
    return !this.get(state);
  }

  set(value) {
    this.box.checked = value;
  }
}

export class Text extends Control {
  constructor(parent, options) {
    super(parent, options);
    this.input = element("input", "text");
    this.input.type = options.type || "text";
    if (options.type === "datetime-local") {
      this.input.step = 1;
    }
    this.adopt(this.input);
    this.input.addEventListener("change", () => {
      if (this.input.value) {
        this.write(this.input.value);
      }
    });
  }

  set(value) {
    if (document.activeElement !== this.input) {
      this.input.value = value ?? "";
    }
  }
}

// needed: as in rights.js.
export function button(parent, text, label, action, needed = "") {
  const node = element("button", "button", text);
  if (needed) {
    needs(node, needed);
  }
  node.type = "button";
  node.setAttribute("aria-label", label);
  node.title = label;
  node.addEventListener("click", action);
  parent.append(node);
  return node;
}
