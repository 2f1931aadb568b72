#!/usr/bin/env node
// The page in a real browser: pictures, instruments, inputs, looking around,
// tokens, errors, loss of the server; plain and through nginx with TLS.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import dgram from "node:dgram";
import fs from "node:fs";
import path from "node:path";
import { after, before, beforeEach, describe, test } from "node:test";

import { wanted } from "./browser.mjs";
import { daemon, fresh, open, openSections, page, pictures, shot, SHOTS, slide,
  state, text, view } from "./page.mjs";
import { Daemon, folder, freePort, Proxy, sleep, until }
  from "./pelagos_daemon.mjs";

const TOKEN = "0123456789abcdef0123456789abcdef";
const axe = wanted("axe-core");

// Mean, spread and a sum of the picture's lower half.
const pixels = () => page.evaluate(() => {
  const p = [...document.querySelectorAll(".picture")].find((n) => !n.hidden);
  const c = document.createElement("canvas");
  [c.width, c.height] = [320, 180];
  const g = c.getContext("2d", { willReadFrequently: true });
  g.drawImage(p, 0, 0, 320, 180);
  const d = g.getImageData(0, 100, 320, 80).data;
  let [n, s, q, m] = [0, 0, 0, 0];
  for (let i = 0; i < d.length; i += 4) {
    const y = 0.3 * d[i] + 0.6 * d[i + 1] + 0.1 * d[i + 2];
    n++;
    s += y;
    q += y * y;
    m = (m * 31 + d[i + 1]) % 1000003;
  }
  return { mean: s / n, spread: Math.sqrt(Math.max(0, q / n - (s / n) ** 2)),
    sum: m };
});

describe("pictures", () => {
  beforeEach(fresh);

  test("play, and say how old they are", async () => {
    await open(daemon.url);
    const first = (await pixels()).sum;
    await until("a newer picture", async () => (await pixels()).sum !== first);
    assert.equal(await page.locator(".tile").getAttribute("data-way"),
      "webcodecs", await text(".why"));
    assert.deepEqual(await page.locator("canvas.picture").evaluate((c) =>
      [c.width, c.height]), [640, 360]);
    await until("rate, latency and losses", async () =>
      /^640×360(?: from \d+×\d+)?[\d.]+ fps\d+ ms\d+ droppedH.264$/.test(await text(".rate")));
    console.log(await page.locator(".rate").innerText());
    assert.match(await text("#fps"), /fps/);
    assert.match(await text("#time"), /^2026-06-21 12:/);
    await shot("wide");
  });

  test("show the sea state", async () => {
    await open(daemon.url);
    const seen = async (speed) => {
      const { revision } = await daemon.patch({ sea: { windSpeed: speed },
        sky: { sunElevation: 30, sunAzimuth: 180 } });
      assert.ok(revision);
      await sleep(1500);
      return pixels();
    };
    const calm = await seen(1);
    let rough = await seen(20);
    // Waves of 20 m/s have slopes, foam and shadows that 1 m/s has not.
    await until("another sea", async () => {
      rough = await pixels();
      return Math.abs(rough.spread - calm.spread) +
        Math.abs(rough.mean - calm.mean) > 3;
    });
    console.log(`brightness of the sea: calm ${calm.mean.toFixed(1)} ± ` +
      `${calm.spread.toFixed(1)}, rough ${rough.mean.toFixed(1)} ± ` +
      `${rough.spread.toFixed(1)}`);
  });

  test("fall back to Motion-JPEG and say why", async () => {
    await open(daemon.url, { init: () => {
      delete window.VideoDecoder;
      delete window.RTCPeerConnection;
    } });
    assert.equal(await page.locator(".tile").getAttribute("data-way"),
      "mjpeg");
    assert.equal(await text(".why"),
      "Motion-JPEG: this browser has no VideoDecoder");
    await until("rate, latency and losses", async () =>
      /[\d.]+ fps\d+ ms\d+ droppedMotion-JPEG$/.test(await text(".rate")));
    await shot("fallback");
  });

  test("fall back to HLS where live streams do not come through", async () => {
    await open(daemon.url, { init: () => {
      delete window.RTCPeerConnection;
      const Plain = window.WebSocket;
      window.WebSocket = class extends Plain {
        constructor(url, ...more) {
          super(String(url).replace("/live", "/nothing"), ...more);
        }
      };
      const plain = window.fetch;
      window.fetch = (at, ...more) => plain(String(at).endsWith("/mjpeg")
        ? "/v1/views/bridge/live" : at, ...more).then((answer) =>
        String(at).endsWith("/mjpeg")
          ? new Response("", { status: 403 }) : answer);
    } });
    await until("the way", async () =>
      await page.locator(".tile").getAttribute("data-way") === "hls");
    assert.equal(await text(".why"),
      "HLS: live streams are refused here (HTTP 403)");
    const at = () => page.evaluate(() =>
      document.querySelector("video.picture").currentTime);
    await until("it plays", async () => await at() > 0);
    const before = await at();
    await until("it goes on", async () => await at() > before + 1);
    await until("rate and latency", async () =>
      /[\d.]+ fps\d+ ms0 droppedHLS$/.test(await text(".rate")));
    const seen = await page.evaluate(() => {
      const video = document.querySelector("video.picture");
      const canvas = document.createElement("canvas");
      canvas.width = canvas.height = 16;
      const context = canvas.getContext("2d");
      context.drawImage(video, 0, 0, 16, 16);
      const { data } = context.getImageData(0, 0, 16, 16);
      return Math.max(...data.filter((_, i) => i % 4 !== 3));
    });
    assert.ok(seen > 20, `its brightest is ${seen}`);
    console.log(`HLS: ${await text(".rate")}`);
    await shot("hls");
  });

  test("fall back where the server has no encoder", async () => {
    const empty = folder();
    const bare = await Daemon.start([], 0, {
      GST_PLUGIN_SYSTEM_PATH_1_0: empty,
      GST_REGISTRY: path.join(empty, "none"),
    });
    await bare.patch({ views: [{ name: "bridge", width: 320, height: 180 }] });
    await open(bare.url);
    await until("the reason", async () =>
      /no H.264 encoder/.test(await text(".why")));
    await page.goto("about:blank");
    await bare.stop();
  });

  test("come and go with the views, and fill the window", async () => {
    await open(daemon.url);
    for (let i = 0; i < 5; i++) {
      await daemon.request("PUT", `/v1/views/v${i}`,
        { entity: 1, yaw: 40 * (i + 1), width: 320, height: 180 });
    }
    await pictures(6);
    await sleep(500);
    await shot("six");
    const tops = await page.locator(".tile").evaluateAll((tiles) =>
      tiles.map((t) => t.getBoundingClientRect().bottom));
    assert.ok(Math.max(...tops) < 900, "all in one window");
    for (let i = 0; i < 5; i++) {
      await daemon.request("DELETE", `/v1/views/v${i}`);
    }
    await pictures(1);
  });

  test("survive the server's restart, and say when it is gone", async () => {
    const first = await Daemon.start();
    await first.patch({ views: [{ name: "bridge", width: 320, height: 180 }] });
    await open(first.url);
    await first.stop("SIGKILL");
    await until("the message", async () =>
      /does not answer/.test(await text("#gone")));
    assert.equal(await text("#link"), "no connection");
    await shot("gone");
    const again = await Daemon.start([], first.port);
    await until("recovery", () => page.locator("#gone").isHidden());
    await until("a picture again", async () =>
      /^[\d.]+ fps$/.test(await text(".fact.fps")));
    await page.goto("about:blank");
    await again.stop();
  });
});

describe("instruments", () => {
  beforeEach(fresh);

  const bearing = () => page.locator(".glass").getAttribute("data-bearing");
  // Rows of the picture, from 0 to 1, in which the horizon's line is at a
  // column, by its colour.
  const horizon = (column) => page.locator(".glass").evaluate((glass, x) => {
    const rows = [];
    const g = glass.getContext("2d");
    const d = g.getImageData(Math.round(x * glass.width), 0, 1,
      glass.height).data;
    for (let y = 0; y < glass.height; y++) {
      const [r, , b, a] = d.subarray(4 * y, 4 * y + 4);
      if (a > 250 && r > 180 && b > 240 && y > glass.height / 4) {
        rows.push(y / glass.height);
      }
    }
    return rows.reduce((sum, y) => sum + y, 0) / rows.length;
  }, column);

  test("show where the view looks", async () => {
    await open(daemon.url);
    await until("north", async () => await bearing() === "000");
    await daemon.patch({ entities: { 1: { heading: 340 } },
      views: { bridge: { yaw: 50 } } });
    await until("its bearing", async () => await bearing() === "030");
    // Level: in the middle. Pitch 5° up with 60° across 16:9: down by
    // tan 5° / (2 tan 30° 9/16); roll 10°: apart by tan 10° of the distance.
    assert.ok(Math.abs(await horizon(0.4) - 0.5) < 0.01);
    await daemon.patch({ views: { bridge: { pitch: 5 } } });
    const down = Math.tan(5 * Math.PI / 180) /
      (2 * Math.tan(Math.PI / 6) * 9 / 16);
    await until("the horizon below", async () =>
      Math.abs(await horizon(0.4) - 0.5 - down) < 0.01);
    await daemon.patch({ views: { bridge: { pitch: 0, roll: 10 } } });
    await until("the horizon inclined", async () => {
      const apart = (await horizon(0.4) - await horizon(0.6)) * 9;
      return Math.abs(apart - Math.tan(10 * Math.PI / 180) * 0.2 * 16) < 0.1;
    });
    await shot("instruments");
  });

  test("are the picture's own geometry", async () => {
    // The drawn horizon lies where the picture's rows change most.
    await daemon.patch({ views: { bridge: { pitch: -4, roll: 6 } } });
    await open(daemon.url);
    const drawn = () => page.evaluate(() => {
      const picture = document.querySelector("canvas.picture");
      const g = picture.getContext("2d");
      const x = Math.round(0.4 * picture.width);
      const d = g.getImageData(x, 0, 1, picture.height).data;
      const mean = (from) => {
        let sum = 0;
        for (let y = from; y < from + 8; y++) {
          sum += d[4 * y];
        }
        return sum / 8;
      };
      let best = [0, 0];
      for (let y = 8; y < picture.height - 8; y++) {
        const change = Math.abs(mean(y - 8) - mean(y));
        best = change > best[0] ? [change, y] : best;
      }
      return best[1] / picture.height;
    });
    let border, line;
    // 10 m up it is 0.1° below the level: 0.003 of the height.
    await until("both are there", async () => {
      border = await drawn();
      line = await horizon(0.4);
      return Math.abs(border - line) < 0.01;
    });
    console.log(`horizon of the sea at ${border.toFixed(3)} of the height, ` +
      `the instrument's at ${line.toFixed(3)}`);
  });

  test("can be turned off, and stay so", async () => {
    await open(daemon.url);
    const opacity = () => page.locator(".glass").evaluate((node) =>
      getComputedStyle(node).opacity);
    assert.equal(await opacity(), "1");
    await page.locator("#instruments").click();
    assert.equal(await opacity(), "0");
    await page.reload();
    await pictures(1);
    assert.equal(await opacity(), "0");
    assert.equal(await page.locator("#instruments").getAttribute(
      "aria-pressed"), "false");
    await page.keyboard.press("o");
    assert.equal(await opacity(), "1");
  });
});

describe("inputs", () => {
  beforeEach(fresh);

  for (const way of ["webcodecs", "whep", "mjpeg"]) {
    test(`that are silent are named (${way})`, async () => {
      await open(`${daemon.url}/?way=${way}`);
      const note = page.locator(".stale-note");
      assert.equal(await note.isVisible(), false);
      assert.equal(await page.locator("#silent").isVisible(), false);
      await daemon.patch({ sources: { nmeaStale: true, otherStale: true } });
      await until("their names", async () => await text("#silent-names") ===
        "NMEA 0183, a client's source");
      await until("the pictures' note", async () => await note.isVisible() &&
        await note.textContent() === "Silent: NMEA 0183, a client's source");
      await shot(`stale-${way}`);
      await openSections();
      await page.locator("#mark").click();
      await until("the mark", async () => (await state()).sources.mark);
      assert.ok(await note.isVisible());
      await page.locator("#instruments").click();
      await until("pictures that say so themselves", async () =>
        !await note.isVisible());
      await shot(`marked-${way}`);
      await daemon.patch({ sources: null });
      await until("none", async () =>
        !await page.locator("#silent").isVisible());
    });
  }

  test("of a simulator: its frame is shown", async () => {
    const port = await freePort("udp");
    const led = await Daemon.start(["--cigi", `127.0.0.1:${port}`]);
    await led.patch({ views: [{ name: "bridge", entity: 1, width: 320,
      height: 180 }] });
    // IG Control of CIGI 3.3, operating; its frame number at byte 8.
    const control = Buffer.alloc(24);
    control.set([1, 24, 3, 0, 1 << 0 | 3 << 4]);
    control.writeUInt16BE(0x8000, 6);
    const socket = dgram.createSocket("udp4");
    let count = 4000;
    const beat = setInterval(() => {
      control.writeUInt32BE(count++, 8);
      socket.send(control, port, "127.0.0.1");
    }, 16);
    try {
      await open(led.url);
      const shown = async () => Number(await text("#host-frame"));
      await until("the host's frame", async () => await shown() > 4000 &&
        await shown() <= count);
      const before = await shown();
      await until("a later one", async () => await shown() > before);
      await until("in the view's facts", async () =>
        /^host frame 4\d+$/.test(await text(".fact.host")));
      await shot("host");
      clearInterval(beat);
      await until("its silence", async () =>
        await text("#silent-names") === "CIGI host");
      await page.goto("about:blank");
    } finally {
      clearInterval(beat);
      socket.close();
      await led.stop();
    }
  });
});

describe("looking around", () => {
  beforeEach(fresh);

  test("by keys", async () => {
    await open(daemon.url);
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("Shift+ArrowLeft");
    await until("yaw and pitch", async () => {
      const { yaw, pitch } = await view();
      return yaw === 9 && pitch === 2;
    });
    await page.keyboard.press("+");
    await until("zoom", async () => (await view()).fieldOfView < 60);
    await page.locator("#level").click();
    await until("level", async () => {
      const { yaw, pitch, fieldOfView } = await view();
      return yaw === 0 && pitch === 0 && fieldOfView === 60;
    });
    await page.locator("#level").blur();
    await page.keyboard.press("f");
    await until("full screen", () => page.evaluate(() =>
      document.fullscreenElement !== null ||
      document.querySelector(".tile.filled") !== null));
    await sleep(500);
    await shot("full");
    await page.keyboard.press("f");
    await until("its end", () => page.evaluate(() =>
      document.fullscreenElement === null &&
      document.querySelector(".tile.filled") === null));
    await page.keyboard.press("c");
    assert.equal(await page.locator("aside").isVisible(), false);
    await page.keyboard.press("c");
  });

  test("by the mouse", async () => {
    await open(daemon.url);
    const box = await page.locator(".glass").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    // A quarter of 60° to the left: 15° to the right.
    await page.mouse.move(x - box.width / 4, y + box.width / 60, { steps: 8 });
    await page.mouse.up();
    await until("yaw 15, pitch 1", async () => {
      const { yaw, pitch } = await view();
      return Math.abs(yaw - 15) < 0.3 && Math.abs(pitch - 1) < 0.3;
    });
    await page.mouse.dblclick(x, y);
    await until("full screen", () => page.evaluate(() =>
      document.fullscreenElement !== null ||
      document.querySelector(".tile.filled") !== null));
    await page.mouse.wheel(0, -300);
    await until("zoom", async () => (await view()).fieldOfView < 50);
  });

  test("by touch: a finger turns, two zoom", async () => {
    await open(daemon.url, { viewport: { width: 390, height: 844 },
      hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
    const box = await page.locator(".glass").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const cdp = await page.context().newCDPSession(page);
    const touch = (type, ...points) => cdp.send("Input.dispatchTouchEvent", {
      type, touchPoints: points.map(([px, py], id) =>
        ({ x: px, y: py, id })) });
    await touch("touchStart", [x, y]);
    for (let i = 1; i <= 6; i++) {
      await touch("touchMove", [x + i * box.width / 36, y]);
    }
    await touch("touchEnd");
    await until("yaw −10", async () => Math.abs((await view()).yaw + 10) < 0.5);
    await touch("touchStart", [x - 40, y], [x + 40, y]);
    for (let i = 1; i <= 5; i++) {
      await touch("touchMove", [x - 40 - 8 * i, y], [x + 40 + 8 * i, y]);
    }
    await touch("touchEnd");
    await until("twice as near", async () =>
      Math.abs((await view()).fieldOfView - 30) < 2);
  });
});

describe("everyone", () => {
  beforeEach(fresh);

  test("reads it on a phone", async () => {
    await open(daemon.url, { viewport: { width: 360, height: 780 },
      hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
    await sleep(500);
    await shot("phone");
    assert.ok(await page.evaluate(() =>
      document.documentElement.scrollWidth) <= 360);
    await openSections();
    assert.ok(await page.evaluate(() =>
      document.documentElement.scrollWidth) <= 360);
    await page.screenshot({ path: path.join(SHOTS, "phone-whole.png"),
      fullPage: true });
    const small = await page.locator("button:visible, select:visible, " +
      "summary:visible").evaluateAll((nodes) => nodes.filter((n) =>
      n.getBoundingClientRect().height < 24).map((n) => n.outerHTML));
    assert.deepEqual(small, [], "too small for a finger (WCAG 2.5.8)");
  });

  test("reads it with assistance: axe finds nothing", async () => {
    await open(daemon.url);
    await openSections();
    await page.evaluate(axe.source);
    const found = await page.evaluate(() => axe.run({ runOnly: ["wcag2a",
      "wcag2aa", "wcag21aa", "best-practice"] }));
    assert.deepEqual(found.violations.map((v) =>
      `${v.id}: ${v.help}: ${v.nodes.map((n) => n.html.slice(0, 120))}`), []);
    // The first keys: past everything to the controls; focus is seen.
    await page.locator("body").press("Tab");
    assert.equal(await page.evaluate(() => document.activeElement.className),
      "skip");
    await page.keyboard.press("Tab");
    assert.notEqual(await page.evaluate(() =>
      getComputedStyle(document.activeElement).outlineStyle), "none");
  });
});

describe("a server that asks", () => {
  let home, asking;

  before(async () => {
    home = folder();
    fs.writeFileSync(path.join(home, "token"), TOKEN, { mode: 0o600 });
    asking = await Daemon.start(["--token-file", path.join(home, "token"),
      "--http-hosts", "localhost"]);
    asking.token = TOKEN;
    await asking.patch({ views: [{ name: "bridge", entity: 1, width: 320,
      height: 180 }] });
  });

  after(async () => {
    await asking.stop();
    fs.rmSync(home, { recursive: true });
  });

  const give = async (given) => {
    await page.locator("#login-token").fill(given);
    await page.getByRole("button", { name: "Enter" }).click();
  };

  test("gets its token from a person", async () => {
    await open(asking.url, { wait: false });
    await until("the question", () => page.locator("#login").isVisible());
    assert.equal(await page.locator("#login-error").isVisible(), false);
    await shot("login");
    await give("short");
    await until("how it must be", async () =>
      /16 to 128/.test(await text("#login-error")));
    await give("wrong-but-of-the-right-length");
    await until("that it is wrong", async () =>
      /not the server's/.test(await text("#login-error")));
    await give(TOKEN);
    await pictures(1);
    assert.equal(await page.locator(".tile").getAttribute("data-way"),
      "webcodecs");
    await page.reload();
    await pictures(1);
  });

  test("gets it from the address, which then has it no more", async () => {
    await open(`${asking.url}/#token=${TOKEN}`, { init: () => {
      delete window.VideoDecoder;
      delete window.RTCPeerConnection;
    } });
    assert.ok(!page.url().includes(TOKEN));
    assert.equal(await page.locator(".tile").getAttribute("data-way"),
      "mjpeg");
  });

  test("is reached by HTTPS and WSS through nginx", async (context) => {
    try {
      execFileSync("nginx", ["-v"], { stdio: "ignore" });
    } catch {
      context.skip("nginx is not installed");
      return;
    }
    const [cert, key] = ["cert.pem", "key.pem"].map((n) => path.join(home, n));
    execFileSync("openssl", ["req", "-x509", "-newkey", "ec", "-pkeyopt",
      "ec_paramgen_curve:P-256", "-nodes", "-keyout", key, "-out", cert,
      "-days", "2", "-subj", "/CN=localhost", "-addext",
      "subjectAltName=DNS:localhost"], { stdio: "ignore" });
    const proxy = await Proxy.start(asking, cert, key);
    try {
      const curl = (...args) => execFileSync("curl", ["-s", "--cacert", cert,
        "-o", "/dev/null", "-w", "%{http_code} %{redirect_url}", ...args],
      { encoding: "utf8" }).trim();
      const bearer = ["-H", `Authorization: Bearer ${TOKEN}`];
      assert.equal(curl(`${proxy.url}/v1/state`), "401");
      assert.equal(curl(...bearer, `${proxy.url}/v1/state`), "200");
      assert.equal(curl(...bearer,
        `${proxy.url}/v1/views/bridge/frame.jpg`), "200");
      assert.equal(curl(`http://localhost:${proxy.plainPort}/x`),
        "308 https://localhost/x");
      assert.throws(() => execFileSync("curl", ["-s", proxy.url]),
        "an unknown certificate");
      await open(`${proxy.url}/#token=${TOKEN}`, { ignoreHTTPSErrors: true });
      assert.equal(await page.locator(".tile").getAttribute("data-way"),
        "webcodecs", await text(".why"));
      await slide("wind-speed", 12.5);
      await until("the wind, through the proxy", async () =>
        (await asking.state()).sea.windSpeed === 12.5);
      await shot("https");
      await page.goto("about:blank");
      assert.equal(proxy.errors(), "");
    } finally {
      await proxy.stop();
    }
  });
});
