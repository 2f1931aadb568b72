#!/usr/bin/env node
// The page on phones and by keys: the picture stays in sight above the controls
// that change it, nothing is cut off, what is touched has 24 px; every control
// is reached by Tab, and where the focus is can be seen.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import { describe, test } from "node:test";

import { daemon, fresh, open, openSections, page, pictures, shot }
  from "../page.mjs";
import { until } from "../pelagos_daemon.mjs";

// What reaches beyond the window sideways, of what is shown.
const cutOff = () => page.evaluate(() => [...document.querySelectorAll(
  "button, input, select, summary, p, h1, h2, dd, figure")].filter((n) => {
  const box = n.getBoundingClientRect();
  return n.checkVisibility() && box.width > 1 && !n.closest(".skip") &&
    (box.right > innerWidth + 1 || box.left < -1);
}).map((n) => n.outerHTML.slice(0, 80)));

describe("on a phone", () => {
  const targets = () => page.evaluate(() => [...document.querySelectorAll(
    "button, input, select, summary, a[href]")].filter((n) => {
    const box = n.getBoundingClientRect();
    return n.checkVisibility() && box.width > 0 && !n.matches(".skip") &&
      (box.width < 23.9 || box.height < 23.9);
  }).map((n) => `${n.outerHTML.slice(0, 90)} ${JSON.stringify(
    n.getBoundingClientRect())}`));

  for (const [width, height] of [[390, 844], [360, 640], [844, 390]]) {
    test(`the picture stays above its controls, ${width}×${height}`,
      async () => {
        await fresh();
        await open(daemon.url, { viewport: { width, height }, hasTouch: true,
          isMobile: true });
        await openSections();
        const inSight = () => page.locator(".tile").first().evaluate((n) => {
          const box = n.getBoundingClientRect();
          return box.top >= 0 && box.top + 0.8 * box.height <= innerHeight &&
            box.height > 100;
        });
        for (const id of ["wind-speed", "field-of-view", "turbidity"]) {
          const control = page.locator(`#${id}`);
          if (await control.count() > 0 && await control.isVisible()) {
            await control.scrollIntoViewIfNeeded();
            assert.ok(await inSight(), `the picture, at ${id}`);
          }
        }
        await shot(`phone-${width}-controls`);
        assert.deepEqual(await targets(), [], "targets of 24 px");
        assert.deepEqual(await cutOff(), [], "cut off");
        assert.equal(await page.evaluate(() =>
          document.documentElement.scrollWidth > innerWidth), false);
      });
  }

  test("keys reach everything, and focus is seen", async () => {
    await fresh();
    await open(daemon.url);
    await pictures(1);
    await until("the controls", () => page.locator("#wind-speed").count());
    await page.evaluate(() => document.activeElement.blur());
    const seen = new Set();
    for (let i = 0; i < 400; i++) {
      await page.keyboard.press("Tab");
      const at = await page.evaluate(() => {
        const n = document.activeElement;
        if (n === document.body) {
          return null;
        }
        const style = getComputedStyle(n);
        n.dataset.reached = "yes";
        return { seen: style.outlineStyle !== "none" &&
          parseFloat(style.outlineWidth) >= 1, what: n.outerHTML.slice(0, 90) };
      });
      if (at === null) {
        break;
      }
      assert.ok(at.seen, `focus is seen on ${at.what}`);
      seen.add(at.what);
    }
    const left = await page.evaluate(() => [...document.querySelectorAll(
      "button, input, select, summary, [tabindex='0']")].filter((n) =>
      n.checkVisibility() && !n.disabled && !n.dataset.reached)
      .map((n) => n.outerHTML.slice(0, 90)));
    assert.deepEqual(left, [], "not reached by Tab");
    assert.ok(seen.size > 40, `${seen.size} stops`);
  });
});
