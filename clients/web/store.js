// The state as this page knows it: what the server said last and, over it,
// what people asked for here and the server has not yet answered. The page
// shows both together, so no answer that is older than what a person did sets
// it back. Changes go to the server one at a time, in the order in which they
// were asked for; each is made of the newest state when its turn comes.

import { Gone, inTurn, perform, Problem } from "/api.js";
import { learn } from "/rights.js";

const KEYS = { entities: "id", views: "name", presets: "name" };
const MERGE = { "Content-Type": "application/merge-patch+json" };

// A list by its elements' keys: null removes, what is new comes last.
function mergedList(list, change, key) {
  const left = new Map(Object.entries(change));
  const kept = list.map((element) => {
    const name = String(element[key] ?? 0);
    const part = left.get(name);
    return !left.delete(name) ? element
      : part === null ? null : merged(element, part);
  });
  for (const [name, part] of left) {
    if (part !== null) {
      kept.push(merged({ [key]: key === "id" ? Number(name) : name }, part));
    }
  }
  return kept.filter((element) => element !== null);
}

// The state after a merge patch, as the server applies it to what is there.
export function merged(state, patch) {
  const next = { ...state };
  for (const [name, change] of Object.entries(patch)) {
    if (change === null) {
      delete next[name];
    } else if (typeof change !== "object" || Array.isArray(change)) {
      next[name] = change;
    } else if (Array.isArray(state[name]) || KEYS[name]) {
      next[name] = mergedList(state[name] ?? [], change, KEYS[name]);
    } else {
      next[name] = merged(state[name] ?? {}, change);
    }
  }
  return next;
}

const applied = (state, change) => {
  const patch = change.make(state);
  return patch ? merged(state, patch) : state;
};

export class Store {
  // shown(): the state is another one; followed(before, after): what the
  // server says replaces what was expected of it.
  constructor({ shown, followed }) {
    this.shown = shown;
    this.followed = followed;
    this.told = {};
    this.asked = [];
    this.sent = new Map(); // when a change of a key was sent last
  }

  get state() {
    this.now = this.now ?? this.asked.reduce(applied, this.told);
    return this.now;
  }

  // first: an answer that was asked for already.
  read(first) {
    return inTurn(async () => {
      this.hear(await (first ?? perform("GET", "/v1/state")), this.told);
    });
  }

  // make(state): a merge patch for that state; null where there is nothing
  // left to change. A change that waits is replaced by one of the same key.
  // everyMs: no more often than that; afterMs: when as long nothing new came;
  // sure: how often to make it anew rather than of a state that is not the
  // server's newest; where a simulator changes that all the time, it goes then.
  ask(key, make, { everyMs = 0, afterMs = 0, sure = 0 } = {}) {
    const now = performance.now();
    const before = this.waiting(key);
    this.asked = this.asked.filter((a) => a !== before);
    before?.done();
    return new Promise((done, failed) => {
      this.asked.push({ key, make, sure, everyMs, done, failed, due:
        Math.max(now + afterMs, (this.sent.get(key) ?? 0) + everyMs) });
      this.changed();
      this.pump();
    });
  }

  waits(key) {
    return this.waiting(key) !== undefined;
  }

  step(seconds) {
    return inTurn(async () => {
      this.hear(await perform("POST", "/v1/clock/step", { seconds },
        { "Content-Type": "application/json" }), this.told);
    });
  }

  // --- within -----------------------------------------------------------------

  waiting(key) {
    return this.asked.find((change) => change.key === key && !change.sent);
  }

  changed() {
    this.now = undefined;
    this.shown();
  }

  hear(state, expected) {
    this.followed(expected, state);
    this.told = state;
    this.changed();
  }

  async pump() {
    if (this.pumping) {
      return;
    }
    this.pumping = true;
    while (this.asked.length > 0) {
      const wait = this.asked[0].due - performance.now();
      if (wait > 0) {
        await new Promise((resolve) => setTimeout(resolve, wait));
      } else {
        await this.send(this.asked[0]);
      }
    }
    this.pumping = false;
  }

  async send(change) {
    change.sent = true;
    try {
      await inTurn(() => this.write(change));
      change.done();
    } catch (error) {
      // What is asked of a server that is gone is not kept for later.
      const lost = error instanceof Gone ? this.asked : [change];
      this.asked = this.asked.filter((a) => !lost.includes(a));
      lost.forEach((a) => a.failed(error));
      this.changed();
    }
  }

  async write(change) {
    for (let left = change.sure; ; left--) {
      const patch = change.make(this.told);
      const answer = patch && await this.attempt(patch, left > 0);
      if (answer !== undefined) {
        if (change.everyMs > 0) {
          this.sent.set(change.key, performance.now());
        }
        this.asked = this.asked.filter((a) => a !== change);
        if (answer) {
          this.hear(answer, merged(this.told, patch));
        } else {
          this.changed();
        }
        return;
      }
      this.hear(await perform("GET", "/v1/state"), this.told);
    }
  }

  // undefined: it was to be sure, and others have changed the state meanwhile.
  async attempt(patch, sure) {
    try {
      return await perform("PATCH", "/v1/state", patch, { ...MERGE,
        ...(sure ? { "If-Match": `"${this.told.revision}"` } : {}) });
    } catch (error) {
      if (sure && error instanceof Problem && error.status === 412) {
        return undefined;
      }
      if (error instanceof Problem && error.status === 403) {
        learn().catch(() => {}); // the token's role has changed
      }
      throw error;
    }
  }
}
