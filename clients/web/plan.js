// The plan: own ship, targets, buoys, tracks and what the views see, from
// above. It draws what the state says at the time of the picture that is
// shown; planhands.js is what people do to it.

import { bearing, cameraOf, metres, offset, reckoned, shifted, three, wrap }
  from "/geo.js";
import { isLight } from "/catalogue.js";
import { drawFan, drawHull, drawLight, drawMark, drawRose } from "/plansigns.js";
import { ownShip } from "/scenes.js";

const RAD = Math.PI / 180;
const REDRAW_MS = 200; // things move by themselves
const KEPT = 150; // points of a track
const APART_M = 8; // between two of them
const LABELS = 60;
const NEAREST = 0.05; // metres a pixel
const FARTHEST = 200;
const INK = "#cfe3ec";
const OWN = "#ffcf7a";
const CHOSEN = "#3bd6b4";

const clamp = (x, low, high) => Math.max(low, Math.min(high, x));

// 1, 2 or 5 times a power of ten, the largest that is no more than x.
export function nice(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return [5, 2, 1].find((n) => n * power <= x) * power;
}

export class Plan {
  constructor(canvas, { store, views, catalogue, time }) {
    Object.assign(this, { canvas, store, views, catalogue, time });
    this.context = canvas.getContext("2d");
    this.scale = 3; // metres a pixel
    this.free = null; // its middle, where that is not own ship
    this.headUp = false;
    this.selected = null;
    this.drafts = new Map(); // id: where a hand has it
    this.adding = null; // { from, to } in pixels while a new thing is placed
    this.tracks = new Map();
    this.under = []; // what else is drawn, below the things and over them
    this.over = [];
    new ResizeObserver(() => (this.fitted ? this.fit() : this.soon()))
      .observe(canvas);
    setInterval(() => this.soon(), REDRAW_MS);
  }

  // --- where things are -----------------------------------------------------------

  get state() {
    return this.store.state;
  }

  at(entity) {
    const now = reckoned(entity, this.time(), this.state.clock?.reckoning);
    return { ...now, ...this.drafts.get(entity.id ?? 0) };
  }

  get own() {
    return ownShip(this.state);
  }

  get centre() {
    const { own } = this;
    return this.free ?? (own ? this.at(own) : {
      latitude: this.state.origin?.latitude ?? 52.6,
      longitude: this.state.origin?.longitude ?? 5.2 });
  }

  get turn() {
    return this.headUp && this.own ? this.at(this.own).heading : 0;
  }

  // From the upper left corner, in CSS pixels.
  pixel(place) {
    const [east, north] = offset(this.centre, place);
    const [s, c] = [Math.sin(this.turn * RAD), Math.cos(this.turn * RAD)];
    return [this.width / 2 + (east * c - north * s) / this.scale,
      this.height / 2 - (east * s + north * c) / this.scale];
  }

  metresOf([dx, dy]) {
    const [s, c] = [Math.sin(this.turn * RAD), Math.cos(this.turn * RAD)];
    return [(dx * c - dy * s) * this.scale, (-dx * s - dy * c) * this.scale];
  }

  place([x, y]) {
    return shifted(this.centre,
      this.metresOf([x - this.width / 2, y - this.height / 2]));
  }

  // The entity under a pixel, or undefined.
  hit([x, y], within) {
    let best;
    let least = within;
    for (const entity of this.state.entities ?? []) {
      const [px, py] = this.pixel(this.at(entity));
      const half = this.catalogue.sizes(entity).length / this.scale / 2;
      const away = Math.hypot(px - x, py - y) - Math.min(half, 40) / 2;
      // What is chosen lies on top.
      const rank = away - ((entity.id ?? 0) === this.selected ? 6 : 0);
      if (rank < least) {
        least = rank;
        best = entity;
      }
    }
    return best;
  }

  // --- what it shows ---------------------------------------------------------------

  pan(pixels) {
    this.fitted = false;
    const centre = shifted(this.centre, this.metresOf(pixels));
    this.free = { latitude: clamp(centre.latitude, -90, 90),
      longitude: centre.longitude };
    this.soon();
  }

  zoom(factor, about = [this.width / 2, this.height / 2]) {
    const under = this.place(about);
    this.fitted = false;
    this.scale = clamp(this.scale * factor, NEAREST, FARTHEST);
    if (this.free) {
      const [x, y] = this.pixel(under);
      this.pan([x - about[0], y - about[1]]);
    }
    this.soon();
  }

  home() {
    this.free = null;
    this.fitted = false;
    this.soon();
  }

  // All things in it.
  fit() {
    const list = this.state.entities ?? [];
    this.fitted = true; // and again when its size changes
    [this.width, this.height] =
      [this.canvas.clientWidth, this.canvas.clientHeight];
    if (list.length === 0 || !this.width) {
      return;
    }
    const [first] = list;
    const places = list.map((e) => offset(this.at(first), this.at(e)));
    const [low, high] = [Math.min, Math.max].map((f) =>
      [0, 1].map((i) => f(...places.map((p) => p[i]))));
    this.free = shifted(this.at(first), [0, 1].map((i) =>
      (low[i] + high[i]) / 2));
    this.headUp = false;
    this.scale = clamp(Math.max((high[0] - low[0]) / (this.width - 120),
      (high[1] - low[1]) / (this.height - 80)), 0.2, FARTHEST);
    this.soon();
  }

  // Minutes of the arrows that tell speeds.
  get minutes() {
    return [1, 3, 6, 12, 30, 60].find((m) => m * 60 * 5 / this.scale > 25) ?? 60;
  }

  // Called with each new state.
  record() {
    const now = this.time();
    const there = new Set();
    for (const entity of this.state.entities ?? []) {
      const id = entity.id ?? 0;
      there.add(id);
      const at = this.at(entity);
      const track = this.tracks.get(id) ?? [];
      const last = track.at(-1);
      if (last && now < last.time) {
        track.length = 0; // time was set back
      }
      if (!last || Math.hypot(...offset(last, at)) > APART_M) {
        track.push({ latitude: at.latitude, longitude: at.longitude,
          time: now });
        track.splice(0, track.length - KEPT);
      }
      this.tracks.set(id, track);
    }
    for (const id of this.tracks.keys()) {
      if (!there.has(id)) {
        this.tracks.delete(id);
      }
    }
    this.soon();
  }

  soon() {
    this.asked = this.asked ?? requestAnimationFrame(() => {
      this.asked = null;
      this.draw();
    });
  }

  // --- drawing ----------------------------------------------------------------------

  draw() {
    const { canvas, context: g } = this;
    [this.width, this.height] = [canvas.clientWidth, canvas.clientHeight];
    if (this.width < 40 || document.hidden) {
      return;
    }
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const size = [this.width, this.height].map((x) => Math.round(x * ratio));
    if (canvas.width !== size[0] || canvas.height !== size[1]) {
      [canvas.width, canvas.height] = size;
    }
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.fillStyle = "#08202e";
    g.fillRect(0, 0, this.width, this.height);
    this.under.forEach((part) => part(g));
    this.drawRings();
    this.drawTracks();
    for (const view of this.state.views ?? []) {
      this.drawView(view);
    }
    this.drawThings();
    this.drawAdding();
    this.over.forEach((part) => part(g));
    this.drawScale();
    drawRose(g, this.width - 36, 36, this.turn, this.state);
    canvas.dataset.scale = this.scale.toPrecision(4);
  }

  drawRings() {
    const g = this.context;
    const step = nice(Math.min(this.width, this.height) * this.scale / 3);
    const [x, y] = this.pixel(this.own ? this.at(this.own) : this.centre);
    g.strokeStyle = "#1d4357";
    g.fillStyle = "#6f97aa";
    g.font = "10px system-ui, sans-serif";
    g.textAlign = "center";
    g.lineWidth = 1;
    for (let i = 1; i <= 4; i++) {
      const r = i * step / this.scale;
      g.beginPath();
      g.arc(x, y, r, 0, 2 * Math.PI);
      g.stroke();
      g.fillText(metres(i * step), x, y + r - 3);
    }
  }

  drawTracks() {
    const g = this.context;
    g.lineWidth = 1;
    g.setLineDash([2, 3]);
    for (const [id, track] of this.tracks) {
      const own = id === this.own?.id;
      if (track.length > 1 && (own || id === this.selected ||
          this.tracks.size <= 40)) {
        g.strokeStyle = own ? OWN : "#7fa9bb";
        g.beginPath();
        track.forEach((p, i) => g[i ? "lineTo" : "moveTo"](...this.pixel(p)));
        g.stroke();
      }
    }
    g.setLineDash([]);
  }

  drawView(view) {
    const camera = cameraOf(view, this.state, this.time());
    if (!camera) {
      return;
    }
    const carried = this.drafts.get(view.entity);
    const at = this.pixel(carried ?? camera);
    const f = view.frustum;
    const half = (view.fieldOfView ?? 60) / 2;
    const chosen = view.name === this.views.name;
    drawFan(this.context, at, wrap(camera.bearing - this.turn),
      f ? [f.left, f.right] : [-half, half],
      Math.min(this.width, this.height) * (chosen ? 0.42 : 0.25), chosen);
  }

  drawThings() {
    const g = this.context;
    const names = [];
    for (const entity of this.state.entities ?? []) {
      const at = this.at(entity);
      const [x, y] = this.pixel(at);
      if (x < -300 || y < -300 || x > this.width + 300 ||
          y > this.height + 300) {
        continue;
      }
      const id = entity.id ?? 0;
      const chosen = id === this.selected;
      const ink = id === this.own?.id ? OWN : INK;
      const model = this.catalogue.of(entity);
      const heading = wrap(at.heading - this.turn);
      this.drawSpeed(entity, at, [x, y], ink);
      const light = isLight(entity, model);
      if (light) {
        drawLight(g, [x, y], entity.light?.character);
      }
      if (!drawMark(g, [x, y], model) && !light) {
        const { length, beam } = this.catalogue.sizes(entity);
        drawHull(g, [x, y], heading, length / this.scale, beam / this.scale,
          ink, entity.model === undefined);
      }
      if (chosen) {
        g.strokeStyle = CHOSEN;
        g.lineWidth = 2;
        g.strokeRect(x - 13, y - 13, 26, 26);
      }
      const reach = this.reach(entity, model, heading);
      const name = [entity.name || `${id}`, x + reach, y + 4,
        chosen ? CHOSEN : at.stood ? "#ffb08a" : ink];
      names[chosen || id === this.own?.id ? "unshift" : "push"](name);
    }
    this.drawNames(names);
  }

  // How far its hull reaches to the right of its middle, in pixels.
  reach(entity, model, heading) {
    const { length } = this.catalogue.sizes(entity);
    return model && length / this.scale > 15
      ? Math.max(11, Math.abs(Math.sin(heading * RAD)) * length / this.scale / 2
        + 6) : 11;
  }

  // As many as have room, the first first.
  drawNames(names) {
    const g = this.context;
    g.font = "11px system-ui, sans-serif";
    const boxes = [];
    for (const [text, x, y, ink] of names) {
      if (boxes.length >= LABELS) {
        return;
      }
      const box = [x, y - 9, x + g.measureText(text).width + 3, y + 3];
      if (!boxes.some((b) => b[0] < box[2] && box[0] < b[2] &&
          b[1] < box[3] && box[1] < b[3])) {
        boxes.push(box);
        this.label(text, x, y, ink);
      }
    }
  }

  label(text, x, y, ink) {
    const g = this.context;
    g.font = "11px system-ui, sans-serif";
    g.textAlign = "left";
    g.lineWidth = 3;
    g.strokeStyle = "#08202ed0";
    g.strokeText(text, x, y);
    g.fillStyle = ink;
    g.fillText(text, x, y);
  }

  drawSpeed(entity, at, from, ink) {
    const speed = entity.speed ?? 0;
    if (speed > 0 && !at.stood) {
      const far = speed * 60 * this.minutes / this.scale;
      const a = (at.course - this.turn) * RAD;
      const g = this.context;
      g.strokeStyle = ink;
      g.lineWidth = 1.2;
      g.beginPath();
      g.moveTo(...from);
      g.lineTo(from[0] + far * Math.sin(a), from[1] - far * Math.cos(a));
      g.stroke();
    }
  }

  drawAdding() {
    const { adding, context: g } = this;
    if (!adding) {
      return;
    }
    const { from, to } = adding;
    g.strokeStyle = g.fillStyle = CHOSEN;
    g.lineWidth = 1.5;
    g.beginPath();
    g.arc(...from, 6, 0, 2 * Math.PI);
    g.moveTo(...from);
    g.lineTo(...to);
    g.stroke();
    const { course, speed } = this.motion(adding);
    if (speed > 0) {
      this.label(`${three(course)} ${speed.toFixed(1)} m/s`, to[0] + 8, to[1],
        CHOSEN);
    }
  }

  // What pulling from one pixel to another asks for: where it is to be after
  // the arrows' minutes.
  motion({ from, to }) {
    const way = this.metresOf([to[0] - from[0], to[1] - from[1]]);
    const far = Math.hypot(...way);
    return far / this.scale < 8 ? { course: 0, speed: 0 }
      : { course: Math.round(bearing(way)) % 360, speed: clamp(
        Math.round(far / (60 * this.minutes) * 10) / 10, 0, 30) };
  }

  drawScale() {
    const g = this.context;
    const length = nice(100 * this.scale);
    const across = length / this.scale;
    const y = this.height - 10;
    g.strokeStyle = INK;
    g.lineWidth = 1.5;
    g.beginPath();
    g.moveTo(10, y - 4);
    g.lineTo(10, y);
    g.lineTo(10 + across, y);
    g.lineTo(10 + across, y - 4);
    g.stroke();
    this.label(`${metres(length)} · arrows ${this.minutes} min`, 12, y - 7,
      INK);
    if (this.canvas.matches(":focus")) { // where Enter puts a new thing
      const [cx, cy] = [this.width / 2, this.height / 2];
      g.strokeStyle = "#ffffff90";
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(cx - 9, cy);
      g.lineTo(cx + 9, cy);
      g.moveTo(cx, cy - 9);
      g.lineTo(cx, cy + 9);
      g.stroke();
    }
  }
}
