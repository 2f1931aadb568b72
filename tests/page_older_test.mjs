#!/usr/bin/env node
// The page in a browser that lacks what older ones lack, in one in which it
// does not run, without JavaScript; and what its introduction says of the wheel.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { describe, it } from "node:test";

import { browser, daemon, fresh, open, page, pictures, shot, text, view }
  from "./page.mjs";
import { Daemon, folder, until } from "./pelagos_daemon.mjs";

// What Chromium has had since 2020 and the page uses.
const forget = () => {
  for (const [on, ...names] of [[Array.prototype, "at", "findLast",
    "findLastIndex"], [String.prototype, "replaceAll"],
  [AbortSignal, "timeout"], [CanvasRenderingContext2D.prototype, "roundRect"],
  [window, "HTMLDialogElement", "VideoDecoder"]]) {
    names.forEach((name) => delete on[name]);
  }
  const { supports } = CSS;
  CSS.supports = (...given) => given[0] !== "aspect-ratio" &&
    supports.apply(CSS, given);
};

// The parts of the page that do not come.
const without = async (...parts) => {
  const context = await browser.newContext({
    viewport: { width: 1360, height: 900 } });
  const made = await context.newPage();
  for (const part of parts) {
    await made.route(`**/${part}`, (route) => route.fulfill({
      contentType: "text/javascript", body: "?" }));
  }
  return made;
};
const shown = (made) => until("a picture", () => made.locator(
  "#plain-views img").evaluateAll((images) => images.length > 0 &&
    images.every((image) => image.naturalWidth > 0)));

describe("an older browser", () => {
  it("gets what it lacks", async () => {
    await fresh();
    await open(daemon.url, { init: forget });
    await until("the controls", () =>
      page.locator("#panel:not(.waiting)").count());
    assert.equal(await text("#link"), "connected");
    const [across, down] = await page.locator(".tile .picture:visible")
      .evaluate((n) => [n.clientWidth, n.clientHeight]);
    assert.ok(Math.abs(down - across * 360 / 640) < 2, `${across}×${down}`);
  });

  it("gets functions that do what its own would", async () => {
    const asked = () => page.evaluate(async () => {
      const signal = AbortSignal.timeout(1);
      await new Promise((done) => setTimeout(done, 100));
      return [[1, 2, 3].at(-1), [1, 2, 3].at(0), [1].at(2), [1].at(-2),
        [5, 6, 7].findLast((x) => x < 7), [5, 6].findLast((x) => x > 7),
        [5, 6, 7].findLastIndex((x) => x < 7), [5].findLastIndex(() => false),
        "a-b-c".replaceAll("-", ""), signal.aborted].map(String);
    });
    await open(daemon.url, { wait: false });
    const own = await asked();
    await page.context().close();
    await open(daemon.url, { wait: false, init: forget });
    assert.deepEqual(await asked(), own);
    // No browser of today has dialogs that it does not know: any such element.
    assert.deepEqual(await page.evaluate(() => {
      const node = document.createElement("dialogue");
      const closed = [];
      node.addEventListener("close", () => closed.push("close"));
      node.showModal();
      const { open: was } = node;
      node.close();
      return [was, node.open, ...closed];
    }), [true, false, "close"]);
  });
});

describe("a browser that is too old", () => {
  it("says so, and shows pictures", async () => {
    const made = await without("app.js", "theme.js");
    await made.goto(daemon.url);
    await shown(made);
    assert.match(await made.locator("#plain-note").textContent(),
      /too old.*Chromium 87.*Firefox 78.*Safari 15/);
    assert.equal(await made.locator(".deck").isVisible(), false);
    await made.screenshot({ path: "build/page/too-old.png" });
    await made.context().close();
  });

  it("is not blamed for a part that did not come", async () => {
    const made = await without("app.js");
    await made.goto(daemon.url);
    await shown(made);
    const said = await made.locator("#plain-note").textContent();
    assert.match(said, /did not begin/);
    assert.doesNotMatch(said, /too old/);
    await made.context().close();
  });

  it("gets pictures by a token", async () => {
    const token = "0123456789abcdef0123";
    const file = path.join(folder(), "token");
    fs.writeFileSync(file, `${token}\n`, { mode: 0o600 });
    const locked = await Daemon.start(["--token-file", file]);
    try {
      for (const end of [`#token=${token}`, ""]) {
        const made = await without("app.js", "theme.js");
        await made.goto(`${locked.url}/${end}`);
        if (!end) {
          await made.locator(".plain input").fill(token);
          await made.keyboard.press("Enter");
        }
        await shown(made);
        await made.context().close();
      }
    } finally {
      await locked.stop();
    }
  });
});

it("says where pictures are, without JavaScript, in sight", async () => {
  await open(daemon.url, { wait: false, javaScriptEnabled: false });
  const box = await page.locator("noscript p").boundingBox();
  assert.ok(box.y < 200 && box.height > 20, JSON.stringify(box));
  assert.equal(await page.locator(".deck").isVisible(), false);
  await shot("noscript");
});

it("zooms by the wheel as the introduction says", async () => {
  await fresh();
  await open(daemon.url, { tour: true });
  await pictures(1);
  await until("the introduction", () => page.locator("#tour").count());
  assert.match(await text("#tour"), /Ctrl and the wheel.*zoom/s);
  await page.locator(".tile").hover();
  await page.keyboard.down("Control");
  await page.mouse.wheel(0, -300);
  await page.keyboard.up("Control");
  await until("a narrower view", async () =>
    (await view()).fieldOfView < 59);
});
