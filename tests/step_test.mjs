#!/usr/bin/env node
// Pictures that are held until their time (clients/web/step.js), by a clock and
// a screen of this test's own: at random delays every picture is shown in the
// refresh that is nearest to its time, two windows with different clocks show
// the same one in the same refresh, and what is not shown is closed.
import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const WEB = path.join(path.dirname(fileURLToPath(import.meta.url)),
  "../clients/web");
const REFRESH_MS = 1000 / 60;

let now = 0;
let asked = [];
Object.defineProperty(globalThis, "performance",
  { value: { timeOrigin: 1e12, now: () => now }, configurable: true });
globalThis.requestAnimationFrame = (call) => asked.push({ call });
globalThis.cancelAnimationFrame = (id) => { if (id) { asked[id - 1] = null; } };
const { Held, ServerClock, heldMs } = await import(path.join(WEB, "step.js"));

// A random number of [0, 1), the same in every run.
let seed = 1;
const chance = () => {
  seed = (seed * 1664525 + 1013904223) % 2 ** 32;
  return seed / 2 ** 32;
};

const refresh = () => {
  const calls = asked;
  asked = [];
  calls.forEach((one) => one?.call(now));
};

// One that says by how much the server is ahead, as answers that took
// 2 to 60 ms, one way longer than the other, would.
function clockOf(aheadMs) {
  const clock = new ServerClock();
  for (let i = 0; i < 30; i++) {
    const out = 1 + 29 * chance();
    const back = i === 20 ? 1 : 1 + 29 * chance();
    const way = i === 20 ? 1 : out;
    clock.add(1e12 + now, 1e12 + now + way + back, 1e12 + now + way + aheadMs);
  }
  return clock;
}

test("the server's clock is that of the quickest answer", () => {
  assert.equal(new ServerClock().known, false);
  assert.equal(new ServerClock().aheadMs, 0);
  const clock = clockOf(1234.5);
  assert.ok(Math.abs(clock.aheadMs - 1234.5) < 1e-3, String(clock.aheadMs));
});

test("each is shown in the refresh nearest to its time", () => {
  const ahead = 77;
  const shown = [];
  let closed = 0;
  const windows = [0, 1].map((i) => new Held(clockOf(ahead), (one) =>
    shown.push({ ...one, window: i, at: now })));
  const pictures = [];
  const came = [0, 0];
  for (let n = 0; n < 600; n++) {
    // 50 a second, 80 ms before their time, and up to 50 ms on their way.
    const present = 1000 + 20 * n;
    for (const i of [0, 1]) {
      came[i] = Math.max(came[i], present - 80 + 50 * chance());
      pictures.push({ n, present, window: i, arrives: came[i] });
    }
  }
  pictures.sort((a, b) => a.arrives - b.arrives);
  for (let next = 0, at = 0; at < 14000; at += REFRESH_MS) {
    while (next < pictures.length && pictures[next].arrives <= at) {
      const { n, present, window, arrives } = pictures[next++];
      now = arrives;
      windows[window].take(1e12 + present + ahead,
        { n, present, close: () => { closed++; } });
    }
    now = at;
    refresh();
  }
  for (const one of shown) {
    assert.ok(Math.abs(one.at - one.present) <= REFRESH_MS / 2 + 0.5,
      `${one.n} at ${one.at}, due ${one.present}`);
  }
  const of = (i) => shown.filter((one) => one.window === i)
    .map(({ n, at }) => [n, at]);
  assert.deepEqual(of(0), of(1));
  assert.ok(of(0).length > 590);
  assert.equal(shown.length + closed, 1200);
});

test("one that comes late is shown at once, one without a time too", () => {
  const shown = [];
  const held = new Held(clockOf(0), (one) => shown.push(one.n));
  held.take(1e12 + now - 500, { n: 1 });
  refresh();
  held.take(1e12 + now + 5000, { n: 2 }); // a clock that is wrong
  refresh();
  assert.deepEqual(shown, [1, 2]);
  assert.deepEqual([heldMs(-1), heldMs(100), heldMs(2000), heldMs(2501),
    heldMs(NaN)], [0, 100, 2000, 0, 0]);
});

test("a long delay makes fewer pictures, each at its time", () => {
  const begun = now;
  const shown = [];
  const held = new Held(clockOf(0), (one) => shown.push({ ...one, at: now }));
  for (let n = 0; n < 300; n++) { // 30 a second, 1.8 s before their time
    now = begun + n * 2 * REFRESH_MS;
    held.take(1e12 + now + 1800, { due: now + 1800, close: () => {} });
    refresh();
    now += REFRESH_MS;
    refresh();
  }
  const gaps = shown.slice(1).map(({ at }, i) => at - shown[i].at);
  assert.ok(shown.every(({ at, due }) => Math.abs(at - due) < REFRESH_MS));
  // Sixteen of 1.8 s lie 113 ms apart if they are even; which goes is chosen as
  // each comes, so some gaps are twice as long.
  assert.ok(Math.max(...gaps) < 300, String(gaps));
  assert.ok(shown.length > 40, `${shown.length} in 8.2 s`);
  console.log(`${shown.length} pictures in 8.2 s, ` +
    `${Math.max(...gaps).toFixed(0)} ms apart at most`);
});

test("a page that draws nothing keeps sixteen, and closes all at its end", () => {
  let closed = 0;
  const held = new Held(clockOf(0), () => assert.fail("shown"));
  for (let n = 0; n < 100; n++) {
    held.take(1e12 + now + 900, { close: () => { closed++; } });
  }
  assert.equal(closed, 84);
  held.clear();
  assert.equal(closed, 100);
  refresh();
});
