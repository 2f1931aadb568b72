// The live views: all in a grid as large as the window allows, or one alone.

import { MOST_VIDEOS } from "/early.js";
import { isSent } from "/geo.js";
import { Hud } from "/hud.js";
import { outrun, silentInputs } from "/inputs.js";
import { link, wanted } from "/link.js";
import { followPointers, half, Look } from "/look.js";
import { Player } from "/player.js";
import { Pose, Track } from "/pose.js";

// A browser opens six HTTP connections to one host: four for streams, one for
// single pictures in turn, one for everything else. WebSockets and
// WebRTC do not count.
const STREAMS = { mjpeg: 4, webcodecs: MOST_VIDEOS, whep: MOST_VIDEOS,
  hls: 4 };
const TURN_MS = 150;
const PHONE_PX = 992;
const GAP_PX = 14;
// Tiles no wider than these leave out facts of their picture.
const NARROW_PX = 510;
const SLIM_PX = 315;
// Pictures may be so much smaller than they could be, for rows that are filled
// and in the order of what one sees.
const ROW_SHARE = 0.72;

// Where a view looks, to starboard of what carries it; astern is last.
const side = (view) => -half(-(view.yaw ?? 0) - (view.frustum
  ? (view.frustum.left + view.frustum.right) / 2 : 0));

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

// Hides what has no room beside a view's name, and sets the picture's height,
// which browsers that know aspect-ratio find by themselves.
export function fitted(node, view) {
  const fit = () => {
    const across = node.clientWidth;
    const { width, height } = view();
    node.classList.toggle("narrow", across <= NARROW_PX);
    node.classList.toggle("slim", across <= SLIM_PX);
    if (!CSS.supports("aspect-ratio", "1")) {
      node.style.setProperty("--tall", `${across * height / width}px`);
    }
  };
  // Not while sizes are told: older browsers complain of the change.
  new ResizeObserver(() => requestAnimationFrame(fit)).observe(node);
}

class Tile {
  constructor(grid, view) {
    this.grid = grid;
    this.name = view.name;
    this.seen = true; // until it is known better
    this.node = element("figure", "tile");
    this.node.tabIndex = 0;
    this.node.dataset.view = view.name;
    this.node.setAttribute("aria-label",
      `View ${view.name}: arrow keys look around, F is full screen`);
    this.image = element("img", "picture");
    this.image.alt = `The sea from view ${view.name}`;
    this.image.draggable = false;
    this.canvas = element("canvas", "picture");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", this.image.alt);
    this.glass = element("canvas", "glass");
    this.glass.setAttribute("aria-hidden", "true");
    this.hud = new Hud(this.glass);
    this.note = element("p", "tile-note", "waiting for a picture");
    this.why = element("p", "why");
    this.stale = element("p", "stale-note");
    this.stale.hidden = true;
    this.node.append(this.image, this.canvas, this.glass, this.note, this.why,
      this.stale, this.makeCaption());
    this.live = new Player(view.name, this.canvas, this.image,
      (frame) => this.told(frame), () => this.showWay());
    this.look = new Look(view.name, grid.store,
      (field) => grid.limits(field));
    this.showWay();
    fitted(this.node, () => this.view);
    this.node.addEventListener("focusin", () => grid.choose(this.name));
    this.node.addEventListener("pointerdown", () => grid.choose(this.name));
    followPointers(this.glass, { look: this.look, view: () => this.view,
      tapped: () => this.fullScreen() });
    this.update();
  }

  makeCaption() {
    const caption = element("figcaption", "caption");
    const facts = element("span", "rate");
    this.facts = {};
    for (const [name, title] of [
      ["host", "Frame of the simulator host that is shown"],
      ["size", "Size of the picture"],
      ["fps", "Pictures a second"], ["ms", "Age of the picture when shown"],
      ["dropped", "Pictures left out for this browser"],
      ["way", "How the pictures come"]]) {
      this.facts[name] = element("span", `fact ${name}`);
      this.facts[name].title = title;
      facts.append(this.facts[name]);
    }
    this.full = element("button", "full");
    this.full.append(corners());
    this.full.type = "button";
    this.full.title = "Full screen (F)";
    this.full.setAttribute("aria-label", `Full screen: ${this.name}`);
    this.full.addEventListener("click", () => this.fullScreen());
    caption.append(element("strong", "", this.name), facts, this.full);
    return caption;
  }

  // Of the newest state: what was asked for, before the server has it.
  get view() {
    this.last = this.grid.store.state.views?.find((v) =>
      v.name === this.name) ?? this.last;
    return this.last;
  }

  update() {
    const { view } = this;
    this.image.width = view.width;
    this.image.height = view.height;
    this.node.style.setProperty("--aspect", `${view.width} / ${view.height}`);
    this.drawHud();
    this.showStale();
  }

  // Whither a view looks that aims at something, the server alone knows.
  drawHud() {
    const { lookAt, orbit } = this.view;
    const known = !lookAt && !orbit && !isSent(this.view);
    this.glass.classList.toggle("clear", !this.grid.instruments || !known);
    if (this.grid.instruments && known) {
      this.hud.draw(this.pose(), this.grid.marks());
    }
  }

  pose() {
    const { state } = this.grid.store;
    const time = this.frame?.time ?? state.clock?.time ?? 0;
    const entity = this.view.entity === undefined ? undefined
      : this.grid.track.at(this.view.entity, time);
    return new Pose(this.view, entity, time, state.clock?.reckoning);
  }

  showWay() {
    this.node.dataset.way = this.live.way;
    this.why.hidden = this.live.why === "";
    this.why.textContent = `${this.live.title}: ${this.live.why}`;
  }

  told(frame) {
    this.note.hidden = frame !== null;
    if (frame) {
      this.frame = frame;
      this.showStale();
      this.drawHud();
      this.grid.frameShown(frame);
    } else {
      this.note.textContent = "no picture, trying again";
    }
  }

  // Of the picture that is shown, or of the state where pictures come without
  // saying so. One that is marked says so itself, where the instruments do not
  // hide it.
  showStale() {
    const { state } = this.grid.store;
    const silent = silentInputs(state);
    const stale = this.frame && (this.frame.stale ?? silent !== "");
    this.stale.hidden = !stale ||
      (Boolean(state.sources?.mark) && !this.grid.instruments);
    const said = [
      silent || (this.frame?.stale && !this.frame.poses)
        ? `Silent: ${silent || "an input"}` : "",
      this.frame?.poses ? outrun(state, this.frame.time) : "",
      this.frame?.ground ? "The camera is inside the ground: raise it, or " +
        "move it" : ""].filter(Boolean);
    this.stale.textContent = said.join(". ");
    this.stale.hidden = this.frame?.ground ? false : this.stale.hidden;
  }

  refresh() {
    const { rate, latencyMs, missed } = this.live;
    const { host, size, fps, ms, dropped, way } = this.facts;
    host.textContent = this.frame?.host ? `host frame ${this.frame.host}` : "";
    host.hidden = !this.frame?.host;
    const [width, height] = this.frame?.drawn ?? [this.view.width];
    const coarser = width < this.view.width;
    size.textContent = `${this.view.width}×${this.view.height}` +
      (coarser ? ` from ${width}×${height}` : "");
    size.title = coarser ? "Size of the picture, drawn coarser to hold its rate"
      : "Size of the picture";
    fps.textContent = `${rate ? rate.toFixed(rate < 10 ? 1 : 0) : "–"} fps`;
    ms.textContent =
      `${latencyMs === undefined ? "–" : latencyMs.toFixed(0)} ms`;
    dropped.textContent = `${missed} dropped`;
    way.textContent = this.live.title;
    return rate;
  }

  get isFull() {
    return document.fullscreenElement === this.node ||
      this.node.classList.contains("filled");
  }

  fullScreen() {
    if (document.fullscreenElement) {
      document.exitFullscreen();
    } else if (this.node.classList.contains("filled") ||
        !this.node.requestFullscreen) {
      this.fill();
    } else {
      this.node.requestFullscreen().catch(() => this.fill());
    }
  }

  fill() {
    this.node.classList.toggle("filled");
    this.grid.arrange();
  }

  remove() {
    this.live.stop();
    this.node.remove();
  }
}

export class Views {
  // limits(field): of a view, by the schema; chosen(name): another view is;
  // frameShown(frame): as it says.
  constructor(node, store, { limits, chosen, frameShown }) {
    this.node = node;
    this.store = store;
    this.limits = limits;
    this.onChosen = chosen;
    this.frameShown = frameShown;
    this.tiles = new Map();
    this.name = "";
    this.up = true;
    this.turn = 0;
    this.instruments = true;
    this.track = new Track();
    this.layout = link.layout ?? localStorage.getItem("pelagos-layout") ??
      "heading";
    document.body.classList.toggle("wall", link.layout === "wall");
    // What nobody sees is not sent: below the fold, behind a full screen.
    this.watcher = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        entry.target.tile.seen = entry.isIntersecting;
      }
      this.arrange();
    }, { rootMargin: "80px" });
    document.addEventListener("visibilitychange", () => this.arrange());
    document.addEventListener("fullscreenchange", () => {
      for (const tile of this.tiles.values()) {
        tile.node.classList.toggle("whole",
          document.fullscreenElement === tile.node);
      }
      this.arrange();
    });
    new ResizeObserver(() => this.lay()).observe(node);
    addEventListener("resize", () => this.lay());
    setTimeout(() => this.takeTurns(), TURN_MS);
  }

  setInstruments(on) {
    this.instruments = on;
    for (const tile of this.tiles.values()) {
      tile.drawHud();
      tile.showStale();
    }
  }

  // Bearings that the compass shows.
  marks() {
    const { sky, sea } = this.store.state;
    return {
      sun: sky?.sunElevation === undefined ? undefined : sky.sunAzimuth,
      wind: (sea?.windSpeed ?? 0) > 0 ? sea.windDirection : undefined,
    };
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

  show() {
    const { state } = this.store;
    this.track.add(state);
    const views = wanted(state.views ?? []);
    const names = new Set(views.map((view) => view.name));
    const before = [...this.tiles.keys()].join("\n");
    const now = views.map((view) => view.name).join("\n");
    for (const [name, tile] of this.tiles) {
      if (!names.has(name)) {
        this.watcher.unobserve(tile.node);
        tile.remove();
        this.tiles.delete(name);
      }
    }
    for (const view of views) {
      const tile = this.tiles.get(view.name);
      if (tile) {
        tile.update();
      } else {
        const made = new Tile(this, view);
        this.tiles.set(view.name, made);
        this.node.append(made.node);
        made.node.tile = made;
        this.watcher.observe(made.node);
        made.node.classList.toggle("filled", view.name === link.view);
      }
    }
    if (!names.has(this.name) && views.length > 0) {
      this.choose(views[0].name);
    }
    this.mark();
    this.arrange();
    if (this.told !== now || before !== [...this.tiles.keys()].join("\n") ||
        !this.laid) {
      this.told = now;
      this.sort(views);
      this.lay();
    }
  }

  // From port to starboard, or as the server has them, or as the address says.
  // Not anew while somebody looks around: pictures would change places.
  sort(views = wanted(this.store.state.views ?? [])) {
    const order = link.views || this.layout === "order" ? views
      : [...views].sort((a, b) => side(a) - side(b));
    order.forEach(({ name }, i) => {
      const { node } = this.tiles.get(name);
      if (this.node.children[i] !== node) {
        this.node.insertBefore(node, this.node.children[i]);
      }
    });
  }

  setLayout(layout) {
    this.layout = layout;
    localStorage.setItem("pelagos-layout", layout);
    this.sort();
    this.lay();
  }

  // Out of the full window.
  leaveFull() {
    for (const tile of this.tiles.values()) {
      tile.node.classList.remove("filled");
    }
    this.arrange();
  }

  // As few rows as leave the pictures nearly as large as they can be within the
  // window.
  lay() {
    const tiles = [...this.tiles.values()];
    if (tiles.length === 0) {
      return;
    }
    this.laid = true;
    const gap = GAP_PX;
    const width = this.node.clientWidth;
    const height = innerHeight - this.node.getBoundingClientRect().top -
      scrollY - 52;
    const aspect = Math.max(...tiles.map((t) => t.view.width / t.view.height));
    const ways = tiles.map((_, i) => {
      const rows = Math.ceil(tiles.length / (i + 1));
      return { columns: Math.ceil(tiles.length / rows), across: Math.min(
        (width - gap * i) / (i + 1),
        aspect * (height - gap * (rows - 1)) / rows) };
    });
    const most = Math.max(...ways.map((way) => way.across));
    const best = ways.findLast((way) => way.across >= ROW_SHARE * most);
    const phone = innerWidth < PHONE_PX || best.across < 160;
    this.node.style.setProperty("--columns", phone
      ? `repeat(${Math.max(1, Math.floor(width / 330))}, minmax(0, 1fr))`
      : `repeat(${best.columns}, ${Math.floor(best.across)}px)`);
    for (const tile of tiles) {
      tile.drawHud();
    }
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
    const up = this.up && !document.hidden;
    const streams = { mjpeg: 0, webcodecs: 0, whep: 0, hls: 0 };
    const full = [...this.tiles.values()].find((tile) => tile.isFull);
    for (const tile of this.tiles.values()) {
      const way = tile.live.way;
      tile.wanted = full ? tile === full : tile.seen;
      if (up && tile.wanted && streams[way] < STREAMS[way]) {
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
    const rest = [...this.tiles.values()].filter((t) => t.wanted && !t.live.running);
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
