// Instruments over a picture: a compass strip whose marks stand above what
// they point at, and an artificial horizon with a pitch ladder.

import { direction } from "/pose.js";

const LINE = "#d8fbff";
const ACCENT = "#ffcf7a";
const SHADE = "#02070bcc";
const STRIP = 30; // height in CSS pixels
const NAMES = { 0: "N", 45: "NE", 90: "E", 135: "SE", 180: "S", 225: "SW",
  270: "W", 315: "NW" };

const three = (angle) => String(Math.round(angle) % 360).padStart(3, "0");

// Degrees between labels, so that there are five or so.
function stepOf(across) {
  return [1, 2, 5, 10, 15, 30].find((step) => across / step <= 7) ?? 45;
}

export class Hud {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  // pose: of the picture that is shown; marks: bearings {sun, wind}.
  draw(pose, marks) {
    const { canvas, context: g } = this;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const box = canvas.getBoundingClientRect();
    const aspect = (pose.right - pose.left) / (pose.top - pose.bottom);
    const width = Math.min(box.width, box.height * aspect);
    if (width < 40) {
      return;
    }
    const pixels = [Math.round(width * ratio),
      Math.round(width / aspect * ratio)];
    if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) {
      [canvas.width, canvas.height] = pixels;
    }
    this.width = width;
    this.height = width / aspect;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, this.width, this.height);
    g.lineCap = "round";
    this.horizon(pose);
    this.strip(pose, marks);
    canvas.dataset.bearing = three(pose.bearing);
  }

  line(points, color = LINE, width = 1.5) {
    const g = this.context;
    for (const [style, w] of [[SHADE, width + 2], [color, width]]) {
      g.strokeStyle = style;
      g.lineWidth = w;
      g.beginPath();
      points.forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
      g.stroke();
    }
  }

  text(text, x, y, color = LINE, align = "center") {
    const g = this.context;
    g.textAlign = align;
    g.textBaseline = "middle";
    g.strokeStyle = SHADE;
    g.lineWidth = 3;
    g.lineJoin = "round";
    g.strokeText(text, x, y);
    g.fillStyle = color;
    g.fillText(text, x, y);
  }

  // Column of a bearing at the picture's own height; null: not in it.
  column(pose, bearing) {
    const elevation = Math.max(-60, Math.min(60, pose.elevation));
    const place = pose.place(direction(bearing, elevation));
    return place && place[0] > 0.005 && place[0] < 0.995
      ? place[0] * this.width : null;
  }

  strip(pose, marks) {
    const g = this.context;
    const shade = g.createLinearGradient(0, 0, 0, STRIP + 22);
    shade.addColorStop(0, "#02070bc0");
    shade.addColorStop(1, "#02070b00");
    g.fillStyle = shade;
    g.fillRect(0, 0, this.width, STRIP + 22);
    const step = stepOf(pose.across);
    const fine = step / 5;
    const first = Math.floor((pose.bearing - pose.across) / fine);
    const last = Math.ceil((pose.bearing + pose.across) / fine);
    for (let i = first; i <= last; i++) {
      const bearing = Math.round(i * fine * 100) / 100;
      const x = this.column(pose, bearing);
      if (x === null) {
        continue;
      }
      const labelled = i % 5 === 0;
      this.line([[x, 0], [x, labelled ? 8 : 4]], LINE, 1);
      const at = ((bearing % 360) + 360) % 360;
      if (labelled && Math.abs(x - this.width / 2) > 24) {
        g.font = NAMES[at] ? "600 13px system-ui, sans-serif"
          : "12px system-ui, sans-serif";
        this.text(NAMES[at] ?? three(at), x, 17, NAMES[at] ? ACCENT : LINE);
      }
    }
    this.marks(pose, marks);
    this.reading(three(pose.bearing));
  }

  marks(pose, { sun, wind }) {
    const g = this.context;
    const y = STRIP + 3;
    const x = { sun, wind, bow: pose.bow };
    for (const name of Object.keys(x)) {
      x[name] = x[name] === undefined ? null : this.column(pose, x[name]);
    }
    if (x.bow !== null) { // the bow
      this.line([[x.bow - 5, y + 4], [x.bow, y - 4], [x.bow + 5, y + 4]]);
    }
    if (x.wind !== null) { // blows towards the eye
      this.line([[x.wind, y - 5], [x.wind, y + 5]], "#58c9ea", 2);
      this.line([[x.wind - 4, y + 1], [x.wind, y + 6], [x.wind + 4, y + 1]],
        "#58c9ea", 2);
    }
    if (x.sun !== null) {
      g.beginPath();
      g.arc(x.sun, y, 5, 0, 2 * Math.PI);
      g.fillStyle = ACCENT;
      g.fill();
    }
  }

  // The bearing of the picture's middle.
  reading(text) {
    const g = this.context;
    const x = this.width / 2;
    g.fillStyle = "#02070be0";
    g.strokeStyle = LINE;
    g.lineWidth = 1.2;
    g.beginPath();
    g.roundRect(x - 21, 7, 42, 20, 4);
    g.fill();
    g.stroke();
    this.line([[x, 0], [x, 7]], LINE, 2);
    g.font = "600 13px ui-monospace, monospace";
    g.textAlign = "center";
    g.textBaseline = "middle";
    g.fillStyle = "#ffffff";
    g.fillText(text, x, 17.5);
  }

  horizon(pose) {
    const g = this.context;
    const [w, h] = [this.width, this.height];
    const at = (bearing, elevation) => {
      const place = pose.place(direction(bearing, elevation));
      return place ? [place[0] * w, place[1] * h] : null;
    };
    const small = w < 420;
    const step = pose.across < 30 ? 5 : 10;
    const most = small ? step : 3 * step;
    const upright = Math.abs(pose.elevation) < 75;
    g.font = "11px system-ui, sans-serif";
    for (let e = -most; upright && e <= most; e += step) {
      const middle = at(pose.bearing, e);
      const beside = at(pose.bearing + 1, e);
      if (!middle || !beside || middle[1] < STRIP + 26 || middle[1] > h - 40) {
        continue;
      }
      const length = Math.hypot(beside[0] - middle[0], beside[1] - middle[1]);
      const along = [(beside[0] - middle[0]) / length,
        (beside[1] - middle[1]) / length];
      const outer = e === 0 ? Math.min(0.32 * w, 220) : small ? 26 : 40;
      const inner = e === 0 ? 30 : 18;
      const down = e === 0 ? 0 : Math.sign(e) * 5;
      for (const side of [-1, 1]) {
        const to = (d, off) => [middle[0] + side * d * along[0] - off * along[1],
          middle[1] + side * d * along[1] + off * along[0]];
        this.line(e === 0 ? [to(inner, 0), to(outer, 0)]
          : [to(inner, 0), to(outer, 0), to(outer, down)],
        LINE, e === 0 ? 2 : 1.2);
        if (e !== 0) {
          this.text(String(Math.abs(e)), ...to(outer + 11, 0));
        }
      }
    }
    // The eye itself.
    const [x, y] = [w / 2, h / 2];
    this.line([[x - 22, y], [x - 9, y], [x, y + 6], [x + 9, y], [x + 22, y]],
      ACCENT, 2);
    g.font = "12px system-ui, sans-serif";
    const sign = (v) => `${v < -0.05 ? "−" : "+"}${Math.abs(v).toFixed(1)}°`;
    this.text(`pitch ${sign(pose.elevation)}`, 10, STRIP + 32, LINE, "left");
    this.text(`roll ${sign(pose.roll)}`, w - 10, STRIP + 32, LINE, "right");
  }
}
