#!/usr/bin/env node
// A visitor's quarter of an hour, who has nothing but a browser: the
// introduction, a storm, an evening, a picture to take home, the same sea on a
// phone, and a wall. The parts have tests of their own.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import path from "node:path";
import { test } from "node:test";

import { browser, daemon, fresh, open, page, pictures, shot, SHOTS, state, text }
  from "./page.mjs";
import { sleep, until } from "./pelagos_daemon.mjs";

const choose = (id, label) => page.locator(`#${id}`).selectOption({ label });

// Mean and spread of the first picture's lower half, of 255.
const look = (of = page) => of.evaluate(() => {
  const p = [...document.querySelectorAll(".picture")].find((n) => !n.hidden);
  const g = new OffscreenCanvas(160, 90).getContext("2d");
  g.drawImage(p, 0, 0, 160, 90);
  const d = g.getImageData(0, 50, 160, 40).data;
  let [n, s, q] = [0, 0, 0];
  for (let i = 0; i < d.length; i += 4) {
    const y = 0.3 * d[i] + 0.6 * d[i + 1] + 0.1 * d[i + 2];
    n++;
    s += y;
    q += y * y;
  }
  return { mean: s / n, spread: Math.sqrt(Math.max(0, q / n - (s / n) ** 2)) };
});

test("a visitor's quarter of an hour", async () => {
  await fresh();
  await open(daemon.url, { tour: true, viewport: { width: 1440, height: 900 } });
  const tour = page.locator("#tour");
  await until("the introduction", () => tour.isVisible());
  await page.getByRole("button", { name: "Next" }).focus();
  for (let i = 0; i < 3; i++) {
    await page.keyboard.press("Enter");
  }
  assert.equal(await tour.count(), 0, "three steps by the keyboard");

  await choose("preset-sea", "1 light air");
  await until("a calm", async () => (await state()).sea.windSpeed < 2);
  await sleep(1500);
  const calm = await look();
  await shot("visitor-calm");
  await choose("preset-sea", "9 strong gale");
  await until("a gale", async () => (await state()).sea.windSpeed > 20);
  let gale;
  await until("a rougher picture", async () => {
    gale = await look();
    return gale.spread > 1.3 * calm.spread;
  });
  console.log(`spread of the sea's brightness: calm ${calm.spread.toFixed(1)}, ` +
    `gale ${gale.spread.toFixed(1)}`);
  await shot("visitor-gale");

  await choose("preset-time", "Evening");
  await until("a low Sun", async () => {
    const { sky } = await state();
    return sky.sunElevation < 10 && sky.sunElevation > -6;
  });
  await until("less light, or warmer", async () =>
    Math.abs((await look()).mean - gale.mean) > 3);
  await shot("visitor-evening");

  // A picture to take home says when and where it was.
  await page.evaluate(() => {
    document.querySelectorAll("#panel > details").forEach((d) => {
      d.open = Boolean(d.querySelector("#keep-note"));
    });
  });
  const [download] = await Promise.all([
    page.waitForEvent("download", { timeout: 120000 }),
    page.getByRole("button", { name: "Save a picture as JPEG" }).click()]);
  const file = path.join(SHOTS, `visitor-${download.suggestedFilename()}`);
  await download.saveAs(file);
  const [said] = JSON.parse(execFileSync("exiftool", ["-json", "-n", file]));
  assert.ok(Math.abs(said.GPSLatitude - 52.6) < 0.1, `${said.GPSLatitude}`);
  assert.match(said.DateTimeOriginal, /^2026:06:\d\d /);
  console.log(`taken home: ${said.ImageWidth}×${said.ImageHeight}, ${
    said.DateTimeOriginal} UTC, ${said.GPSLatitude}° ${said.GPSLongitude}°`);

  // The same sea on a phone and on a wall, at once.
  for (const [name, query, viewport] of [
    ["phone", "/", { width: 390, height: 844 }],
    ["wall", "/?view=bridge&hud=0", { width: 2560, height: 1440 }]]) {
    const context = await browser.newContext({ viewport });
    const other = await context.newPage();
    await other.addInitScript(() => localStorage.setItem("pelagos-tour", "seen"));
    await other.goto(daemon.url + query);
    await until(`a picture on the ${name}`, async () =>
      await other.locator(".tile:has(.tile-note[hidden])").count() === 1);
    const box = await other.locator(".picture:visible").first().boundingBox();
    assert.ok(box.x >= 0 && box.x + box.width <= viewport.width + 1 &&
      box.y + box.height <= viewport.height + 1, JSON.stringify(box));
    assert.ok(box.width > 0.9 * viewport.width ||
      box.height > 0.9 * viewport.height, JSON.stringify(box));
    assert.ok((await look(other)).spread > 1, "it shows a sea");
    await other.screenshot({ path: path.join(SHOTS, `visitor-${name}.png`) });
    await context.close();
  }
  await pictures(1);
  assert.match(await text("#fps"), /fps/);
});
