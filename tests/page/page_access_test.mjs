#!/usr/bin/env node
// The page for everybody: axe finds nothing in any of its states, light and
// dark, on a phone and on large screens, and nothing is cut off.
//
// Skipped (77) without Chromium, playwright-core or axe-core. Screenshots:
// build/page/.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, before, describe, test } from "node:test";

import { wanted } from "../browser.mjs";
import { daemon, fresh, open, openSections, page, shot } from "../page.mjs";
import { Daemon, folder, until } from "../pelagos_daemon.mjs";

const axe = wanted("axe-core");
const TOKEN = "0123456789abcdef0123456789abcdef";
const SIZES = [[390, 844], [1440, 900], [2560, 1440]];
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"];
let home, asking, recording;

before(async () => {
  home = folder();
  fs.writeFileSync(path.join(home, "token"), TOKEN, { mode: 0o600 });
  asking = await Daemon.start(["--token-file", path.join(home, "token")]);
  recording = await Daemon.start(["--recordings", home]);
  await recording.patch({ views: [{ name: "bridge", entity: 1, width: 320,
    height: 180 }] });
  await recording.request("POST", "/v1/recording", { start: "night" });
  await recording.patch({ sea: { windSpeed: 9 } });
  await recording.request("POST", "/v1/recording", { stop: true });
});

after(async () => {
  await asking.stop();
  await recording.stop();
  fs.rmSync(home, { recursive: true });
});

// What axe finds within a part of the page, as lines that say where.
async function found(within = "html") {
  await page.evaluate((source) => {
    window.axe ?? new Function(source)();
  }, axe.source);
  return page.evaluate(async ([tags, part]) => {
    const { violations } = await window.axe.run(part, {
      resultTypes: ["violations"], runOnly: { type: "tag", values: tags } });
    return violations.flatMap(({ id, nodes }) => nodes.map((n) =>
      `${id}: ${n.target.join(" ")} ${n.any[0]?.message ?? ""}`));
  }, [TAGS, within]);
}

// What reaches beyond the window sideways, of what is shown.
const cutOff = () => page.evaluate(() => [...document.querySelectorAll(
  "button, input, select, summary, p, h1, h2, dd, figure")].filter((n) => {
  const box = n.getBoundingClientRect();
  return n.checkVisibility() && box.width > 1 && !n.closest(".skip") &&
    (box.right > innerWidth + 1 || box.left < -1);
}).map((n) => n.outerHTML.slice(0, 80)));

const sized = (name, [width, height], theme, work) =>
  test(`${name}, ${width}×${height}, ${theme}`, async () => {
    await work({ viewport: { width, height }, colorScheme: theme,
      ...(width < 800 ? { hasTouch: true, isMobile: true } : {}) });
  });

async function judge(state, theme, within) {
  assert.deepEqual(await found(within), [], `${state}, ${theme}`);
  assert.deepEqual(await cutOff(), [], `${state}: cut off`);
}

const SECTIONS = async () => page.locator("#panel > details").evaluateAll(
  (all) => all.map((d) => d.querySelector("summary").textContent));

async function onlySection(name) {
  await page.evaluate((wanted) => {
    document.querySelectorAll("#panel details").forEach((d) => {
      const own = d.matches("#panel > details")
        ? d.querySelector("summary").textContent === wanted
        : d.closest("#panel > details")?.querySelector("summary")
          .textContent === wanted;
      d.open = own;
    });
  }, name);
}

for (const theme of ["dark", "light"]) {
  for (const size of SIZES) {
    describe(`${size.join("×")} ${theme}`, () => {
      sized("each section", size, theme, async (options) => {
        await fresh();
        await daemon.patch({ entities: { 7: { name: "tug", speed: 3,
          model: { name: "tug" }, latitude: 52.601, longitude: 5.201 } },
        sea: { swell: [{ height: 1 }] } });
        await open(daemon.url, options);
        await until("the controls", () =>
          page.locator("#wind-speed").count());
        await until("the theme", () => page.evaluate((t) =>
          document.documentElement.dataset.theme === t, theme));
        await judge("as it opens", theme);
        await shot(`access-${size[0]}-${theme}`);
        await page.locator("#traffic tr").nth(1).locator("button").click();
        // The panel of 2560 is that of 1440.
        for (const name of size[0] > 2000 ? [] : await SECTIONS()) {
          await onlySection(name);
          await judge(name, theme, "#panel > details[open]");
        }
        await page.locator("#large").click();
        await judge("the large plan", theme);
        await shot(`access-plan-${size[0]}-${theme}`);
        await page.locator("#large").click();
        await page.locator("#about-open").click();
        await until("the dialog", () =>
          page.locator("dialog[open]").count());
        await judge("about", theme);
        await page.keyboard.press("Escape");
        await page.evaluate(() => localStorage.clear());
        await page.locator(".full").click();
        await judge("full screen", theme);
      });

      sized("errors", size, theme, async (options) => {
        await fresh();
        await open(`${daemon.url}/?views=bridge,nowhere`, options);
        await openSections();
        await page.locator(".control:has(#wind-speed) .entry").fill("300");
        await until("the error", () =>
          page.locator("#wind-speed-error").isVisible());
        await judge("a refused value", theme);
        await daemon.patch({ sources: { nmeaStale: true }, views: null });
        await until("no view", () => page.locator("#no-views").isVisible());
        await judge("no view, a silent input", theme);
        await shot(`access-errors-${size[0]}-${theme}`);
        await open(asking.url, { ...options, wait: false });
        await until("the question", () => page.locator("#login").isVisible());
        await page.locator("#login-token").fill("short");
        await page.getByRole("button", { name: "Enter" }).click();
        await judge("login", theme);
      });

      sized("the debrief", size, theme, async (options) => {
        await open(recording.url, options);
        await openSections();
        await page.getByRole("button", { name: "Debrief of" }).click();
        await until("a picture of then", () =>
          page.locator(".then .tile:has(.tile-note[hidden])").count());
        await judge("debrief", theme);
        await shot(`access-debrief-${size[0]}-${theme}`);
        await page.locator("#debrief-close").click();
        await until("its end", () =>
          page.locator("#debrief-bar").isHidden());
      });
    });
  }
}
