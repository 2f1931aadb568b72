#!/usr/bin/env node
// From a frame's stamp to its decoded pixels in a real Chromium, on the page.
//
//   tests/bench/latency.mjs [--seconds 20] [--width 1280] [--height 720]
//                           [--openings 6] [--json FILE] [options of pelagosd …]
//
// Starts a daemon on the software device and the page at / in headless
// Chromium, which plays the view by WebSocket and WebCodecs. Each picture's
// header is noted as it arrives, and the time when the decoder gives the
// picture, by the clock that daemon and browser share. Prints how soon the
// first picture is there after the page is opened, rate, scale, the parts of
// the latency, and how soon a state patch is shown; then, from the stamp to the
// picture on the page, the ways that browsers play by themselves.
import fs from "node:fs";

import { openBrowser } from "../browser.mjs";
import { Daemon, sleep, until } from "../pelagos_daemon.mjs";

// Before the page's own scripts: what arrives, what is decoded, and when.
function probe() {
  const now = () => performance.timeOrigin + performance.now();
  const seen = { socket: 0, pictures: [] };
  window.pelagosProbe = seen;
  const waiting = new Map();
  let last = null;
  const Socket = window.WebSocket;
  window.WebSocket = class extends Socket {
    constructor(...parts) {
      super(...parts);
      if (!parts[0].toString().includes("/live")) {
        return;
      }
      seen.socket ||= now();
      this.addEventListener("message", (event) => {
        if (typeof event.data === "string") {
          return;
        }
        const at = new DataView(event.data);
        last = {
          number: Number(at.getBigUint64(8, true)),
          stamp: Number(at.getBigUint64(32, true)) / 1000,
          drawn: at.getUint32(40, true) / 1000,
          encoded: at.getUint32(44, true) / 1000,
          missed: at.getUint32(52, true),
          revision: Number(at.getBigUint64(56, true)),
          came: now(),
        };
      });
    }
  };
  const Decoder = window.VideoDecoder;
  window.VideoDecoder = class extends Decoder {
    constructor(init) {
      super({ ...init, output: (frame) => {
        const head = waiting.get(frame.timestamp);
        waiting.delete(frame.timestamp);
        if (head) {
          seen.pictures.push({ ...head, decoded: now() });
        }
        init.output(frame);
      } });
    }

    decode(chunk) {
      waiting.set(chunk.timestamp, last);
      super.decode(chunk);
    }
  };
}

// --- figures ------------------------------------------------------------------

function rank(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

const columns = (...values) =>
  values.map((v) => (v.toFixed?.(1) ?? v).padStart(8)).join("");

function line(name, values) {
  const [median, p95] = [rank(values, 0.5), rank(values, 0.95)];
  console.log(name.padEnd(46) + columns(median, p95, Math.max(...values)));
  return { median, p95, most: Math.max(...values) };
}

// --- measuring ----------------------------------------------------------------

// The pictures decoded since the last call.
const take = (page) =>
  page.evaluate(() => window.pelagosProbe.pictures.splice(0));

// Opens the page with an empty cache, up to its first picture.
async function opening(browser, url) {
  const context = await browser.newContext({
    viewport: { width: 1360, height: 900 } });
  const page = await context.newPage();
  await page.addInitScript(probe);
  await page.goto(url, { waitUntil: "commit" });
  const first = await until("a picture", () => page.evaluate(() =>
    window.pelagosProbe?.pictures[0]));
  const [asked, socket] = await page.evaluate(() =>
    [performance.timeOrigin, window.pelagosProbe.socket]);
  return { context, page, asked, socket, first,
    parts: [first.decoded - asked, socket - asked, first.stamp - socket,
      first.came - first.stamp, first.decoded - first.came] };
}

// Milliseconds from the answer to a PATCH to the stamp, and to the decoded
// pixels, of the first picture that shows it.
async function patches(daemon, page, count) {
  await take(page);
  const asked = [];
  const pictures = [];
  for (let i = 0; i < count; i++) {
    const { revision } = await daemon.patch({ sea: { windSpeed: 5 + i % 7 } });
    asked.push([Date.now(), Number(revision)]);
    await sleep(350);
    pictures.push(...await take(page));
  }
  const shown = asked.map(([at, revision]) =>
    [at, pictures.find((p) => p.revision >= revision)]).filter(([, p]) => p);
  return [shown.map(([at, p]) => p.stamp - at),
    shown.map(([at, p]) => p.decoded - at)];
}

// Milliseconds from the stamp to the picture shown, as the page tells it once a
// second: of WebRTC by RTP's time stamps, of HLS by the playlist's dates.
async function played(browser, url, way, seconds) {
  const page = await browser.newPage({ viewport: { width: 1360,
    height: 900 } });
  await page.goto(`${url}/?way=${way}`);
  const told = async () => Number.parseFloat(
    await page.locator(".fact.ms").innerText().catch(() => ""));
  await until(`a latency by ${way}`, async () => await told() >= 0);
  await sleep(4000); // its buffers are what they will be
  const values = [];
  for (let i = 0; i < seconds; i++) {
    await sleep(1000);
    values.push(await told());
  }
  await page.close();
  return line(`stamp to shown picture by ${way}`,
    values.filter((v) => v >= 0));
}

function options() {
  const given = { seconds: 20, width: 1280, height: 720, openings: 6 };
  const rest = [];
  const words = process.argv.slice(2);
  while (words.length > 0) {
    const word = words.shift();
    const name = word.replace(/^--/, "");
    if (name === "json") {
      given.json = words.shift();
    } else if (name in given) {
      given[name] = Number(words.shift());
      if (!(given[name] > 0)) {
        throw new Error(`${word}: a number above 0 is wanted`);
      }
    } else {
      rest.push(word);
    }
  }
  return { given, rest };
}

async function openings(browser, url, count) {
  const all = [];
  for (let i = 0; i < count; i++) {
    const { context, parts } = await opening(browser, url);
    all.push(parts);
    await context.close();
    await sleep(500); // nobody watches: nothing is drawn
  }
  const part = (n) => all.map((parts) => parts[n]);
  console.log(`first picture of ${count} openings, ms`.padEnd(46) +
    columns("median", "p95", "most"));
  const whole = line("page asked for to first decoded picture (bar 500)",
    part(0));
  return { ...whole, parts: {
    socket: line("  of it up to opening the WebSocket", part(1)),
    stamp: line("  of it up to the frame's stamp", part(2)),
    frame: line("  of it drawing, encoding, the way to the page", part(3)),
    decode: line("  of it decoding", part(4)) } };
}

function report(pictures, quality, { width, height }, changes) {
  const rate = 1e3 * (pictures.length - 1) /
    (pictures.at(-1).stamp - pictures[0].stamp);
  console.log(`\n${width}x${height}: ${rate.toFixed(1)} pictures a second ` +
    `decoded, drawn at ${quality.toFixed(2)} of the size; ` +
    `${pictures.at(-1).missed - pictures[0].missed} not sent`);
  console.log("ms".padEnd(46) + columns("median", "p95", "most"));
  const each = (name, value) => line(name, pictures.map(value));
  return { rate, quality,
    stampToPixelMs: each("stamp to decoded pixels",
      (p) => p.decoded - p.stamp),
    renderMs: each("  of it rendering", (p) => p.drawn),
    encodeMs: each("  of it waiting for an encoder, encoding",
      (p) => p.encoded - p.drawn),
    sendMs: each("  of it the way to the page",
      (p) => p.came - p.stamp - p.encoded),
    decodeMs: each("  of it decoding", (p) => p.decoded - p.came),
    beyondRenderMs: each("beyond the render time (bars 40, 100)",
      (p) => p.decoded - p.stamp - p.drawn),
    patchToStampMs: line("patch to the stamp of a frame that shows it",
      changes[0]),
    patchToPixelMs: line("patch to its decoded pixels (bar 67 + render)",
      changes[1]),
  };
}

async function main() {
  const { given, rest } = options();
  const daemon = await Daemon.start(rest);
  const browser = await openBrowser();
  try {
    await daemon.patch({ views: [{ name: "bridge", entity: 1,
      width: given.width, height: given.height }] });
    const first = await openings(browser, daemon.url, given.openings);
    const { page } = await opening(browser, daemon.url);
    await sleep(6000); // the scale is found, caches are warm
    await take(page);
    await sleep(1000 * given.seconds);
    const pictures = await take(page);
    if (pictures.length < 2) {
      throw new Error("no pictures came");
    }
    const changes = await patches(daemon, page, 20);
    const quality = await daemon.metric("pelagos_frames_quality");
    const figures = { firstPictureMs: first,
      ...report(pictures, quality, given, changes) };
    await page.close(); // of the ways one by one
    for (const way of ["webcodecs", "whep", "hls"]) {
      figures[`${way}Ms`] = await played(browser, daemon.url, way,
        given.seconds);
    }
    if (given.json) {
      fs.writeFileSync(given.json, JSON.stringify(figures, null, 2));
    }
  } finally {
    await browser.close();
    await daemon.stop();
  }
}

await main();
