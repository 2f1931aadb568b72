// The grid of live views.

import { Player } from "/player.js";

// A browser opens six HTTP connections to one host: four for streams, one for
// single pictures in turn, one for everything else. WebSockets do not count.
const STREAMS = { mjpeg: 4, webcodecs: 16 };
const TURN_MS = 150;

function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className || "";
  node.textContent = text || "";
  return node;
}

// The four corners that mean full screen.
function corners() {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", "M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4");
  svg.append(path);
  return svg;
}

class Tile {
  constructor(grid, view) {
    this.grid = grid;
    this.name = view.name;
    this.node = element("figure", "tile");
    this.node.tabIndex = 0;
    this.node.dataset.view = view.name;
    this.node.setAttribute("aria-label", `View ${view.name}`);
    this.image = element("img", "picture");
    this.image.alt = `The sea from view ${view.name}`;
    this.image.draggable = false;
    this.canvas = element("canvas", "picture");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", this.image.alt);
    this.note = element("p", "tile-note", "waiting for a picture");
    this.why = element("p", "why");
    const caption = element("figcaption", "caption");
    this.title = element("strong", "", view.name);
    this.rate = element("span", "rate", "–");
    this.full = element("button", "full");
    this.full.append(corners());
    this.full.type = "button";
    this.full.title = "Full screen (F)";
    this.full.setAttribute("aria-label", `Full screen: ${view.name}`);
    caption.append(this.title, this.rate, this.full);
    this.node.append(this.image, this.canvas, this.note, this.why, caption);
    this.live = new Player(view.name, this.canvas, this.image,
      (frame) => this.told(frame), () => this.showWay());
    this.showWay();
    this.node.addEventListener("focusin", () => grid.choose(this.name));
    this.node.addEventListener("pointerdown", () => grid.choose(this.name));
    this.image.addEventListener("click", () => this.fullScreen());
    this.canvas.addEventListener("click", () => this.fullScreen());
    this.full.addEventListener("click", () => this.fullScreen());
    this.update(view);
  }

  update(view) {
    this.size = `${view.width}×${view.height}`;
    this.image.width = view.width;
    this.image.height = view.height;
    this.node.style.setProperty("--aspect", `${view.width} / ${view.height}`);
  }

  showWay() {
    this.node.dataset.way = this.live.way;
    this.why.hidden = this.live.why === "";
    this.why.textContent = `Motion-JPEG: ${this.live.why}`;
  }

  told(frame) {
    this.note.hidden = frame !== null;
    if (frame) {
      this.frame = frame;
      this.grid.frameShown(frame);
    } else {
      this.note.textContent = "no picture, trying again";
    }
  }

  refresh() {
    const rate = this.live.rate;
    this.rate.textContent =
      `${this.size} · ${rate ? rate.toFixed(rate < 10 ? 1 : 0) : "–"} fps` +
      ` · ${this.live.facts}`;
    return rate;
  }

  fullScreen() {
    if (document.fullscreenElement) {
      document.exitFullscreen();
    } else if (this.node.requestFullscreen) {
      this.node.requestFullscreen().catch(() => {
        this.node.classList.toggle("filled");
      });
    } else {
      this.node.classList.toggle("filled");
    }
  }

  remove() {
    this.live.stop();
    this.node.remove();
  }
}

export class Views {
  // `chosen(name)` when another view is chosen, `frameShown(frame)` for each
  // picture.
  constructor(node, chosen, frameShown) {
    this.node = node;
    this.onChosen = chosen;
    this.frameShown = frameShown;
    this.tiles = new Map();
    this.name = "";
    this.up = true;
    this.turn = 0;
    document.addEventListener("visibilitychange", () => this.arrange());
    setTimeout(() => this.takeTurns(), TURN_MS);
  }

  choose(name) {
    if (this.name !== name) {
      this.name = name;
      this.mark();
      this.onChosen(name);
    }
  }

  mark() {
    for (const tile of this.tiles.values()) {
      tile.node.classList.toggle("chosen", tile.name === this.name);
    }
  }

  get chosen() {
    return this.tiles.get(this.name);
  }

  // The views of a new state.
  show(views) {
    const names = new Set(views.map((view) => view.name));
    for (const [name, tile] of this.tiles) {
      if (!names.has(name)) {
        tile.remove();
        this.tiles.delete(name);
      }
    }
    for (const view of views) {
      const tile = this.tiles.get(view.name);
      if (tile) {
        tile.update(view);
      } else {
        const made = new Tile(this, view);
        this.tiles.set(view.name, made);
        this.node.append(made.node);
      }
    }
    this.node.dataset.count = String(Math.min(views.length, 9));
    if (!names.has(this.name) && views.length > 0) {
      this.choose(views[0].name);
    }
    this.mark();
    this.arrange();
  }

  // The server is there, or is not.
  setUp(up) {
    if (this.up !== up) {
      this.up = up;
      this.node.classList.toggle("stale", !up);
      this.arrange();
    }
  }

  arrange() {
    const wanted = this.up && !document.hidden;
    const streams = { mjpeg: 0, webcodecs: 0 };
    for (const tile of this.tiles.values()) {
      const way = tile.live.way;
      if (wanted && streams[way] < STREAMS[way]) {
        streams[way] += 1;
        tile.live.arrange();
        tile.live.start();
      } else {
        tile.live.stop();
      }
    }
  }

  // Views without a stream get single pictures, one after the other.
  async takeTurns() {
    const rest = [...this.tiles.values()].filter((t) => !t.live.running);
    if (this.up && !document.hidden && rest.length > 0) {
      const tile = rest[this.turn++ % rest.length];
      try {
        await tile.live.once();
      } catch {
        tile.told(null);
      }
    }
    setTimeout(() => this.takeTurns(), TURN_MS);
  }

  refresh() {
    let total = 0;
    for (const tile of this.tiles.values()) {
      total += tile.refresh();
    }
    return total;
  }
}
