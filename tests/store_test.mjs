#!/usr/bin/env node
// The page's store (clients/web/store.js) against a server that answers when
// it likes, refuses, vanishes, and has other clients: at random, by a clock of
// its own. STORE_RUNS (300) walks from STORE_SEED (1); a walk that fails says
// its seed.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";

const RUNS = Number(process.env.STORE_RUNS ?? 300);
const SEED = Number(process.env.STORE_SEED ?? 1);
const WEB = path.join(path.dirname(fileURLToPath(import.meta.url)),
  "../clients/web");

// --- what a browser has -------------------------------------------------------

const clock = { now: 0, timers: [] };
const tick = setImmediate;
globalThis.performance = { now: () => clock.now };
globalThis.location = { hash: "", pathname: "/", search: "" };
globalThis.sessionStorage = { getItem: () => null, setItem: () => {} };
globalThis.history = { replaceState: () => {} };
globalThis.addEventListener = () => {};
globalThis.setTimeout = (call, ms) => {
  clock.timers.push({ call, at: clock.now + ms });
};
AbortSignal.timeout = () => undefined;

// Let everything happen that needs no more time.
async function settle() {
  for (let i = 0; i < 3; i++) {
    await new Promise((done) => tick(done));
  }
}

async function pass(ms) {
  clock.now += ms;
  const due = clock.timers.filter((timer) => timer.at <= clock.now);
  clock.timers = clock.timers.filter((timer) => timer.at > clock.now);
  due.sort((a, b) => a.at - b.at).forEach((timer) => timer.call());
  await settle();
}

// A page names its modules from the server's root.
const folder = mkdtempSync(path.join(tmpdir(), "pelagos-store-"));
after(() => rmSync(folder, { recursive: true }));
for (const name of ["store", "api", "rights"]) {
  writeFileSync(path.join(folder, `${name}.mjs`),
    readFileSync(path.join(WEB, `${name}.js`), "utf8")
      .replace(/"\/(\w+)\.js"/g, '"./$1.mjs"'));
}
const { merged, Store } = await import(
  pathToFileURL(path.join(folder, "store.mjs")));

// --- chance -------------------------------------------------------------------

class Chance {
  constructor(seed) {
    this.state = (seed * 2654435761) >>> 0;
  }

  below(n) { // mulberry32
    this.state = (this.state + 0x6d2b79f5) >>> 0;
    let t = this.state;
    t = Math.imul(t ^ (t >>> 15), t | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) % n;
  }

  of(list) {
    return list[this.below(list.length)];
  }

  number() {
    return this.of([this.below(100), -(1 + this.below(1000)) / 7, 0.1 + 0.2, 5e-324,
      1.7976931348623157e308, 2 ** 53 - 1, Math.PI * 10 ** -this.below(30),
      1e21]);
  }
}

// --- the server, by other means than the page's -------------------------------

const KEYS = { entities: "id", views: "name" };

// RFC 7396, lists with a key as objects of their elements.
function patched(state, patch) {
  if (patch === null || typeof patch !== "object" || Array.isArray(patch)) {
    return structuredClone(patch);
  }
  const out = structuredClone(state ?? {});
  for (const name of Object.keys(patch)) {
    const key = KEYS[name];
    if (patch[name] === null) {
      delete out[name];
    } else if (key && !Array.isArray(patch[name])) {
      for (const [id, change] of Object.entries(patch[name])) {
        const at = out[name].findIndex((e) => String(e[key] ?? 0) === id);
        if (change === null) {
          at < 0 || out[name].splice(at, 1);
        } else if (at < 0) {
          out[name].push(patched({ [key]: key === "id" ? Number(id) : id },
            change));
        } else {
          out[name][at] = patched(out[name][at], change);
        }
      }
    } else {
      out[name] = patched(out[name], patch[name]);
    }
  }
  return out;
}

class Server {
  constructor(chance) {
    this.chance = chance;
    this.waiting = [];
    this.state = { revision: "1", sea: { windSpeed: 7, swell: [{ height: 1 }] },
      sky: {}, entities: [{ id: 1, name: "ownship" }], views: [] };
  }

  apply(patch) {
    this.state = patched(this.state, patch);
    this.state.revision = String(Number(this.state.revision) + 1);
  }

  request(url, { method, body, headers }) {
    return new Promise((resolve, reject) => {
      this.waiting.push({ method, headers, resolve, reject,
        patch: body && JSON.parse(body) });
    });
  }

  // Takes what came, or answers what was taken.
  serve(calm) {
    const one = this.waiting[0];
    if (!one) {
      return;
    }
    const fate = calm ? 99 : this.chance.below(100);
    if (!one.answer) {
      one.answer = this.answer(one, fate);
    } else {
      this.waiting.shift();
      if (one.answer === "gone" || (!calm && fate < 2)) {
        one.reject(new Error("connection lost"));
      } else {
        one.resolve({ ok: one.answer.status < 300, status: one.answer.status,
          headers: new Headers(), text: async () => one.answer.text });
      }
    }
  }

  answer({ method, patch, headers }, fate) {
    const match = headers?.["If-Match"];
    if (fate < 3) {
      return "gone";
    }
    if (method === "PATCH" && match && match !== `"${this.state.revision}"`) {
      return { status: 412, text: "{}" };
    }
    if (method === "PATCH" && fate < 12) {
      return { status: 422, text: JSON.stringify({ detail: "no", path: "x" }) };
    }
    if (method === "PATCH") {
      this.apply(patch);
    }
    return { status: 200, text: JSON.stringify(this.state) };
  }
}

// --- patches ------------------------------------------------------------------

function somePatch(chance) {
  const id = String(1 + chance.below(4));
  return chance.of([
    () => ({ sea: { windSpeed: chance.number() } }),
    () => ({ sea: { windSpeed: null } }),
    () => ({ sea: { swell: [{ height: chance.number() }] } }),
    () => ({ sky: { haze: { height: chance.number() } } }),
    () => ({ sky: null }),
    () => ({ sky: { haze: null, stars: chance.below(2) === 1 } }),
    () => ({ entities: { [id]: { heading: chance.number() } } }),
    () => ({ entities: { [id]: { model: { name: "tug" }, speed: 3 } } }),
    () => ({ entities: { [id]: null } }),
    () => ({ views: { bow: { yaw: chance.number() }, wing: null } }),
    () => ({ views: { wing: { width: 64 } } }),
  ])();
}

function frozen(value) {
  if (value && typeof value === "object") {
    Object.values(value).forEach(frozen);
    Object.freeze(value);
  }
  return value;
}

test("a merge patch is what the server makes of it, and changes nothing", () => {
  const chance = new Chance(SEED);
  let state = frozen(new Server(chance).state);
  for (let i = 0; i < 20 * RUNS; i++) {
    const patch = frozen(somePatch(chance));
    const next = merged(state, patch);
    assert.deepEqual(next, patched(state, patch), JSON.stringify(patch));
    // Patched twice is patched once.
    assert.deepEqual(merged(next, patch), next, JSON.stringify(patch));
    assert.deepEqual(JSON.parse(JSON.stringify(next)), next);
    state = frozen(next);
  }
});

// --- walks --------------------------------------------------------------------

class Walk {
  constructor(seed) {
    this.chance = new Chance(seed);
    this.server = new Server(this.chance);
    globalThis.fetch = (...request) => this.server.request(...request);
    this.settled = this.asked = 0;
    this.pending = []; // what a person asked for and nobody has answered
    this.store = new Store({ shown: () => this.look(), followed: () => {} });
  }

  // The page shows what the server said last, and over it what was asked for.
  look() {
    if (this.store) {
      let state = this.store.told;
      for (const change of this.store.asked) {
        const patch = change.make(state);
        state = patch ? patched(state, patch) : state;
      }
      assert.deepEqual(this.store.state, state);
      this.shown?.(state);
    }
  }

  ask() {
    const { chance } = this;
    const patch = somePatch(chance);
    const key = Object.keys(patch)[0];
    const make = chance.below(10) ? () => patch
      : (state) => state.sea?.windSpeed === 7 ? null : patch;
    const change = { patch, make };
    this.asked++;
    this.pending.push(change);
    const end = () => {
      assert.ok(this.pending.includes(change), "settled twice");
      this.pending.splice(this.pending.indexOf(change), 1);
      this.settled++;
    };
    this.store.ask(key, make, {
      everyMs: chance.of([0, 0, 100]), afterMs: chance.of([0, 0, 300]),
      sure: chance.of([0, 0, 2]) }).then(end, end);
  }

  async step() {
    const { chance } = this;
    const what = chance.below(20);
    if (what < 6) {
      this.ask();
    } else if (what < 13) {
      this.server.serve(false);
    } else if (what < 15) {
      this.server.apply(somePatch(chance)); // another client
    } else if (what < 16) {
      this.store.read().catch(() => {});
    } else if (what < 17) {
      await pass(chance.of([1, 50, 400]));
    }
    await settle();
    this.look();
  }

  // All is answered: the page has what the server has.
  async finish() {
    for (let i = 0; i < 400 && (this.server.waiting.length > 0 ||
        this.store.asked.length > 0); i++) {
      this.server.serve(true);
      await pass(50);
    }
    assert.equal(this.pending.length, 0);
    assert.equal(this.settled, this.asked);
    const read = this.store.read();
    await settle();
    this.server.serve(true);
    this.server.serve(true);
    await read;
    assert.deepEqual(this.store.state, this.server.state);
  }
}

test("a page comes to have what the server has", async () => {
  for (let seed = SEED; seed < SEED + RUNS; seed++) {
    const walk = new Walk(seed);
    const first = walk.store.read();
    await settle();
    walk.server.serve(true);
    walk.server.serve(true);
    await first;
    try {
      for (let i = 0; i < 60; i++) {
        await walk.step();
      }
      await walk.finish();
    } catch (error) {
      error.message = `STORE_SEED=${seed}: ${error.message}`;
      throw error;
    }
  }
});

// A hand on a slider, alone with the server, which answers late but answers.
test("a slider is never set back", async () => {
  for (let seed = SEED; seed < SEED + RUNS; seed++) {
    const chance = new Chance(seed);
    const walk = new Walk(seed);
    const first = walk.store.read();
    await settle();
    walk.server.serve(true);
    walk.server.serve(true);
    await first;
    let last = 7;
    walk.shown = (state) => assert.equal(state.sea.windSpeed, last,
      `STORE_SEED=${seed}`);
    for (let i = 0; i < 60; i++) {
      if (chance.below(3) === 0) {
        const value = last += 1 + chance.below(3);
        walk.store.ask("wind", () => ({ sea: { windSpeed: value } }),
          { everyMs: chance.of([0, 100]) });
      } else if (chance.below(2)) {
        walk.server.serve(true);
      } else {
        await pass(chance.of([1, 60]));
      }
      await settle();
    }
    await walk.finish();
    assert.equal(walk.server.state.sea.windSpeed, last);
  }
});

// What was refused is as if it had not been asked for; the rest stays.
test("a refusal leaves all else", async () => {
  for (let seed = SEED; seed < SEED + RUNS; seed++) {
    const walk = new Walk(seed);
    const first = walk.store.read();
    await settle();
    walk.server.serve(true);
    walk.server.serve(true);
    await first;
    const before = walk.store.state;
    const value = walk.chance.number();
    const refused = assert.rejects(
      walk.store.ask("a", () => ({ sea: { windSpeed: -1 } })), /no/);
    const kept = walk.store.ask("b", () => ({ sky: { stars: value } }));
    await settle();
    walk.server.waiting[0].answer = { status: 422,
      text: JSON.stringify({ detail: "no" }) };
    walk.server.serve(true);
    await refused;
    await settle();
    assert.deepEqual(walk.store.state,
      { ...before, sky: { stars: value } });
    walk.server.serve(true);
    walk.server.serve(true);
    await kept;
    assert.equal(walk.store.state.sky.stars, value);
    assert.deepEqual(walk.store.state, walk.server.state);
  }
});
