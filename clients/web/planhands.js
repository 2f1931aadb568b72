// What people do to the plan, by mouse, finger, pen and keys: pan and zoom,
// choose a thing, move it, put a new one.

const STILL_PX = 6;
const REACH_PX = { mouse: 12, pen: 14, touch: 22 };
const STEP_PX = 24;

// act: { choose(id), move(id, place, done), put(place, motion), cancel(),
// remove(), adding(): whether the next click puts something, moves(entity):
// whether it may be moved }.
export class PlanHands {
  constructor(plan, act) {
    this.plan = plan;
    this.act = act;
    this.pointers = new Map();
    const { canvas } = plan;
    canvas.addEventListener("pointerdown", (e) => this.down(e));
    canvas.addEventListener("pointermove", (e) => this.move(e));
    for (const type of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(type, (e) => this.up(e));
    }
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      plan.zoom(1.0015 ** e.deltaY, this.at(e));
    }, { passive: false });
    canvas.addEventListener("keydown", (e) => this.key(e));
    for (const type of ["focus", "blur"]) {
      canvas.addEventListener(type, () => plan.soon());
    }
  }

  at(event) {
    const box = this.plan.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    if (event.button !== 0) {
      return;
    }
    const { plan } = this;
    const at = this.at(event);
    this.pointers.set(event.pointerId, at);
    plan.canvas.setPointerCapture(event.pointerId);
    if (this.pointers.size > 1) {
      this.drop(false); // two fingers zoom
      this.moved = true;
      return;
    }
    this.moved = false;
    if (this.act.adding()) {
      plan.adding = { from: at, to: at };
    } else {
      this.thing = plan.hit(at, REACH_PX[event.pointerType] ?? 14);
      this.grip = this.thing && plan.pixel(plan.at(this.thing))
        .map((x, i) => x - at[i]);
      this.began = at;
    }
    plan.soon();
  }

  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) {
      return;
    }
    const { plan } = this;
    const at = this.at(event);
    const apart = this.spread();
    this.pointers.set(event.pointerId, at);
    if (this.pointers.size === 2) {
      const [a, b] = [...this.pointers.values()];
      plan.zoom(apart / Math.max(this.spread(), 1),
        [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]);
    } else if (plan.adding) {
      plan.adding.to = at;
    } else if (this.began) {
      this.moved = this.moved || Math.hypot(at[0] - this.began[0],
        at[1] - this.began[1]) > STILL_PX;
      if (this.moved && this.thing && this.act.moves(this.thing)) {
        this.carry(plan.place(at.map((x, i) => x + this.grip[i])));
      } else if (this.moved) {
        plan.pan([before[0] - at[0], before[1] - at[1]]);
      }
    }
    plan.soon();
  }

  spread() {
    const [a, b] = [...this.pointers.values()];
    return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0;
  }

  // Its place in the hand is shown until the server has the last one.
  carry(place) {
    const id = this.thing.id ?? 0;
    const { drafts } = this.plan;
    const kept = { latitude: place.latitude, longitude: place.longitude };
    if (!this.plan.free) {
      this.plan.free = this.plan.centre; // which may be what is moved
    }
    drafts.set(id, kept);
    this.act.move(id, kept, () => {
      if (drafts.get(id) === kept && this.thing?.id !== id) {
        drafts.delete(id);
        this.plan.soon();
      }
    });
  }

  drop(whole) {
    const { plan } = this;
    const { adding } = plan;
    const { thing } = this;
    plan.adding = null;
    this.thing = this.began = undefined;
    if (!whole) {
      return;
    }
    if (adding) {
      this.act.put(plan.place(adding.from), plan.motion(adding));
    } else if (!this.moved) {
      this.act.choose(thing ? thing.id ?? 0 : null);
    } else if (thing && plan.drafts.has(thing.id ?? 0)) {
      this.thing = thing;
      const place = plan.drafts.get(thing.id ?? 0);
      this.carry(place);
      this.thing = undefined;
      this.act.choose(thing.id ?? 0);
    }
  }

  up(event) {
    if (this.pointers.delete(event.pointerId) && this.pointers.size === 0) {
      this.drop(event.type === "pointerup");
      this.plan.soon();
    }
  }

  key(event) {
    const { plan, act } = this;
    if (event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1],
      ArrowDown: [0, 1] }[event.key];
    const entity = (plan.state.entities ?? []).find((e) =>
      (e.id ?? 0) === plan.selected);
    if (way && event.shiftKey) {
      if (entity && act.moves(entity)) {
        const [x, y] = plan.pixel(plan.at(entity));
        this.thing = entity;
        this.carry(plan.place([x + way[0] * STEP_PX / 3,
          y + way[1] * STEP_PX / 3]));
        this.thing = undefined;
      }
    } else if (way) {
      plan.pan(way.map((d) => d * STEP_PX));
    } else if (event.key === "+" || event.key === "=") {
      plan.zoom(1 / 1.25);
    } else if (event.key === "-" || event.key === "−") {
      plan.zoom(1.25);
    } else if (event.key === "PageDown" || event.key === "PageUp") {
      act.next(event.key === "PageDown" ? 1 : -1);
    } else if (event.key === "Home") {
      plan.home();
    } else if (event.key === "Enter" && act.adding()) {
      act.put(plan.place([plan.width / 2, plan.height / 2]),
        { course: 0, speed: 0 });
    } else if (event.key === "Delete" && entity) {
      act.remove();
    } else if (event.key === "Escape" && act.adding()) {
      act.cancel();
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }
}
