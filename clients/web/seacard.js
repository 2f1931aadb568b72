// The sea-state card: what the sea is called, its spectrum, where its waves
// come from, and how high it has stood at own ship. Loaded when it is opened,
// with uPlot, which draws its diagrams; asks for nothing while it is closed.

import { Gone, inTurn, perform, Problem } from "/api.js";
import { offset, reckoned, three } from "/geo.js";
import { ownShip } from "/scenes.js";
import { WaveRose } from "/waverose.js";
import { BEAUFORT, DOUGLAS } from "/words.js";

const EVERY_MS = 1000;
const HISTORY_S = 180;
const BACK_S = 1; // steps into the past until it is filled
// No more numbers than the server writes within a millisecond or so.
const QUERY = { frequencies: 44, lowest: 0.25, highest: 3.5, directions: 24 };
const JSON_TYPE = { "Content-Type": "application/json" };
const byId = (id) => document.getElementById(id);

// uPlot, or null where this program was built without it.
let plots;
function loadPlots() {
  plots = plots ?? new Promise((resolve) => {
    const style = document.createElement("link");
    style.rel = "stylesheet";
    style.href = "/uplot.css";
    const script = document.createElement("script");
    script.src = "/uplot.js";
    script.onload = () => resolve(globalThis.uPlot ?? null);
    script.onerror = () => resolve(null);
    document.head.append(style, script);
  });
  return plots;
}

const colour = (name) => getComputedStyle(document.documentElement)
  .getPropertyValue(name).trim() || "#888";

function axis(label, more) {
  return { label, labelSize: 18, labelFont: "12px system-ui, sans-serif",
    font: "11px system-ui, sans-serif", stroke: () => colour("--mist"),
    grid: { stroke: () => colour("--edge"), width: 1 },
    ticks: { stroke: () => colour("--edge"), width: 1, size: 4 }, ...more };
}

function diagram(Plot, node, { x, y, ranges, fill }) {
  const size = () => ({ width: Math.max(180, node.clientWidth), height: 150 });
  const plot = new Plot({ ...size(), legend: { show: false },
    cursor: { show: false }, padding: [8, 8, 0, 0],
    scales: { x: { time: false, range: ranges.x },
      y: { range: ranges.y } },
    axes: [axis(x, { size: 26, gap: 2 }), axis(y, { size: 38, gap: 2 })],
    series: [{}, { stroke: () => colour("--water"), width: 2,
      fill: fill ? () => `color-mix(in srgb, ${colour("--water")} 22%, transparent)`
        : undefined, points: { show: false } }] }, [[0], [0]], node);
  new ResizeObserver(() => plot.setSize(size())).observe(node);
  plot.root.setAttribute("aria-hidden", "true");
  return plot;
}

const fixed = (value, digits, unit) =>
  value === undefined ? "–" : `${value.toFixed(digits)}${unit}`;

export class SeaCard {
  // details: the section it is in; time(): simulated time of the pictures.
  constructor(details, store, time) {
    this.details = details;
    this.store = store;
    this.time = time;
    this.heights = new Map(); // by simulated time, as the query had it
    this.rose = new WaveRose(byId("wave-rose"));
    new ResizeObserver(() => this.rose.draw()).observe(byId("wave-rose"));
    matchMedia("(prefers-color-scheme: light)").addEventListener("change",
      () => this.redraw());
    details.addEventListener("toggle", () => this.begin());
    this.begin();
  }

  get seen() {
    return this.details.open && !document.hidden &&
      this.details.offsetParent !== null;
  }

  async begin() {
    const Plot = await loadPlots();
    byId("plots-missing").hidden = Plot !== null;
    if (Plot && !this.spectrum) {
      this.spectrum = diagram(Plot, byId("plot-spectrum"), {
        x: "Frequency, Hz", y: "m²/Hz", fill: true,
        ranges: { x: [0, 0.5], y: (_, __, most) => [0, Math.max(1e-3,
          1.1 * most)] } });
      this.height = diagram(Plot, byId("plot-height"), {
        x: "Seconds ago", y: "m",
        ranges: { x: [-HISTORY_S, 0], y: (_, low, high) => {
          const most = Math.max(0.1, Math.abs(low), Math.abs(high));
          return [-1.1 * most, 1.1 * most];
        } } });
    }
    if (!this.running) {
      this.running = true;
      while (this.details.open) {
        const began = performance.now();
        if (this.seen) {
          await this.refresh();
        }
        await new Promise((resolve) => setTimeout(resolve,
          Math.max(50, EVERY_MS - (performance.now() - began))));
      }
      this.running = false;
    }
  }

  async refresh() {
    try {
      await this.askSpectrum();
      await this.askHeights();
      byId("sea-card-error").textContent = "";
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
      byId("sea-card-error").textContent = error instanceof Gone
        ? "The server does not answer." : error.message;
    }
  }

  // Where what it is made of has changed.
  async askSpectrum() {
    const { sea, sky, seabed } = this.store.told;
    const of = JSON.stringify([sea, sky?.rain, seabed?.file]);
    if (of !== this.of) {
      this.answer = await inTurn(() => perform("POST", "/v1/spectrum", QUERY,
        JSON_TYPE));
      this.of = of;
      this.heights.clear();
      this.showSpectrum();
    }
  }

  showSpectrum() {
    const a = this.answer;
    const { swell = [] } = this.store.told.sea ?? {};
    const highest = [...swell].sort((p, q) => q.height - p.height)[0];
    const height = a.drawn?.significantHeight ?? 0;
    const say = (id, text) => {
      byId(id).textContent = text;
    };
    say("card-hs", fixed(a.spectrum?.significantHeight, 2, " m"));
    say("card-tp", fixed(a.peakPeriod, 1, " s"));
    say("card-beaufort", `${a.beaufort ?? 0}, ${BEAUFORT[a.beaufort ?? 0]}`);
    say("card-douglas", `${a.douglas ?? 0}, ${DOUGLAS[a.douglas ?? 0]}`);
    say("card-age", a.waveAge === undefined ? "–" :
      `${a.waveAge.toFixed(2)}, ${a.waveAge < 1.2 ? "young"
        : "old"}`);
    say("card-swell", !highest ? "none" : `${fixed(a.swellHeight, 1, " m")}, ` +
      `${fixed(highest.period, 0, " s")} from ${three(highest.direction)}` +
      `${swell.length > 1 ? ` and ${swell.length - 1} more` : ""}`);
    say("card-foam", fixed(100 * (a.whitecaps ?? 0), 1, " %"));
    const rows = a.rows ?? [];
    const turn = 2 * Math.PI;
    this.lines = [rows.map((row) => row.omega / turn),
      rows.map((row) => (row.density ?? 0) * turn)];
    const peak = a.peakPeriod ? `, highest at ${(1 / a.peakPeriod).toFixed(3)
    } hertz` : "";
    byId("plot-spectrum").setAttribute("aria-label",
      `Spectrum over frequency${peak}; significant height ${height.toFixed(1)
      } metres`);
    this.rose.set(rows);
    byId("wave-rose").setAttribute("aria-label", a.meanDirection === undefined
      ? "No waves" : "Where the waves come from, by frequency: on the whole " +
        `from ${Math.round(a.meanDirection)} degrees`);
    this.spectrum?.setData(this.lines);
  }

  // Own ship's place at a simulated time, east and north of the origin.
  place(at) {
    const { state } = this.store;
    const ship = ownShip(state);
    const origin = { latitude: state.origin?.latitude ?? 52.6,
      longitude: state.origin?.longitude ?? 5.2 };
    return ship ? offset(origin, reckoned(ship, at, state.clock?.reckoning))
      : [0, 0];
  }

  async askHeight(at) {
    const answer = await inTurn(() => perform("POST", "/v1/surface",
      { time: at, points: [this.place(at)] }, JSON_TYPE));
    this.heights.set(at, answer.points?.[0]?.height ?? 0);
  }

  // This moment's and, until the diagram is full, one before all of them.
  async askHeights() {
    const now = Math.round(10 * this.time()) / 10;
    const times = [...this.heights.keys()];
    if (times.some((t) => t > now + 1)) {
      this.heights.clear(); // time was set back
    }
    if (!this.heights.has(now)) {
      await this.askHeight(now);
    }
    const first = Math.min(...this.heights.keys());
    const before = Math.round(10 * (first - BACK_S)) / 10;
    if (before >= Math.max(0, now - HISTORY_S)) {
      await this.askHeight(before);
    }
    for (const t of this.heights.keys()) {
      if (t < now - HISTORY_S - 2) {
        this.heights.delete(t);
      }
    }
    this.showHeights(now);
  }

  showHeights(now) {
    const times = [...this.heights.keys()].sort((a, b) => a - b);
    const values = times.map((t) => this.heights.get(t));
    this.height?.setData([times.map((t) => t - now), values]);
    const last = values.at(-1) ?? 0;
    byId("card-height").textContent = `${last < 0 ? "−" : "+"}${
      Math.abs(last).toFixed(2)} m`;
    byId("plot-height").setAttribute("aria-label",
      `Height of the sea at own ship, the last ${Math.round(now - times[0])
      } seconds: from ${Math.min(...values).toFixed(1)} to ${
        Math.max(...values).toFixed(1)} metres`);
  }

  redraw() {
    this.rose.draw();
    this.spectrum?.redraw();
    this.height?.redraw();
  }
}
