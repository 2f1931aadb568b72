// Depth and coast on the plan, from the seabed's file: asked for when the plan
// has come to rest, as a grid of points a little larger than what is seen.

import { Gone, inTurn, perform, Problem } from "/api.js";
import { offset } from "/geo.js";

const REST_MS = 400;
const ACROSS = 44;
const DOWN = 30;
const MARGIN = 0.2; // of the plan, on each side
const SOUNDING_PX = 110; // between two numbers
const LAND = [84, 77, 52];
const COAST = "#e2cf9a";
// The shallower the lighter, as charts have it: to so many metres.
const DEPTHS = [[2, [47, 116, 146]], [5, [37, 97, 125]], [10, [28, 79, 105]],
  [20, [20, 63, 86]], [50, [14, 48, 68]], [Infinity, [9, 36, 52]]];

const colour = (depth) => depth < 0 ? LAND
  : DEPTHS.find(([most]) => depth <= most)[1];

export class Ground {
  constructor(plan) {
    this.plan = plan;
    this.canvas = document.createElement("canvas");
    [this.canvas.width, this.canvas.height] = [ACROSS, DOWN];
    plan.under.push((g) => this.draw(g));
  }

  // What the grid was asked of.
  get key() {
    const { plan } = this;
    const { file, offset: above } = plan.state.seabed ?? {};
    const { latitude, longitude } = plan.centre;
    return file && JSON.stringify([file, above, plan.width, plan.height,
      plan.scale, plan.turn.toFixed(0),
      // Within the margin nothing new is needed.
      ...[latitude, longitude * Math.cos(latitude * Math.PI / 180)].map((x) =>
        Math.round(x * 111e3 / plan.scale / (plan.height * MARGIN / 2)))]);
  }

  // Corners of the grid as pixels of the plan.
  get frame() {
    const { width, height } = this.plan;
    return { x: -MARGIN * width, y: -MARGIN * height,
      w: (1 + 2 * MARGIN) * width, h: (1 + 2 * MARGIN) * height };
  }

  // When the plan has rested; it draws itself again and again meanwhile.
  soon(key) {
    if (key !== this.waited || !this.timer) {
      clearTimeout(this.timer);
      this.waited = key;
      this.timer = setTimeout(() => {
        this.timer = null;
        this.ask();
      }, REST_MS);
    }
  }

  async ask() {
    const { plan, frame, key } = this;
    if (this.asking || !key) {
      return;
    }
    this.asking = true;
    const { origin } = plan.state;
    const from = { latitude: origin?.latitude ?? 52.6,
      longitude: origin?.longitude ?? 5.2 };
    const points = [];
    for (let i = 0; i < ACROSS * DOWN; i++) {
      const [east, north] = offset(from, plan.place([
        frame.x + frame.w * (i % ACROSS + 0.5) / ACROSS,
        frame.y + frame.h * (Math.floor(i / ACROSS) + 0.5) / DOWN]));
      points.push({ east: Math.round(east), north: Math.round(north) });
    }
    const corners = [[0, 0], [1, 0], [0, 1]].map(([x, y]) =>
      plan.place([frame.x + frame.w * x, frame.y + frame.h * y]));
    try {
      const answer = await inTurn(() => perform("POST", "/v1/surface",
        { points }, { "Content-Type": "application/json" }));
      this.take(answer.points.map((p) => p.depth), corners, key);
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.asked = key; // not again until something else is seen
    } finally {
      this.asking = false;
    }
  }

  take(depths, corners, key) {
    const g = this.canvas.getContext("2d");
    const image = g.createImageData(ACROSS, DOWN);
    depths.forEach((depth, i) => {
      if (depth !== undefined) {
        image.data.set([...colour(depth), 255], 4 * i);
      }
    });
    g.putImageData(image, 0, 0);
    Object.assign(this, { depths, corners, asked: key });
    this.plan.canvas.dataset.depths = depths.filter((d) =>
      d !== undefined).length;
    this.plan.soon();
  }

  // From the grid to the plan's pixels, as that is now.
  matrix() {
    const [a, b, c] = this.corners.map((place) => this.plan.pixel(place));
    return [(b[0] - a[0]) / ACROSS, (b[1] - a[1]) / ACROSS,
      (c[0] - a[0]) / DOWN, (c[1] - a[1]) / DOWN, a[0], a[1]];
  }

  draw(g) {
    const { key } = this;
    if (!key) {
      this.depths = null;
      delete this.plan.canvas.dataset.depths;
      return;
    }
    if (key !== this.asked) {
      this.soon(key);
    }
    if (!this.depths) {
      return;
    }
    const m = this.matrix();
    g.save();
    g.transform(...m);
    g.imageSmoothingEnabled = true;
    g.drawImage(this.canvas, 0, 0);
    g.restore();
    this.drawCoast(g, m);
    this.drawSoundings(g, m);
  }

  at(m, x, y) {
    return [m[0] * x + m[2] * y + m[4], m[1] * x + m[3] * y + m[5]];
  }

  // Where the depth is 0, square by square of the grid's points.
  drawCoast(g, m) {
    const d = this.depths;
    g.strokeStyle = COAST;
    g.lineWidth = 1.5;
    g.beginPath();
    for (let y = 0; y + 1 < DOWN; y++) {
      for (let x = 0; x + 1 < ACROSS; x++) {
        const i = y * ACROSS + x;
        const ring = [[x, y, d[i]], [x + 1, y, d[i + 1]],
          [x + 1, y + 1, d[i + ACROSS + 1]], [x, y + 1, d[i + ACROSS]]];
        if (ring.some(([, , depth]) => depth === undefined)) {
          continue;
        }
        const cuts = [];
        ring.forEach(([ax, ay, a], k) => {
          const [bx, by, b] = ring[(k + 1) % 4];
          if (a < 0 !== b < 0) {
            const part = a / (a - b);
            cuts.push(this.at(m, ax + (bx - ax) * part + 0.5,
              ay + (by - ay) * part + 0.5));
          }
        });
        for (let k = 0; k + 1 < cuts.length; k += 2) {
          g.moveTo(...cuts[k]);
          g.lineTo(...cuts[k + 1]);
        }
      }
    }
    g.stroke();
  }

  drawSoundings(g, m) {
    const step = Math.max(1, Math.round(SOUNDING_PX / Math.hypot(m[0], m[1])));
    g.font = "10px system-ui, sans-serif";
    g.fillStyle = "#a9c6d3";
    g.textAlign = "center";
    for (let y = step >> 1; y < DOWN; y += step) {
      for (let x = step >> 1; x < ACROSS; x += step) {
        const depth = this.depths[y * ACROSS + x];
        if (depth !== undefined && depth >= 0) {
          const [px, py] = this.at(m, x + 0.5, y + 0.5);
          g.fillText(depth.toFixed(depth < 10 ? 1 : 0), px, py + 3);
        }
      }
    }
  }
}
