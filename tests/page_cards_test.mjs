#!/usr/bin/env node
// The page's sea-state card, presets, files to save, time, what a browser-only
// user could not get out of, and the introduction: on a phone, a laptop, a wall.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { beforeEach, describe, test } from "node:test";

import { at, browser, clean, daemon, fresh, inside, only, open, openSections,
  page, pictures, ready, saved, shot, SHOTS, SIZES, slide, state, text }
  from "./page.mjs";
import { Daemon, folder, until } from "./pelagos_daemon.mjs";

const MOST_KB = 600;

const choose = (id, label) => page.locator(`#${id}`).selectOption({ label });
const note = () => text("#preset-note");

describe("the sea-state card", () => {
  beforeEach(fresh);

  for (const size of Object.keys(SIZES)) {
    test(`says what the sea is (${size})`, async () => {
      await daemon.patch({ sea: { windSpeed: 12, synthesiser: "TROCHOIDS",
        swell: [{ height: 2, period: 12, direction: 210 }] } });
      await open(daemon.url, at(size));
      await ready();
      const asked = () => page.evaluate(() => performance.getEntriesByType(
        "resource").map((r) => new URL(r.name).pathname));
      assert.ok(!(await asked()).includes("/uplot.js"), "not before");
      await page.locator("#sea-state > summary").click();
      await until("uPlot", async () => (await asked()).includes("/uplot.js"));
      await until("its figures", async () =>
        await text("#card-hs") !== "–");
      const sea = await daemon.request("GET", "/v1/spectrum");
      assert.equal(await text("#card-hs"),
        `${sea.spectrum.significantHeight.toFixed(2)} m`);
      assert.equal(await text("#card-tp"), `${sea.peakPeriod.toFixed(1)} s`);
      assert.equal(await text("#card-beaufort"), "6, strong breeze");
      assert.equal(await text("#card-swell"), "2.0 m, 12 s from 210°");
      assert.match(await text("#card-age"), /^1\.2\d, /);
      assert.match(await text("#card-foam"), /^1\.\d %$/);
      assert.equal(await page.locator(".plot canvas").count(), 2);
      // Colours of the rose: some of the swell's, from south-west.
      await until("the rose", () => page.locator("#wave-rose").evaluate((c) => {
        const g = c.getContext("2d");
        const paint = (x, y) => g.getImageData(x * c.width, y * c.height, 1, 1)
          .data[3];
        return paint(0.455, 0.58) > 0 && paint(0.75, 0.25) === 0;
      }));
      await until("heights", async () => /[1-9]\d? seconds: from −?-?[\d.]+ to/
        .test(await page.locator("#plot-height").getAttribute("aria-label")));
      assert.match(await text("#card-height"), /^[+−]\d\.\d\d m$/);
      await inside();
      await page.locator("#sea-state").scrollIntoViewIfNeeded();
      await shot(`card-${size}`);
      // The state of now, not of before.
      await daemon.patch({ sea: { windSpeed: 2, swell: [] } });
      await until("another sea", async () => await text("#card-beaufort") ===
        "2, light breeze" && await text("#card-swell") === "none");
      // Closed, it asks for nothing.
      await page.locator("#sea-state > summary").click();
      await until("it is closed", () => page.locator("#sea-state").evaluate(
        (d) => !d.open));
      const asks = [];
      page.on("request", (request) => asks.push(new URL(request.url()).pathname));
      await until("three states", () => asks.filter((a) => a === "/v1/state")
        .length >= 3);
      assert.deepEqual(asks.slice(3).filter((a) => /surface|spectrum/.test(a)),
        []);
    });
  }

  test("gives the height that the server gives", async () => {
    await daemon.patch({ clock: { mode: "STEPPED", time: 100 } });
    await open(daemon.url);
    await ready();
    await page.locator("#sea-state > summary").click();
    await until("100 s", async () => /the last [1-9]\d* seconds/.test(
      await page.locator("#plot-height").getAttribute("aria-label")));
    const { points } = await daemon.request("POST", "/v1/surface",
      { time: 100, points: [[0, 0]] });
    assert.equal((await text("#card-height")).replace("−", "-"),
      `${points[0].height < 0 ? "" : "+"}${points[0].height.toFixed(2)} m`);
  });
});

describe("presets", () => {
  beforeEach(async () => {
    await fresh();
    await open(daemon.url, at("laptop"));
    await ready();
  });

  test("set sea, water, weather and time of day", async () => {
    for (const [beaufort, label] of [[0, "0 calm"], [6, "6 strong breeze"],
      [11, "11 violent storm"]]) {
      await choose("preset-sea", label);
      await until(label, async () => (await daemon.request("GET",
        "/v1/spectrum")).beaufort === beaufort);
    }
    assert.equal(await page.locator("#preset-sea option").count(), 13);
    await choose("preset-water", "Baltic");
    await until("a named water", async () =>
      (await state()).water.named === "BALTIC");
    await choose("preset-water", "3C");
    await until("a type instead", async () => {
      const { water } = await state();
      return water.jerlov === "C3" && water.named === undefined;
    });
    const sky = async () => (await state()).sky;
    await choose("preset-weather", "Thunder");
    await until("lightning", async () => (await sky()).lightning > 0);
    await choose("preset-weather", "Fog");
    await until("fog alone", async () => {
      const now = await sky();
      return now.fog?.length === 1 && now.lightning === 0 && now.rain === 0;
    });
    await choose("preset-weather", "Clear");
    await until("none", async () => (await sky()).fog === undefined);
    await choose("preset-time", "Moonlit night");
    await until("the Moon", async () => (await sky()).moonPhase === 1);
    await choose("preset-time", "Noon");
    await until("the Sun", async () => {
      const now = await sky();
      return now.sunElevation > 50 && now.moonElevation === undefined;
    });
    await shot("presets");
  });

  test("of one's own are saved, made again, deleted", async () => {
    await daemon.patch({ sea: { windSpeed: 17, swell: [{ height: 2 }] },
      sky: { sunElevation: 5, sunAzimuth: 90 } });
    await until("it is known", async () =>
      await page.locator("#wind-speed").inputValue() === "17");
    await page.locator("#preset-title").fill("Großer Sturm, früh");
    await page.locator("#preset-title").press("Enter");
    await until("saved", async () => /saved/.test(await note()));
    const [preset] = (await state()).presets;
    assert.equal(preset.name, "Grosser-Sturm-fruh");
    assert.equal(preset.title, "Großer Sturm, früh");
    await daemon.patch({ sea: { windSpeed: 2, swell: [] }, sky:
      { sunElevation: null, sunAzimuth: null }, water: { jerlov: "III" } });
    await page.getByRole("button", { name: "Apply the chosen" }).click();
    await until("as it was", async () => {
      const now = await state();
      return now.sea.windSpeed === 17 && now.sea.swell.length === 1 &&
        now.sky.sunElevation === 5 && now.water.jerlov === undefined;
    });
    await page.reload();
    await ready();
    await until("it is there for others", async () => await page.locator(
      "#preset-own option").textContent() === "Großer Sturm, früh");
    await shot("own-preset");
    await page.getByRole("button", { name: "Delete the chosen" }).click();
    await until("none", async () => (await state()).presets === undefined &&
      !await page.locator("#preset-own-row").isVisible());
    // One too many is refused in words.
    await daemon.patch({ presets: Object.fromEntries(Array.from({ length: 32 },
      (_, i) => [`p${i}`, { patch: "{}" }])) });
    await page.locator("#preset-title").fill("more");
    await page.getByRole("button", { name: "Save sea" }).click();
    await until("why", async () => /at most 32/.test(await note()));
  });
});

describe("files to save", () => {
  beforeEach(async () => {
    await fresh();
    await open(daemon.url, at("laptop"));
    await ready();
    await only("keep-note");
  });

  test("are pictures of the chosen view", async () => {
    const starts = { jpg: "ffd8ff", png: "89504e47", exr: "762f3101" };
    for (const [ending, name] of [["jpg", "JPEG"], ["png", "PNG"],
      ["exr", "EXR"]]) {
      const file = await saved(() => page.getByRole("button",
        { name: `Save a picture as ${name}` }).click());
      assert.match(path.basename(file), new RegExp(
        `^bridge-2026-06-21T\\d{6}Z\\.${ending}$`));
      const bytes = fs.readFileSync(file);
      assert.ok(bytes.toString("hex", 0, 4).startsWith(starts[ending]), name);
      assert.ok(bytes.length > 1000);
    }
    await shot("saved");
  });

  test("are clips that play", async () => {
    await daemon.patch({ sea: { synthesiser: "TROCHOIDS" },
      views: { bridge: { width: 320, height: 180 } } });
    await page.locator("#clip-seconds").fill("3");
    const file = await saved(() => page.getByRole("button",
      { name: "Record the next" }).click());
    assert.match(path.basename(file), /^bridge-.*\.mp4$/);
    const probe = JSON.parse(execFileSync("ffprobe", ["-v", "error",
      "-count_frames", "-show_streams", "-show_format", "-of", "json", file]));
    const [stream] = probe.streams;
    console.log(`clip: ${stream.nb_read_frames} pictures, ${stream.duration} s, ${
      probe.format.size} bytes`);
    assert.equal(stream.codec_name, "h264");
    assert.deepEqual([stream.width, stream.height], [320, 180]);
    assert.equal(stream.nb_read_frames, stream.nb_frames);
    assert.ok(Number(stream.nb_frames) >= 2);
    assert.ok(Number(stream.duration) >= 2.9);
    execFileSync("ffmpeg", ["-v", "error", "-xerror", "-i", file, "-f", "null",
      "-"]); // decodes to the end
    // And in a browser, where the page's policy is not.
    const blank = await page.context().newPage();
    assert.equal(await blank.evaluate((data) => new Promise((resolve) => {
      const video = document.createElement("video");
      video.onloadeddata = () => resolve(video.videoWidth);
      video.onerror = () => resolve(video.error.message);
      video.src = `data:video/mp4;base64,${data}`;
    }), fs.readFileSync(file, "base64")), 320);
    await page.locator("#clip-seconds").fill("0");
    await page.getByRole("button", { name: "Record the next" }).click();
    await until("why not", async () => /1 to 600/.test(await text("#keep-note")));
  });
});

describe("time", () => {
  beforeEach(async () => {
    await fresh();
    await open(daemon.url, at("laptop"));
    await ready();
    await only("clock");
  });
  const utcOf = async () => {
    const { clock } = await state();
    return Date.parse(clock.utc) + 1000 * clock.time;
  };

  test("typed as UTC is what it is", async () => {
    await daemon.patch({ clock: { mode: "STEPPED", time: 945.5 } });
    await until("the page knows", async () =>
      /12:15:45/.test(await text("#time")));
    await page.locator("#utc").fill("2026-06-21T23:30");
    // Held while it is typed: nothing is set yet, nothing shown anew.
    await daemon.patch({ clock: { time: 950 } });
    await until("the page knows", async () =>
      /12:15:50/.test(await text("#time")));
    assert.equal(await page.locator("#utc").inputValue(),
      "2026-06-21T23:30");
    await page.locator("#utc").press("Enter");
    await until("23:30", async () => await utcOf() ===
      Date.parse("2026-06-21T23:30:00Z"));
    await until("the display", async () =>
      /2026-06-21 23:30:00 UTC/.test(await text("#time")));
    assert.equal((await state()).clock.time, 950);
    await shot("utc");
  });

  test("is paused, goes on, and takes steps", async () => {
    const mode = async () => (await state()).clock.mode;
    await page.getByRole("button", { name: "Pause simulated" }).click();
    await until("a pause", async () => await mode() === "STEPPED");
    const before = (await state()).clock.time;
    await page.getByLabel("Length of a step").selectOption({ label: "10 min" });
    await page.getByRole("button", { name: "Advance time" }).click();
    await until("ten minutes", async () =>
      Math.abs((await state()).clock.time - before - 600) < 1e-6);
    await page.getByRole("button", { name: "go on" }).click();
    await until("it goes on", async () => await mode() === "FREE");
  });

  test("of day moves the Sun, and says when it rises", async () => {
    await daemon.patch({ sky: { sunElevation: 30, sunAzimuth: 200 } });
    await until("the day's events", async () => /Sun rises 03:15, sets 20:06/
      .test(await text("#day-list")));
    assert.match(await text("#day-list"), /Moon rises 11:1\d.*% lit/);
    await until("a Sun set by hand", async () =>
      /set by hand, 30.0°/.test(await text("#day-list")));
    await shot("day");
    await slide("day", 20 * 3600);
    await until("20:00", async () => {
      const off = await utcOf() - Date.parse("2026-06-21T20:00:00Z");
      return off > -60000 && off < 120000;
    });
    await until("the Sun low", async () => {
      const { sky } = await state();
      return sky.sunElevation === undefined &&
        /Sun .*now -?[01]\.\d°/.test(await text("#day-list"));
    });
    await shot("evening");
  });
});

describe("what nobody got out of", () => {
  beforeEach(fresh);

  test("no view: one is offered", async () => {
    await daemon.patch({ views: null });
    await open(daemon.url, { wait: false, ...at("phone") });
    await ready();
    await until("the offer", () => page.locator("#add-view").isVisible());
    await clean("no views");
    await shot("no-views");
    await page.locator("#add-view").click();
    await pictures(1);
    assert.equal((await state()).views[0].entity, 1);
    assert.equal(await page.locator("#no-views").isVisible(), false);
  });

  test("a silent input is cleared", async () => {
    await daemon.patch({ sources: { nmeaStale: true, mark: true } });
    await open(daemon.url, at("laptop"));
    await until("its name", async () =>
      await text("#silent-names") === "NMEA 0183");
    await clean("silent");
    await page.locator("#silent-clear").click();
    await until("none", async () => !await page.locator("#silent").isVisible());
    await until("the server's word", async () => {
      const { sources } = await state();
      return sources.nmeaStale === false && sources.mark === true;
    });
  });

  test("lists are in words, and offer what can be chosen", async () => {
    await open(daemon.url, at("laptop"));
    await openSections();
    const bare = await page.locator("select option").evaluateAll((options) =>
      options.map((o) => o.textContent).filter((t) =>
        /_|^[a-z]/.test(t) || (/^[A-Z]{3,}$/.test(t) &&
          !["JONSWAP", "TMA", "III", "RIB", "USV"].includes(t))));
    assert.deepEqual(bare.filter((t) => !/^(bridge|ownship)$/.test(t)), []);
    assert.deepEqual(await page.locator("#bottom option").allTextContents(),
      ["Black", "Sand", "Mud", "Rock", "Coral"]);
    const spectra = () => page.locator("#spectrum option").evaluateAll((o) =>
      o.map((n) => n.value));
    assert.ok(!(await spectra()).includes("MEASURED"));
    await page.locator("#spectrum").selectOption("TMA");
    await until("its depth", async () => (await state()).sea.depth === 20 &&
      await page.locator("#sea-depth").isVisible());
    const buoys = await Daemon.start(["--spectra", folder()]);
    try {
      await page.goto(buoys.url);
      await openSections();
      assert.ok((await spectra()).includes("MEASURED"));
      await page.locator("#spectrum").selectOption("MEASURED");
      await until("the station", () => page.locator("#measured").isVisible());
      await page.locator("#measured").fill("42001");
      await page.locator("#measured").press("Enter");
      await until("that there is none", async () => /42001/.test(
        await text("#measured-error")));
      const polls = [];
      page.on("response", (r) => polls.push(new URL(r.url()).pathname));
      await until("the state twice", () => polls.filter((p) =>
        p === "/v1/state").length >= 2);
      assert.match(await text("#measured-error"), /42001/, "it stays");
      await page.locator("#spectrum").selectOption("JONSWAP");
      await until("another", () => page.locator("#measured").isHidden());
      await page.goto("about:blank");
    } finally {
      await buoys.stop();
    }
  });
});

describe("the introduction", () => {
  beforeEach(fresh);

  for (const size of Object.keys(SIZES)) {
    test(`is given once (${size})`, async () => {
      await open(daemon.url, { tour: true, ...at(size) });
      const tour = page.locator("#tour");
      await until("it", () => tour.isVisible());
      assert.match(await tour.textContent(), /1 of 3/);
      await clean("introduction");
      await shot(`tour-${size}`);
      await page.getByRole("button", { name: "Next" }).focus();
      await page.keyboard.press("Enter");
      await page.keyboard.press("Enter");
      assert.match(await tour.textContent(), /3 of 3.*Put ships/s);
      await page.keyboard.press("Enter");
      assert.equal(await tour.count(), 0);
      await page.reload();
      await ready();
      await pictures(1);
      assert.equal(await tour.count(), 0);
      // Escape from anywhere ends it too; it can be asked for.
      await page.locator("#about-open").click();
      await until("the version", async () => /Version \d/.test(
        await text("#about-version")));
      assert.match(await text("#about-licence"), /MIT License|Permission/);
      await clean("about");
      await shot(`about-${size}`);
      await page.locator("#about-tour").click();
      await until("again", () => tour.isVisible());
      await page.keyboard.press("Escape");
      assert.equal(await tour.count(), 0);
    });
  }

  test("with all sections open, axe finds nothing", async () => {
    await open(daemon.url, at("laptop"));
    await openSections();
    await daemon.patch({ presets: { a: { patch: "{}", title: "A" } } });
    await until("the card", async () => await text("#card-hs") !== "–");
    await until("the day", async () => /Sun/.test(await text("#day-list")));
    await until("the preset", () => page.locator("#preset-own").isVisible());
    await clean("all sections");
  });
});

test("weighs little, and shows a picture soon", async () => {
  await fresh();
  const context = await browser.newContext(at("laptop"));
  const visitor = await context.newPage();
  const sizes = new Map();
  visitor.on("response", async (response) => {
    const { pathname } = new URL(response.url());
    if (!pathname.startsWith("/v1/")) {
      sizes.set(pathname, (await response.body().catch(() => "")).length);
    }
  });
  const began = performance.now();
  await visitor.goto(daemon.url);
  await visitor.waitForSelector(".tile:has(.tile-note[hidden])",
    { state: "attached" });
  const first = performance.now() - began;
  await visitor.waitForSelector("#panel:not(.waiting)");
  await visitor.waitForSelector("#tour");
  const sum = () => [...sizes.values()].reduce((a, b) => a + b, 0) / 1000;
  const light = sum();
  assert.ok(![...sizes.keys()].includes("/uplot.js"));
  await visitor.locator("#sea-state > summary").click();
  await visitor.waitForSelector(".plot canvas");
  console.log(`first visit: ${light.toFixed(0)} kB in ${sizes.size} files, ${
    sum().toFixed(0)} kB with the sea-state card; first picture after ${
    first.toFixed(0)} ms`);
  await context.close();
  assert.ok(sum() <= MOST_KB, `${sum()} kB`);
});
