#!/usr/bin/env node
// The page's views: added, named, ordered, removed; laid out by where they
// look; addresses for walls; what nobody sees is not streamed. And the plan's
// depths and measures.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, before, beforeEach, describe, test } from "node:test";

import { daemon, fresh, open, openSections, page, pictures, shot, state, text }
  from "./page.mjs";
import { Daemon, SANITIZED, folder, until } from "./pelagos_daemon.mjs";

const names = () => page.locator(".tile").evaluateAll((all) =>
  all.map((n) => n.dataset.view));
const onServer = async () => (await state()).views.map((v) => v.name);
const running = () => page.evaluate(() => [...document.querySelectorAll(
  ".tile")].filter((n) => n.tile.live.running).map((n) => n.dataset.view));
const small = (name, yaw) => ({ name, entity: 1, width: 160, height: 90, yaw });
const WALL = [small("bow", 0), small("stbd", 50), small("quarter", 110),
  small("port", -50), small("port2", -110)];

describe("views", () => {
  beforeEach(async () => {
    await fresh();
    await daemon.patch({ views: WALL });
  });

  test("lie as they look, or in their order", async () => {
    await open(daemon.url, { wait: false, viewport: { width: 1440,
      height: 900 } });
    await until("five of them", async () => (await names()).length === 5);
    assert.deepEqual(await names(), ["port2", "port", "bow", "stbd",
      "quarter"]);
    await openSections();
    await page.locator("#page-layout").selectOption("order");
    assert.deepEqual(await names(), WALL.map((view) => view.name));
    await shot("walls-order");
  });

  test("two of them are side by side", async () => {
    await daemon.patch({ views: WALL.slice(0, 2) });
    for (const viewport of [{ width: 1440, height: 900 },
      { width: 2560, height: 1440 }]) {
      await page?.context().close();
      await open(daemon.url, { wait: false, viewport });
      await until("both", async () => (await names()).length === 2);
      await until("in one row, across the whole width", async () => {
        const [a, b] = await page.locator(".tile").evaluateAll((all) =>
          all.map((n) => n.getBoundingClientRect().toJSON()));
        const main = await page.locator("main").boundingBox();
        return Math.abs(a.top - b.top) < 1 && b.left > a.right &&
          a.width + b.width > 0.95 * main.width;
      });
    }
  });

  test("are added, named, ordered and removed", async () => {
    await daemon.patch({ views: WALL.slice(0, 2) });
    await open(daemon.url, { wait: false });
    await openSections();
    await page.getByRole("button", { name: "Add a view beside" }).click();
    await until("a third", async () =>
      (await onServer()).join() === "bow,stbd,view3");
    assert.equal((await state()).views[2].yaw, 60);
    const row = (name) => page.getByLabel(`Name of view ${name}`, {
      exact: true });
    await row("view3").fill("lookout");
    await row("view3").press("Enter");
    await until("its name", async () =>
      (await onServer()).join() === "bow,stbd,lookout");
    await until("the row", () => row("lookout").count());
    await page.getByRole("button", { name: "Earlier: lookout" }).click();
    await until("its place", async () =>
      (await onServer()).join() === "bow,lookout,stbd");
    await until("on the page", async () =>
      (await names()).join() === "bow,lookout,stbd");
    await row("lookout").fill("a/b");
    await row("lookout").press("Enter");
    await until("why not", async () =>
      /name/.test(await text("#viewlist .plan-note")));
    await shot("walls-views");
    for (let i = 0; i < 2; i++) {
      await page.getByRole("button", { name: "Remove bow" }).click();
    }
    await until("it is gone", async () =>
      (await onServer()).join() === "lookout,stbd");
  });

  test("that nobody sees are not streamed", async () => {
    await open(daemon.url, { wait: false });
    await until("all five", async () => (await running()).length === 5);
    await page.locator(".tile[data-view=port]").focus();
    await page.keyboard.press("f");
    await until("only that of the full screen", async () =>
      (await running()).join() === "port");
    await until("one stream of the server's", async () =>
      await daemon.metric("pelagos_frames_subscriptions") === 1);
    await page.keyboard.press("f");
    await until("all again", async () => (await running()).length === 5);
    await page.setViewportSize({ width: 390, height: 600 });
    await until("what is in sight", async () => {
      const list = await running();
      return list.length > 0 && list.length < 5;
    });
  });
});

describe("addresses", () => {
  beforeEach(async () => {
    await fresh();
    await daemon.patch({ views: WALL });
  });

  test("name one view, without anything else", async () => {
    await open(`${daemon.url}/?view=port&hud=0`, { wait: false });
    await until("it alone", async () => (await names()).join() === "port" &&
      (await running()).join() === "port");
    const box = await page.locator(".tile").boundingBox();
    assert.deepEqual([box.x, box.y, box.width, box.height], [0, 0, 1360, 900]);
    assert.equal(await page.locator("aside").isVisible(), false);
    assert.equal(await page.locator(".glass").evaluate((n) =>
      getComputedStyle(n).opacity), "0");
    await shot("walls-one");
    // What an address says is not kept for other pages.
    assert.equal(await page.evaluate(() =>
      localStorage.getItem("pelagos-instruments")), null);
  });

  test("name several in their order, and say which are not there", async () => {
    await open(`${daemon.url}/?views=stbd,bow,keel&panel=0&theme=light`,
      { wait: false });
    await until("two", async () => (await names()).join() === "stbd,bow");
    assert.match(await text("#no-such"),
      /asks for keel; the server has bow, stbd/);
    assert.equal(await page.evaluate(() =>
      document.documentElement.dataset.theme), "light");
  });

  test("make a wall: one row across the window", async () => {
    await open(`${daemon.url}/?layout=wall&hud=0`, { wait: false,
      viewport: { width: 2560, height: 1440 } });
    await until("five from port to starboard", async () =>
      (await names()).join() === "port2,port,bow,stbd,quarter");
    const boxes = await page.locator(".tile").evaluateAll((all) =>
      all.map((n) => n.getBoundingClientRect().toJSON()));
    boxes.forEach((box, i) => {
      assert.ok(Math.abs(box.left - 512 * i) < 1 && box.top === 0 &&
        Math.abs(box.width - 512) < 1, JSON.stringify(box));
    });
    assert.equal(await page.locator(".bar").isVisible(), false);
    await shot("walls-wall");
  });

  // Pictures of two views as they are shown: the frame's number, the view, by
  // how much after its time and after which refresh, and by how much before its
  // time it was there, ms. Until 30 frames are shown in both, a minute at most.
  const shown = () => page.evaluate(async () => {
    const { Video, noVideo } = await import("/video.js");
    const all = [];
    const seen = new Map();
    const there = new Map();
    const videos = ["port", "stbd"].map((name) => {
      const video = new Video(name, document.createElement("canvas"), (one) => {
        if (one && video.server.known) {
          const { tookMs } = video.server.answers.reduce((best, answer) =>
            answer.tookMs < best.tookMs ? answer : best);
          all.push({ number: one.number, name, clockMs: tookMs / 2,
            lateMs: video.server.nowMs - one.presentMs,
            refresh: document.timeline.currentTime,
            earlyMs: there.get(name + one.number) });
          seen.set(one.number, (seen.get(one.number) ?? 0) + 1);
        }
      }, (why) => all.push({ why }));
      const show = video.show.bind(video);
      video.show = (frame) => {
        const head = video.heads.get(frame.timestamp);
        there.set(name + Number(head.number),
          head.presentMs - video.server.nowMs);
        show(frame);
      };
      video.start();
      return video;
    });
    const begun = performance.now();
    while ([...seen.values()].filter((times) => times === 2).length < 30 &&
        performance.now() - begun < 60000) {
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    videos.forEach((video) => video.stop());
    return noVideo || all;
  });

  test("hold pictures until their time", async () => {
    await open(`${daemon.url}/?view=bow&hud=0`, { wait: false });
    const before = await shown();
    // A sanitizer's pictures come when their time is long past.
    assert.ok(SANITIZED || before.some(({ lateMs }) => lateMs < -12),
      `as they come: ${JSON.stringify(before)}`);
    await open(`${daemon.url}/?view=bow&hud=0&step=1`, { wait: false });
    const held = await shown();
    // Half a refresh early at most, beside what the clock may be wrong by.
    assert.deepEqual(held.filter(({ lateMs, clockMs }) =>
      !(lateMs > -9 - clockMs)), []);
    const of = (name) => new Map(held.filter((one) => one.name === name)
      .map((one) => [one.number, one]));
    const [port, stbd] = [of("port"), of("stbd")];
    const both = [...port.keys()].filter((number) => stbd.has(number))
      .map((number) => [port.get(number), stbd.get(number)]);
    assert.ok(both.length > 20, `${both.length} in both`);
    // In one refresh, where both were there a refresh before their time.
    const inTime = both.filter((two) =>
      two.every(({ earlyMs }) => earlyMs > 17));
    const together = inTime.filter(([one, two]) =>
      one.refresh === two.refresh);
    const middle = (list) => list.map(({ lateMs }) => lateMs)
      .sort((a, b) => a - b)[list.length >> 1].toFixed(1);
    console.log(`shown ${middle(before)} ms after its time as it comes, ` +
      `${middle(held)} held; ${both.length} of ${port.size} in both, ` +
      `${inTime.length} in time, ${together.length} in one refresh`);
    assert.equal(together.length, inTime.length, JSON.stringify(inTime));
    assert.ok(SANITIZED || inTime.length > 0, "none in time");
  });

  test("are made by the page, and never hold the token", async () => {
    await open(`${daemon.url}/#token=0123456789abcdef0123456789abcdef`,
      { wait: false });
    await openSections();
    await page.keyboard.press("o");
    await page.getByRole("button", { name: "Copy an address of the page" })
      .click();
    assert.equal(await text(".address"), `${daemon.url}/?hud=0`);
    await page.locator(".tile[data-view=stbd]").focus();
    await page.getByRole("button", { name: "Copy an address of the chosen" })
      .click();
    assert.equal(await text(".address"), `${daemon.url}/?view=stbd&hud=0`);
    await page.getByRole("button", { name: "Copy an address of all" }).click();
    assert.equal(await text(".address"), `${daemon.url}/?layout=wall&hud=0`);
    assert.ok(!(await page.content()).includes("0123456789abcdef"));
  });
});

describe("the plan", () => {
  let home, bay;

  // A shore in the north, 12 m of water in the south.
  before(async () => {
    home = folder();
    const rows = Array.from({ length: 60 }, (_, j) => Array(60).fill(
      (j < 24 ? 4 : -12).toFixed(1)).join(" "));
    // A mole of 22 m, with a light at its end, in 14 m of water.
    const mole = Array.from({ length: 400 }, (_, j) => Array.from(
      { length: 400 }, (__, i) => j >= 180 && j < 182 && i >= 100 && i < 190
        ? 3 : -14).join(" "));
    fs.writeFileSync(path.join(home, "mole.asc"), "ncols 400\nnrows 400\n" +
      "xllcorner 5.18\nyllcorner 52.58\ncellsize 0.0001\n" +
      `${mole.join("\n")}\n`);
    fs.writeFileSync(path.join(home, "bay.asc"), "ncols 60\nnrows 60\n" +
      "xllcorner 5.17\nyllcorner 52.57\ncellsize 0.001\n" +
      `NODATA_value -9999\n${rows.join("\n")}\n`);
    bay = await Daemon.start(["--bathymetry", home]);
  });

  after(async () => {
    await bay.stop();
    fs.rmSync(home, { recursive: true });
  });

  const ink = (x, y) => page.locator("#plan").evaluate((canvas, [px, py]) => {
    const ratio = canvas.width / canvas.clientWidth;
    return [...canvas.getContext("2d").getImageData(Math.round(px * ratio),
      Math.round(py * ratio), 1, 1).data.slice(0, 3)];
  }, [x, y]);

  test("shows depth and coast of the seabed's file", async () => {
    await bay.patch({ seabed: { file: "bay.asc" }, views: null,
      origin: { latitude: 52.6, longitude: 5.2 },
      entities: [{ id: 1, name: "ownship", latitude: 52.6,
        longitude: 5.2 }] });
    await open(`${bay.url}/?plan=1`, { wait: false });
    await until("the plan", () => page.locator("#plan-large #plan")
      .isVisible());
    const { width, height } = await page.locator("#plan").boundingBox();
    await page.locator("#plan").focus();
    await until("11 metres a pixel", async () => {
      await page.keyboard.press("-");
      return Number(await page.locator("#plan").getAttribute("data-scale")) >
        11;
    });
    await until("its depths", async () => Number(await page.locator("#plan")
      .getAttribute("data-depths")) > 100);
    await shot("plan-depths");
    await until("land in the north, water in the south", async () => {
      const [north, south] = [await ink(width * 0.42, height * 0.12),
        await ink(width * 0.42, height * 0.85)];
      return north[0] > north[2] && south[2] > south[0];
    });
    await shot("plan-depths");
  });

  test("keeps a mole at any scale, and shows a light as one", async () => {
    await bay.patch({ seabed: { file: "mole.asc" }, views: null,
      origin: { latitude: 52.6, longitude: 5.2 }, entities: [
        { id: 1, name: "ownship", latitude: 52.6, longitude: 5.2 },
        { id: 2, name: "head", latitude: 52.6019, longitude: 5.1985,
          lights: "ON", light: { character: "Oc G 4s" } }] });
    await open(`${bay.url}/?plan=1`, { wait: false });
    await until("the plan", () => page.locator("#plan-large #plan")
      .isVisible());
    const plan = page.locator("#plan");
    await plan.focus();
    const number = async (name) => Number(await plan.getAttribute(name));
    for (const scale of [1.5, 6, 25]) {
      await until(`${scale} metres a pixel`, async () => {
        await page.keyboard.press(await number("data-scale") < scale ? "-"
          : "+");
        const now = await number("data-scale");
        return now > scale * 0.7 && now < scale * 1.4;
      });
      await until(`the mole at ${scale}`, async () =>
        await number("data-land") > 0 && await number("data-asked") ===
          await number("data-scale"));
      await shot(`plan-mole-${scale}`);
    }
    // Green where the light's flare is, and no hull of a ship.
    await until("1.5 metres a pixel", async () => {
      await page.keyboard.press("+");
      return await number("data-scale") < 1.5;
    });
    await until("a green flare", async () => {
      const { width, height } = await plan.boundingBox();
      const scale = await number("data-scale");
      const [x, y] = [width / 2 - 101.6 / scale, height / 2 - 211.4 / scale];
      const [r, g, b] = await ink(x + 6, y + 6);
      return g > 150 && g > r + 60 && g > b + 40;
    });
    await shot("plan-light");
  });

  test("measures range and bearing, by pointer and by keys", async () => {
    await fresh();
    await daemon.patch({ views: null });
    await open(daemon.url, { wait: false });
    await openSections();
    const plan = page.locator("#plan");
    await plan.scrollIntoViewIfNeeded();
    await page.locator("#plan-measure").click();
    await plan.scrollIntoViewIfNeeded();
    const box = await plan.boundingBox();
    const scale = Number(await plan.getAttribute("data-scale"));
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y - 60, { steps: 4 });
    await page.mouse.up();
    const far = 60 * Math.SQRT2 * scale;
    const measured = async () => await plan.getAttribute("data-measured") ?? "";
    // From a ship, which is near the pixel.
    await until("45 degrees", async () => /04[456]°/.test(await measured()));
    assert.ok(Math.abs(parseFloat(await measured()) - far) < 6,
      `${await measured()}, ${far} m`);
    assert.match(await text("#plan-note"), /Measured: .*nmi · 04[456]°/);
    await shot("plan-measured");
    await plan.focus();
    await page.keyboard.press("m");
    for (let i = 0; i < 4; i++) {
      await page.keyboard.press("ArrowRight");
    }
    await page.keyboard.press("m");
    await until("to the east", async () => /0(89|90|91)°/.test(
      await measured()));
    assert.ok(Math.abs(parseFloat(await measured()) - 96 * scale) < 6,
      await measured());
    await page.keyboard.press("Escape");
  });
});
