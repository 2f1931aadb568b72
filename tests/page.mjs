// What the tests of the page share: a browser, a daemon, a page of its own for
// each test.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, afterEach, before } from "node:test";

import { openBrowser, wanted } from "./browser.mjs";
import { Daemon, ROOT, until } from "./pelagos_daemon.mjs";

export const SIZES = { phone: [390, 844], laptop: [1440, 900],
  wall: [2560, 1440] };
export const at = (size) => ({ viewport: { width: SIZES[size][0],
  height: SIZES[size][1] } });
export const SHOTS = path.join(ROOT, "build/page");
wanted("playwright-core"); // or the test is skipped
fs.mkdirSync(SHOTS, { recursive: true });

export let browser, daemon, page;
let errors, axe;

// A page of its own, whose errors fail the test.
// tour: as in a browser that has not seen it; else its introduction is over.
export async function open(url, { wait = true, init, tour = false,
  ...options } = {}) {
  const context = await browser.newContext({
    viewport: { width: 1360, height: 900 }, ...options });
  page = await context.newPage();
  errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => {
    if (message.type() === "error" && !/Failed to load|ERR_|WebSocket/.test(
      message.text())) {
      errors.push(message.text());
    }
  });
  if (!tour) {
    await page.addInitScript(() => {
      try {
        localStorage.setItem("pelagos-tour", "seen");
      } catch {
        // a page without storage
      }
    });
  }
  if (init) {
    await page.addInitScript(init);
  }
  await page.goto(url);
  if (wait) {
    await until("a picture", async () => await shown() > 0);
  }
  return page;
}

const shown = () => page.locator(".tile:has(.tile-note[hidden])").count();
export const pictures = (count) => until(`${count} pictures`, async () =>
  await shown() === count);
export const shot = (name) =>
  page.screenshot({ path: path.join(SHOTS, `${name}.png`) });
export const slide = (id, value) =>
  page.locator(`#${id}`).evaluate((node, v) => {
    node.value = v;
    node.dispatchEvent(new Event("input"));
  }, value);
export const state = () => daemon.state();
export const view = async () => (await state()).views[0];
export const text = (selector) => page.locator(selector).first().textContent();
export const openSections = async () => {
  await until("the controls", () => page.locator("#wind-speed").count());
  await page.evaluate(() => {
    document.querySelectorAll("details").forEach((d) => {
      d.open = true;
    });
  });
};

export const only = (...ids) => page.evaluate((wanted_) => {
  document.querySelectorAll("#panel > details").forEach((d) => {
    d.open = wanted_.some((id) => d.id === id || d.querySelector(`#${id}`));
  });
}, ids);
export const ready = () => until("the controls", () =>
  page.locator("#panel:not(.waiting)").count());

// Without a fault that axe knows of, in both colours.
export async function clean(what) {
  axe ??= wanted("axe-core");
  await page.evaluate(axe.source);
  for (const colorScheme of ["dark", "light"]) {
    await page.emulateMedia({ colorScheme });
    const found = await page.evaluate(() => axe.run({ runOnly: ["wcag2a",
      "wcag2aa", "wcag21aa", "best-practice"] }));
    assert.deepEqual(found.violations.map((v) => `${v.id}: ${v.help}: ${
      v.nodes.map((n) => n.html.slice(0, 120))}`), [], `${what}, ${colorScheme}`);
  }
  await page.emulateMedia({ colorScheme: null });
}

export const inside = async () => assert.deepEqual(await page.locator(
  ".section[open] *:visible").evaluateAll((nodes) => nodes.filter((n) =>
  n.getBoundingClientRect().right >
    n.closest(".section").getBoundingClientRect().right + 1)
  .map((n) => n.outerHTML.slice(0, 120))), [], "wider than its section");

// A file that the page hands over.
export async function saved(action) {
  const [download] = await Promise.all([page.waitForEvent("download",
    { timeout: 120000 }), action()]);
  const file = path.join(SHOTS, download.suggestedFilename());
  await download.saveAs(file);
  return file;
}

export const fresh = () => daemon.patch({
  sea: null, sky: null, water: null, clock: null, ownShip: null,
  sources: null, presets: null,
  entities: [{ id: 1, name: "ownship" }],
  views: [{ name: "bridge", entity: 1, width: 640, height: 360 }] });

before(async () => {
  browser = await openBrowser();
  daemon = await Daemon.start();
});

after(async () => {
  await browser.close();
  await daemon.stop();
});

afterEach(async () => {
  await page?.context().close();
  assert.deepEqual(errors, [], "errors of the page");
});
