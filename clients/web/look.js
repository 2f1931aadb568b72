// Looking around: drag the picture by mouse or finger, pinch or turn the wheel
// to zoom, double-click for full screen. What is wanted is sent as fast as the
// server answers, never faster.

import { Gone, Problem } from "/api.js";
import { mayPatch } from "/rights.js";

const clamp = (x, low, high) => Math.max(low, Math.min(high, x));
const DOUBLE_MS = 350;
const STILL_PX = 6;

// -180 to 180: what a person reads.
export const half = (angle) => ((angle + 180) % 360 + 360) % 360 - 180;

export class Look {
  // limits: ranges of the schema {fieldOfView: [low, high]}.
  constructor(name, store, limits) {
    this.name = name;
    this.store = store;
    this.limits = limits;
    this.wish = {}; // of the change that was asked for last
  }

  async want(change) {
    const key = `look ${this.name}`;
    this.wish = this.store.waits(key) ? { ...this.wish, ...change } : change;
    const { wish } = this;
    if (!mayPatch({ views: { [this.name]: wish } }, this.store.state)) {
      return;
    }
    const make = (state) => {
      const there = state.views?.some((view) => view.name === this.name);
      return there ? { views: { [this.name]: wish } } : null;
    };
    try {
      await this.store.ask(key, make, { sure: 1 });
    } catch (error) {
      if (!(error instanceof Problem || error instanceof Gone)) {
        throw error;
      }
    }
  }

  // By degrees from the view's present direction.
  turn(view, right, up) {
    this.want({
      yaw: Math.round(half((view.yaw ?? 0) + right) * 100) / 100,
      pitch: Math.round(clamp((view.pitch ?? 0) + up, -90, 90) * 100) / 100,
    });
  }

  zoom(view, factor) {
    if (!view.frustum) {
      const [low, high] = this.limits("fieldOfView");
      this.want({ fieldOfView: Math.round(clamp(
        (view.fieldOfView ?? 60) * factor, low, high) * 10) / 10 });
    }
  }
}

// Pointers on `node` move what `view()` looks at.
export function followPointers(node, { look, view, tapped }) {
  const pointers = new Map();
  let moved = 0;
  let lastTap = 0;

  const degreesPerPixel = () => {
    const v = view();
    const across = v.frustum ? v.frustum.right - v.frustum.left
      : v.fieldOfView ?? 60;
    return across / node.clientWidth;
  };
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };

  node.addEventListener("pointerdown", (event) => {
    if (event.button === 0) {
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      node.setPointerCapture(event.pointerId);
      moved = pointers.size === 1 ? 0 : moved;
    }
  });
  node.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before || !view()) {
      return;
    }
    const apart = pointers.size === 2 ? spread() : 0;
    const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
    moved += Math.hypot(dx, dy);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (moved < STILL_PX) {
      return;
    }
    node.classList.add("grabbed");
    if (apart > 0) {
      look.zoom(view(), apart / Math.max(spread(), 1));
    } else if (pointers.size === 1) {
      // What was under the finger stays there.
      look.turn(view(), -dx * degreesPerPixel(), dy * degreesPerPixel());
    }
  });
  const end = (event) => {
    if (!pointers.delete(event.pointerId)) {
      return;
    }
    node.classList.remove("grabbed");
    if (event.type === "pointerup" && pointers.size === 0 &&
        moved < STILL_PX) {
      const now = performance.now();
      if (now - lastTap < DOUBLE_MS) {
        tapped();
        lastTap = 0;
      } else {
        lastTap = now;
      }
    }
  };
  for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) {
    node.addEventListener(type, end);
  }
  // In the grid the wheel scrolls the page.
  node.addEventListener("wheel", (event) => {
    if (view() && (event.ctrlKey || document.fullscreenElement ||
        node.closest(".filled"))) {
      event.preventDefault();
      look.zoom(view(), 1.001 ** event.deltaY);
    }
  }, { passive: false });
}
