// Depth and coast on the plan, from the field that is drawn: asked for when the
// plan has come to rest, as a raster a little larger than what is seen, whose
// cells are of the plan's own scale.

import { floats, Gone, inTurn, Problem } from "/api.js";

const REST_MS = 400;
const CELL_PX = 2;
const MOST = 512; // cells in a row, and rows: the server's limit
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
    plan.under.push((g) => this.draw(g));
  }

  // Identifies the request that the raster answers.
  get key() {
    const { plan } = this;
    const { file, offset: above } = plan.state.seabed ?? {};
    const { latitude, longitude } = plan.centre;
    return file && JSON.stringify([file, above, plan.state.sea?.level,
      plan.width, plan.height, plan.scale, plan.turn.toFixed(0),
      // Within the margin nothing new is needed.
      ...[latitude, longitude * Math.cos(latitude * Math.PI / 180)].map((x) =>
        Math.round(x * 111e3 / plan.scale / (plan.height * MARGIN / 2)))]);
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
    const { plan, key } = this;
    if (this.asking || !key) {
      return;
    }
    this.asking = true;
    const [w, h] = [plan.width, plan.height].map((x) => x * (1 + 2 * MARGIN));
    const cell = Math.max(CELL_PX, w / MOST, h / MOST);
    const [columns, rows] = [w, h].map((x) =>
      Math.min(MOST, Math.max(2, Math.round(x / cell))));
    const { latitude, longitude } = plan.centre;
    const query = new URLSearchParams({ latitude, longitude, columns, rows,
      spacing: plan.scale * cell, turn: plan.turn });
    const across = cell * columns / 2;
    const down = cell * rows / 2;
    // Its corners, which are carried along as the plan moves.
    const corners = [[-1, -1], [1, -1], [-1, 1]].map(([x, y]) => plan.place(
      [plan.width / 2 + across * x, plan.height / 2 + down * y]));
    try {
      this.take(await inTurn(() => floats(`/v1/soundings?${query}`)),
        { columns, rows, corners, key, scale: plan.scale, level: plan.state.sea?.level ?? 0 });
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      this.asked = key; // not again until something else is seen
    } finally {
      this.asking = false;
    }
  }

  // depths: below mean sea level; shown is what the water of now has.
  take(depths, { columns, rows, corners, key, level, scale }) {
    const { canvas } = this;
    [canvas.width, canvas.height] = [columns, rows];
    const g = canvas.getContext("2d");
    const image = g.createImageData(columns, rows);
    for (let i = 0; i < depths.length; i++) {
      depths[i] += level;
      if (!Number.isNaN(depths[i])) {
        image.data.set([...colour(depths[i]), 255], 4 * i);
      }
    }
    g.putImageData(image, 0, 0);
    Object.assign(this, { depths, columns, rows, corners, asked: key });
    this.coast = this.coastOf();
    this.plan.canvas.dataset.depths = depths.filter((d) =>
      !Number.isNaN(d)).length;
    this.plan.canvas.dataset.asked = scale.toPrecision(4);
    this.plan.canvas.dataset.land = depths.filter((d) => d < 0).length;
    this.plan.soon();
  }

  // From the raster to the plan's pixels, as that is now.
  matrix() {
    const [a, b, c] = this.corners.map((place) => this.plan.pixel(place));
    const { columns, rows } = this;
    return [(b[0] - a[0]) / columns, (b[1] - a[1]) / columns,
      (c[0] - a[0]) / rows, (c[1] - a[1]) / rows, a[0], a[1]];
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
    g.strokeStyle = COAST;
    g.lineWidth = 1.5 / Math.hypot(m[0], m[1]);
    g.stroke(this.coast);
    g.restore();
    this.drawSoundings(g, m);
  }

  at(m, x, y) {
    return [m[0] * x + m[2] * y + m[4], m[1] * x + m[3] * y + m[5]];
  }

  // Where the depth is 0, square by square of the raster's cells.
  coastOf() {
    const { depths: d, columns, rows } = this;
    const line = new Path2D();
    for (let y = 0; y + 1 < rows; y++) {
      for (let x = 0; x + 1 < columns; x++) {
        const i = y * columns + x;
        const land = (d[i] < 0) + (d[i + 1] < 0) + (d[i + columns] < 0) +
          (d[i + columns + 1] < 0);
        if (land > 0 && land < 4) {
          this.cut(line, x, y, [d[i], d[i + 1], d[i + columns + 1],
            d[i + columns]]);
        }
      }
    }
    return line;
  }

  cut(line, x, y, ring) {
    if (ring.some(Number.isNaN)) {
      return;
    }
    const places = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
    const cuts = [];
    ring.forEach((a, k) => {
      const b = ring[(k + 1) % 4];
      if (a < 0 !== b < 0) {
        const part = a / (a - b);
        const [[ax, ay], [bx, by]] = [places[k], places[(k + 1) % 4]];
        cuts.push([ax + (bx - ax) * part + 0.5, ay + (by - ay) * part + 0.5]);
      }
    });
    for (let k = 0; k + 1 < cuts.length; k += 2) {
      line.moveTo(...cuts[k]);
      line.lineTo(...cuts[k + 1]);
    }
  }

  drawSoundings(g, m) {
    const step = Math.max(1, Math.round(SOUNDING_PX / Math.hypot(m[0], m[1])));
    g.font = "10px system-ui, sans-serif";
    g.fillStyle = "#a9c6d3";
    g.textAlign = "center";
    for (let y = step >> 1; y < this.rows; y += step) {
      for (let x = step >> 1; x < this.columns; x += step) {
        const depth = this.depths[y * this.columns + x];
        if (depth >= 0) {
          const [px, py] = this.at(m, x + 0.5, y + 0.5);
          g.fillText(depth.toFixed(depth < 10 ? 1 : 0), px, py + 3);
        }
      }
    }
  }
}
