// Live pictures. Each view is a Motion-JPEG stream, read part by part, so that
// the page knows what it shows: frame number, simulated time, rate. A picture
// is decoded before the next is read: a slow browser makes the server drop
// pictures, not queue them.

import { headers } from "/api.js";
import { link } from "/link.js";
import { heldMs, unixMs } from "/step.js";

const RETRY_MS = 1000;
const RATE_WINDOW_MS = 3000;
// Not this way, whatever the patience: forbidden, unknown, no place left.
const REFUSALS = [403, 405, 429];

// Bytes of a stream, taken a header or a body at a time.
class Parts {
  constructor(reader) {
    this.reader = reader;
    this.chunks = [];
    this.size = 0;
  }

  async more() {
    const { done, value } = await this.reader.read();
    if (done) {
      throw new Error("the stream ended");
    }
    this.chunks.push(value);
    this.size += value.length;
  }

  async take(count) {
    while (this.size < count) {
      await this.more();
    }
    const out = new Uint8Array(count);
    let at = 0;
    while (at < count) {
      const first = this.chunks[0];
      const n = Math.min(first.length, count - at);
      out.set(first.subarray(0, n), at);
      at += n;
      if (n === first.length) {
        this.chunks.shift();
      } else {
        this.chunks[0] = first.subarray(n);
      }
    }
    this.size -= count;
    return out;
  }

  // The header lines before a picture, as an object with lower-case names.
  async head() {
    let text = "";
    while (!text.endsWith("\r\n\r\n")) {
      if (text.length > 4096) {
        throw new Error("the stream is not understood");
      }
      text += String.fromCharCode((await this.take(1))[0]);
    }
    const head = {};
    for (const line of text.split("\r\n")) {
      const colon = line.indexOf(":");
      if (colon > 0) {
        head[line.slice(0, colon).toLowerCase()] = line.slice(colon + 1).trim();
      }
    }
    return head;
  }
}

// Whether an input was silent, and the simulator's frame: of a picture's
// header lines.
const inputs = (line) => ({
  poses: (line("x-pelagos-stale") ?? "").includes("poses"),
  ground: line("x-pelagos-ground") === "inside",
  stale: (line("x-pelagos-stale") ?? "none") !== "none",
  host: Number(line("x-pelagos-host-frame") ?? 0),
});

async function show(image, blob) {
  const url = URL.createObjectURL(blob);
  const before = image.dataset.url;
  image.src = url;
  image.dataset.url = url;
  try {
    await image.decode();
  } catch {
    // Replaced meanwhile, or a damaged picture: the next one comes.
  }
  if (before) {
    URL.revokeObjectURL(before);
  }
}

export class Live {
  // `told` is called after each picture with {number, time, drawn, stale, host}
  // and after the stream broke with null; `failed(why)` (null: none) where a
  // server that is there refuses it.
  constructor(name, image, told, failed, place = "/v1") {
    this.name = name;
    this.place = place;
    this.image = image;
    this.told = told;
    this.failed = failed;
    this.stamps = [];
    this.latencies = [];
    this.missed = 0;
    this.abort = null;
  }

  get rate() {
    const now = performance.now();
    this.stamps = this.stamps.filter((t) => now - t < RATE_WINDOW_MS);
    const span = now - (this.stamps[0] ?? now);
    return span > 200 ? (this.stamps.length - 1) * 1000 / span : 0;
  }

  // Median from the frame's stamp to its decoded picture, of the last ones.
  get latencyMs() {
    const sorted = [...this.latencies].sort((a, b) => a - b);
    return sorted[sorted.length >> 1];
  }

  get running() {
    return this.abort !== null;
  }

  start() {
    if (!this.abort) {
      this.abort = new AbortController();
      this.run(this.abort.signal);
    }
  }

  stop() {
    this.abort?.abort();
    this.abort = null;
    this.stamps = [];
    this.latencies = [];
  }

  async run(signal) {
    while (!signal.aborted) {
      try {
        await this.read(signal);
      } catch (error) {
        if (!signal.aborted) {
          this.told(null);
          if (this.failed && REFUSALS.includes(error.status)) {
            this.failed(`live streams are refused here (${error.message})`);
          }
        }
      }
      await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
    }
  }

  async read(signal) {
    const response = await fetch(
      `${this.place}/views/${encodeURIComponent(this.name)}/mjpeg`,
      { signal, cache: "no-store", headers: headers() });
    if (!response.ok) {
      throw Object.assign(new Error(`HTTP ${response.status}`),
        { status: response.status });
    }
    // Its clock minus ours, by less than the time that the answer took.
    const clockMs = 1000 * Number(response.headers.get("X-Pelagos-Unix")) -
      unixMs();
    const parts = new Parts(response.body.getReader());
    while (!signal.aborted) {
      const head = await parts.head();
      const data = await parts.take(Number(head["content-length"]));
      if (link.step) {
        const waitMs = heldMs(1000 * Number(head["x-pelagos-present"]) -
          clockMs - unixMs());
        await new Promise((resolve) => setTimeout(resolve, waitMs));
      }
      await show(this.image, new Blob([data], { type: "image/jpeg" }));
      this.stamps.push(performance.now());
      this.missed = Number(head["x-pelagos-missed"] ?? 0);
      const stampMs = Number(head["x-pelagos-stamp"]) / 1000;
      if (stampMs > 0) {
        this.latencies.push(Math.max(unixMs() + clockMs - stampMs, 0));
        this.latencies.splice(0, this.latencies.length - 31);
      }
      this.told({
        number: Number(head["x-pelagos-frame"]),
        time: Number(head["x-pelagos-time"]),
        drawn: head["x-pelagos-drawn"]?.split("x").map(Number),
        ...inputs((name) => head[name]),
      });
    }
  }

  // One picture instead of a stream, for views beyond the browser's limit of
  // connections.
  async once() {
    const response = await fetch(
      `${this.place}/views/${encodeURIComponent(this.name)}/frame.jpg?quality=80`,
      { cache: "no-store", signal: AbortSignal.timeout(10000),
        headers: headers() });
    if (!response.ok) {
      throw new Error(`HTTP ${response.status}`);
    }
    await show(this.image, await response.blob());
    this.stamps.push(performance.now());
    this.told({
      number: Number(response.headers.get("X-Pelagos-Frame")),
      time: Number(response.headers.get("X-Pelagos-Time")),
      ...inputs((name) => response.headers.get(name)),
    });
  }
}
