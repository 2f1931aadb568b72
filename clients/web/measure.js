// Range and bearing between two points of the plan: places, or things that go
// on moving.

import { bearing, metres, offset, three } from "/geo.js";

const INK = "#ffd98a";
const REACH_PX = 12;
const MILE_M = 1852;

export class Measure {
  // said(text): what it is now, or how it is done.
  constructor(plan, node, said) {
    this.plan = plan;
    this.node = node; // the button
    this.said = said;
    this.armed = false;
    this.ends = null; // two of { id } or a place
    const { canvas } = plan;
    node.addEventListener("click", () => this.arm(!this.armed));
    canvas.addEventListener("pointerdown", (e) => this.down(e), true);
    canvas.addEventListener("pointermove", (e) => this.move(e), true);
    for (const type of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(type, (e) => this.up(e), true);
    }
    canvas.addEventListener("keydown", (e) => this.key(e), true);
    plan.over.push((g) => this.draw(g));
  }

  arm(on) {
    this.armed = on;
    this.node.setAttribute("aria-pressed", String(on));
    this.plan.canvas.classList.toggle("adding", on);
    if (on) {
      this.ends = null;
    }
    this.said(on ? "Pull from one point to the other. With keys: M at the " +
      "cross in the middle, arrows, M again; Esc ends." : "");
    this.plan.soon();
  }

  at(event) {
    const box = this.plan.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  // What is under a pixel: a thing, else the place.
  grip(pixel) {
    const thing = this.plan.hit(pixel, REACH_PX);
    return thing ? { id: thing.id ?? 0 } : this.plan.place(pixel);
  }

  placeOf(end) {
    const thing = end.id === undefined ? null
      : this.plan.state.entities?.find((e) => (e.id ?? 0) === end.id);
    return thing ? this.plan.at(thing) : end.latitude === undefined ? null : end;
  }

  down(event) {
    if (this.armed && event.button === 0 && !this.pulling) {
      const end = this.grip(this.at(event));
      this.ends = [end, end];
      this.pulling = event.pointerId;
      this.began = this.at(event);
      this.plan.canvas.setPointerCapture(event.pointerId);
      event.stopImmediatePropagation();
    }
  }

  move(event) {
    if (this.pulling === event.pointerId) {
      this.ends[1] = this.plan.place(this.at(event));
      event.stopImmediatePropagation();
      this.plan.soon();
    }
  }

  up(event) {
    if (this.pulling === event.pointerId) {
      this.pulling = undefined;
      this.ends[1] = this.grip(this.at(event));
      event.stopImmediatePropagation();
      this.tell();
    }
  }

  key(event) {
    const key = event.key.toLowerCase();
    if (event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    if (key === "m") {
      const middle = this.grip([this.plan.width / 2, this.plan.height / 2]);
      if (this.keyed) {
        this.ends[1] = middle;
        this.keyed = false;
        this.tell();
      } else {
        this.arm(true);
        this.ends = [middle, middle];
        this.keyed = true;
      }
    } else if (key === "escape" && (this.armed || this.ends)) {
      this.keyed = false;
      this.ends = null;
      this.arm(false);
    } else {
      return;
    }
    event.preventDefault();
    event.stopImmediatePropagation();
    this.plan.soon();
  }

  // { metres, bearing }, or null.
  get result() {
    const [a, b] = (this.ends ?? []).map((end) => this.placeOf(end));
    if (!a || !b) {
      return null;
    }
    const way = offset(a, b);
    return { metres: Math.hypot(...way), bearing: bearing(way) };
  }

  get text() {
    const { result } = this;
    return result ? `${metres(result.metres)} · ${
      (result.metres / MILE_M).toFixed(2)} nmi · ${three(result.bearing)}` : "";
  }

  tell() {
    const { text } = this;
    this.arm(false);
    this.said(text ? `Measured: ${text}` : "");
    this.plan.canvas.dataset.measured = text;
  }

  draw(g) {
    if (!this.ends) {
      return;
    }
    if (this.keyed) {
      this.ends[1] = this.plan.place([this.plan.width / 2,
        this.plan.height / 2]);
    }
    const [a, b] = this.ends.map((end) => this.placeOf(end));
    if (!a || !b) {
      this.ends = null; // the thing is gone
      return;
    }
    const [from, to] = [this.plan.pixel(a), this.plan.pixel(b)];
    g.strokeStyle = INK;
    g.lineWidth = 1.5;
    g.setLineDash([6, 4]);
    g.beginPath();
    g.moveTo(...from);
    g.lineTo(...to);
    g.stroke();
    g.setLineDash([]);
    for (const [x, y] of [from, to]) {
      g.beginPath();
      g.arc(x, y, 4, 0, 2 * Math.PI);
      g.stroke();
    }
    this.plan.label(this.text, (from[0] + to[0]) / 2 + 8,
      (from[1] + to[1]) / 2 - 6, INK);
  }
}
