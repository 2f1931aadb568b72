#!/usr/bin/env node
// What the page says of a server that takes its time and of models that cannot
// be read, and where its introduction leads.
//
// Skipped (77) without Chromium or playwright-core.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { test } from "node:test";

import { daemon, fresh, open, page, ready, state, text } from "./page.mjs";
import { Daemon, folder, sleep, until } from "./pelagos_daemon.mjs";

const LONGER_MS = 6000; // than questions are waited for

test("an edit that takes its time was sent", async () => {
  await fresh();
  await open(daemon.url);
  await ready();
  await page.route("**/v1/state", async (route) => {
    if (route.request().method() === "PATCH") {
      await sleep(LONGER_MS);
    }
    await route.continue();
  });
  await page.getByRole("button", { name: "Harbour" }).click();
  await until("the harbour", async () => (await state()).entities.length > 10);
  await until("the page has it", async () =>
    await page.locator("#panel").getByText("fairway").count() > 0);
  assert.doesNotMatch(await text("#plan-note"), /Not sent/);
});

test("a model that cannot be read says why", async () => {
  const home = folder();
  fs.writeFileSync(path.join(home, "broken.glb"), "no glTF");
  const other = await Daemon.start(["--models", home]);
  try {
    await open(other.url);
    await until("the model", async () => {
      await page.locator("#add-model").evaluate((node) =>
        node.dispatchEvent(new Event("focus")));
      return /broken\.glb \(.{10,}\)/.test(await text("#add-model"));
    });
    assert.doesNotMatch(await text("#add-model"), /object Object/);
  } finally {
    await other.stop();
    fs.rmSync(home, { recursive: true });
  }
});

test("the introduction shows what it names", async () => {
  await fresh();
  await open(daemon.url, { tour: true, viewport: { width: 1440, height: 900 } });
  await until("the introduction", () => page.locator("#tour").isVisible());
  for (let i = 0; i < 2; i++) {
    await page.getByRole("button", { name: "Next" }).click();
  }
  const box = await page.locator("#add").boundingBox();
  assert.ok(box.y >= 0 && box.y + box.height <= 900, JSON.stringify(box));
  assert.ok(await page.getByRole("button", { name: "Done" }).isVisible());
});
