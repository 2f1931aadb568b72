#!/usr/bin/env node
// Recordings and the debrief on the page: begun and ended, listed, led through
// beside the live pictures.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import fs from "node:fs";
import { after, before, test } from "node:test";

import { open, openSections, page, shot, text } from "./page.mjs";
import { Daemon, folder, until } from "./pelagos_daemon.mjs";

let home, recorder;

before(async () => {
  home = folder();
  recorder = await Daemon.start(["--recordings", home]);
  await recorder.patch({ views: [
    { name: "bridge", entity: 1, width: 160, height: 90 },
    { name: "stern", entity: 1, width: 160, height: 90, yaw: 180 }],
  clock: { mode: "STEPPED" } });
});

after(async () => {
  await recorder.stop();
  fs.rmSync(home, { recursive: true });
});

const step = (until_s) => recorder.request("POST", "/v1/clock/step",
  { until: until_s });
const status = () => recorder.request("GET", "/v1/debrief");
const thens = () => page.locator(".then .tile:has(.tile-note[hidden])")
  .evaluateAll((all) => all.map((n) => n.dataset.then));

for (const [width, height] of [[1440, 900], [390, 844], [2560, 1440]]) {
  test(`a recording is made and gone through, ${width}×${height}`, async () => {
    const name = `night-${width}`;
    const from = (await recorder.state()).clock.time;
    await open(recorder.url, { wait: false, viewport: { width, height } });
    await openSections();
    await page.locator("#recording-name").fill(name);
    await page.locator("#record").click();
    await until("that it records", async () => await text("#record") ===
      "Stop recording");
    for (let i = 1; i <= 4; i++) {
      await recorder.patch({ sea: { windSpeed: 2 * i } });
      await step(from + 5 * i);
    }
    await page.locator("#record").click();
    await until("its row", async () => (await page.locator(".recording-rows")
      .textContent()).includes(`${name}.pelog`));
    await page.getByRole("button", { name: `Debrief of ${name}.pelog` })
      .click();
    await until("then, beside now", async () =>
      (await thens()).join() === "bridge");
    if (width > 992) {
      const [now, then] = [await page.locator("#views").boundingBox(),
        await page.locator("#then").boundingBox()];
      assert.ok(then.x >= now.x + now.width && then.width > 100);
    }
    await page.getByRole("button", { name: "Debrief: on by 10 s" }).click();
    await until("the middle", async () => {
      const { time, busy } = await status();
      return !busy && time === from + 10;
    });
    await until("its picture", async () => Number(await page.locator(
      ".then .tile").first().getAttribute("data-time")) === from + 10);
    // The live scene has its own time and wind.
    const live = await recorder.state();
    assert.equal(live.clock.time, from + 20);
    assert.equal(live.sea.windSpeed, 8);
    assert.equal((await recorder.request("GET", "/v1/debrief/state"))
      .sea.windSpeed, 6);
    await page.locator("#debrief-views").selectOption("all");
    await until("both", async () => (await thens()).length === 2);
    await page.locator("#debrief-bar .slider").focus();
    await page.keyboard.press("Home");
    await until("the beginning", async () => (await status()).position === 0);
    await page.locator("#debrief-rate").selectOption("8");
    await page.locator("#debrief-play").click();
    await until("that it plays", async () => (await status()).position > 0);
    await until("its end", async () => {
      const { position, length, playing } = await status();
      return position === length && !playing;
    });
    await shot(`debrief-${width}`);
    await page.locator("#debrief-close").click();
    await until("it is closed", () => page.locator("#debrief-bar").isHidden());
    assert.equal(await page.locator(".then .tile").count(), 0);
  });
}

test("a log that cannot be read is refused in words", async () => {
  fs.writeFileSync(`${home}/broken.pelog`, Buffer.concat([
    fs.readFileSync(`${home}/night-390.pelog`), Buffer.alloc(40, 255)]));
  await open(recorder.url, { wait: false });
  await openSections();
  await page.getByRole("button", { name: "Debrief of broken.pelog" }).click();
  await until("why", async () =>
    /broken.pelog: entry \d+/.test(await text("#debrief-bar .error")));
  await shot("debrief-broken");
  await page.locator("#debrief-close").click();
  await until("it is closed", () => page.locator("#debrief-bar").isHidden());
});
