// Several windows in step: each picture is held until the time at which all
// views of its frame are to be shown (proto/live.md, "Several windows").

const KEPT_MS = 60000; // answers: clocks drift
const MOST = 16; // decoded pictures that wait
// The daemon's longest delay, and some for clocks: who is to wait longer has a
// wrong time.
const LONGEST_MS = 2500;
const EARLY_MS = 8; // half a refresh: what is drawn now is seen by then

export const unixMs = () => performance.timeOrigin + performance.now();

// The server's clock, by the answer of the last minute that took least: it is
// wrong by half of what that took at most.
export class ServerClock {
  constructor() {
    this.answers = [];
  }

  add(askedMs, heardMs, serverMs) {
    this.answers = this.answers.filter((answer) =>
      heardMs - answer.heardMs < KEPT_MS);
    this.answers.push({ heardMs, tookMs: heardMs - askedMs,
      aheadMs: serverMs - (askedMs + heardMs) / 2 });
  }

  get known() {
    return this.answers.length > 0;
  }

  // Before ours.
  get aheadMs() {
    return this.answers.reduce((best, answer) =>
      answer.tookMs < best.tookMs ? answer : best,
    { tookMs: Infinity, aheadMs: 0 }).aheadMs;
  }

  get nowMs() {
    return unixMs() + this.aheadMs;
  }
}

// One for all views of a page: they change in the same refresh.
export const serverClock = new ServerClock();

// How long a picture waits that is to be shown so far from now.
export const heldMs = (awayMs) =>
  awayMs > 0 && awayMs <= LONGEST_MS ? awayMs : 0;

// `show(one)` or `one.close()` is called for each that was taken, in order.
export class Held {
  constructor(clock, show) {
    this.clock = clock;
    this.show = show;
    this.waiting = [];
    this.asked = null;
  }

  take(presentMs, one) {
    const nowMs = this.clock.nowMs;
    const held = heldMs(presentMs - nowMs) > 0;
    this.waiting.push({ presentMs: held ? presentMs : nowMs, one });
    if (this.waiting.length > MOST) {
      this.thin(); // the delay is long, or the page hidden: it draws none
    }
    this.asked = this.asked ?? requestAnimationFrame((at) => this.refresh(at));
  }

  // The one goes that leaves the shortest gap, so that the others are still
  // shown at their time, and evenly.
  thin() {
    const gap = (i) =>
      this.waiting[i + 1].presentMs - this.waiting[i - 1].presentMs;
    let least = 1;
    for (let i = 2; i + 1 < this.waiting.length; i++) {
      least = gap(i) < gap(least) ? i : least;
    }
    this.waiting.splice(least, 1)[0].one.close();
  }

  // Shows the last that is due in the refresh that began at `at`, the same for
  // all of a page.
  refresh(at) {
    const dueMs = performance.timeOrigin + at + this.clock.aheadMs + EARLY_MS;
    const gone = this.waiting.splice(0, 1 + this.waiting.findLastIndex(
      ({ presentMs }) => presentMs <= dueMs));
    const last = gone.pop();
    gone.forEach(({ one }) => one.close());
    this.asked = this.waiting.length
      ? requestAnimationFrame((next) => this.refresh(next)) : null;
    if (last) {
      this.show(last.one);
    }
  }

  clear() {
    cancelAnimationFrame(this.asked);
    this.asked = null;
    this.waiting.splice(0).forEach(({ one }) => one.close());
  }
}
