#!/usr/bin/env node
// The page offers what its token's role may do, and nothing else: with each
// role everything that can be pressed and set is, and the server refuses none
// of it; what the page makes of a patch is what the server makes of it.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, before, beforeEach, describe, test } from "node:test";

import { at, clean, inside, open, openSections, page, shot, text }
  from "./page.mjs";
import { Daemon, folder, ROOT, until } from "./pelagos_daemon.mjs";

const TOKENS = { watch: "watch-0123456789abcdef", steer: "steer-0123456789abcdef",
  instruct: "instruct-0123456789abcdef" };
const ASKS = /^\/v1\/(surface|spectrum|optics)$/; // questions with a body
let asking;

before(async () => {
  const home = folder();
  const file = path.join(home, "tokens");
  fs.writeFileSync(file, Object.entries(TOKENS).map(([role, token]) =>
    `${token} ${role}\n`).join(""), { mode: 0o600 });
  asking = await Daemon.start(["--token-file", file, "--exercises",
    path.join(ROOT, "clients/exercises"), "--recordings", home]);
  asking.token = TOKENS.instruct;
});

after(() => asking.stop());

const begin = async (role, size = "laptop") => {
  await open(`${asking.url}/#token=${TOKENS[role]}`,
    { wait: false, ...at(size) });
  await until("the controls", () => page.locator("#panel:not(.waiting)").count());
};

// Own ship, another, two views: what a role may set is there to be set.
beforeEach(() => asking.patch({ sea: { swell: [{ height: 1 }] },
  sky: { fog: [{}] }, ownShip: { on: true }, clock: { mode: "FREE" },
  sources: { cigiStale: true },
  entities: [{ id: 1, name: "ownship", latitude: 52.6, longitude: 5.2,
    model: { name: "ferry" } },
  { id: 2, name: "other", latitude: 52.601, longitude: 5.2 }],
  views: [{ name: "bridge", entity: 1, width: 320, height: 180 },
    { name: "wing", entity: 1, yaw: 90, width: 320, height: 180 }] }));

// What the server refuses by role, and what is asked of it besides reading.
function listen() {
  const heard = { refused: [], changes: [] };
  page.on("response", (response) => {
    const { pathname } = new URL(response.url());
    const method = response.request().method();
    if (response.status() === 403) {
      heard.refused.push(`${method} ${pathname} ${response.request().postData()}`);
    }
    if (method !== "GET" && !ASKS.test(pathname)) {
      heard.changes.push(`${method} ${pathname}`);
    }
  });
  return heard;
}

// Presses and sets whatever is there; how much that was.
const tryAll = () => page.evaluate(async () => {
  const rest = () => new Promise((done) => {
    setTimeout(done, 20);
  });
  const seen = (node) => node.isConnected && !node.disabled &&
    !node.readOnly && node.checkVisibility();
  const tried = [];
  for (const node of document.querySelectorAll(
    "#silent button, #panel button, #panel input, #panel select")) {
    if (seen(node) && !/Link to/.test(node.textContent)) {
      tried.push(node.id || node.textContent || node.type);
      if (node.matches("button, [type=checkbox]")) {
        node.click();
      } else if (node.matches("select")) {
        const other = [...node.options].find((o) => o.value !== node.value);
        node.value = other?.value ?? node.value;
        node.dispatchEvent(new Event("change", { bubbles: true }));
      } else {
        node.value = node.type === "range"
          ? (Number(node.min) + Number(node.max)) / 2 : node.value || "1";
        node.dispatchEvent(new Event("input", { bubbles: true }));
        node.dispatchEvent(new Event("change", { bubbles: true }));
      }
      await rest();
    }
  }
  return tried;
});

const enabled = () => page.locator("#panel .control input:not(:disabled)," +
  "#panel .control select:not(:disabled)").evaluateAll((nodes) =>
  [...new Set(nodes.filter((n) => n.checkVisibility()).map((n) =>
    n.closest("[data-path]")?.dataset.path ?? n.id))].sort());

describe("a page that", () => {
  test("watches sets nothing and offers nothing to set", async () => {
    await begin("watch");
    await openSections();
    await until("the role", async () => await text("#role") === "Watching");
    const heard = listen();
    await until("its controls rest", async () =>
      (await page.locator(".rests").count()) > 50);
    assert.deepEqual(await enabled(), ["page-layout", "page-theme", "ship-id",
      "swell-train", "view-name"], "choices that change the page alone");
    for (const id of ["scenes", "add", "clear", "silent-clear", "level", "record",
      "remove", "follow-it", "look-at"]) {
      assert.ok(!await page.locator(`#${id}`).isVisible(), id);
    }
    await inside();
    await clean("watching");
    const tried = await tryAll();
    assert.ok(tried.includes("plan-up") && tried.length > 8, `${tried}`);
    // By hand: the picture, the plan.
    await page.locator(".glass").first().dragTo(page.locator(".glass").first(),
      { sourcePosition: { x: 90, y: 90 }, targetPosition: { x: 40, y: 90 } });
    await page.keyboard.press("ArrowLeft");
    await page.locator("#plan").focus();
    for (const key of ["PageDown", "Shift+ArrowUp", "Delete"]) {
      await page.keyboard.press(key);
    }
    await until("what is asked is answered", () => page.evaluate(() =>
      fetch("/healthz").then((r) => r.ok)));
    await shot("role-watch");
    assert.deepEqual(heard, { refused: [], changes: [] });
  });

  test("steers sets own ship and turns views, and nothing else", async () => {
    await begin("steer");
    await openSections();
    await until("the role", async () => await text("#role") === "Steering");
    await until("its controls rest", async () =>
      (await page.locator(".rests").count()) > 50);
    assert.deepEqual(await enabled(), ["entities.*.course",
      "entities.*.heading", "entities.*.speed", "entities.*.turnRate",
      "own-ship", "ownShip.rudder", "ownShip.throttle", "page-layout",
      "page-theme", "ship-id", "swell-train", "view-name",
      "views.*.fieldOfView", "views.*.pitch", "views.*.roll", "views.*.yaw"]);
    const heard = listen();
    // Orders by its own controls.
    await page.locator('[data-path="ownShip.rudder"] .entry').fill("7");
    await until("the rudder", async () =>
      (await asking.state()).ownShip.rudder === 7);
    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press("ArrowRight");
    await until("it is turned", async () =>
      (await asking.state()).views[0].yaw === 5);
    // Of another ship nothing.
    await page.locator("#ship-id").selectOption("2");
    await until("another's rest", () => page.locator("#heading").isDisabled());
    await page.locator("#ship-id").selectOption("1");
    await until("one's own", () => page.locator("#heading").isEnabled());
    const tried = await tryAll();
    assert.ok(tried.includes("level") && tried.length > 20, `${tried}`);
    await page.locator("#plan").focus();
    for (const key of ["PageDown", "Shift+ArrowUp", "Delete"]) {
      await page.keyboard.press(key);
    }
    await shot("role-steer");
    assert.deepEqual(heard.refused, []);
    assert.ok(heard.changes.every((c) => c === "PATCH /v1/state"));
  });

  test("steers has room for it on a phone", async () => {
    await begin("steer", "phone");
    await openSections();
    await until("the role", () => page.locator("#role").isVisible());
    const top = (selector) => page.locator(selector).evaluate((n) => {
      const box = n.getBoundingClientRect();
      return (box.top + box.bottom) / 2;
    });
    const middle = await top(".bar h1");
    for (const selector of ["#role", "#link"]) {
      assert.ok(Math.abs(await top(selector) - middle) < 8, selector);
    }
    await inside();
    await clean("steering on a phone");
  });

  test("instructs may do everything", async () => {
    await begin("instruct");
    await openSections();
    await until("the exercises", () => page.locator("#exercises").isVisible());
    assert.equal(await page.locator(".rests, .barred").count(), 0);
    assert.ok(await page.locator("#role").isHidden());
  });

  test("has another role from one moment to the next learns it", async () => {
    await begin("instruct");
    await openSections();
    const file = asking.process.spawnargs[asking.process.spawnargs.indexOf(
      "--token-file") + 1];
    const all = fs.readFileSync(file, "utf8");
    try {
      fs.writeFileSync(file,
        `${TOKENS.instruct} watch\n${TOKENS.watch} instruct\n`);
      asking.process.kill("SIGHUP");
      await until("the server has it", async () => (await asking.request("GET",
        "/v1/session")).role === "watch");
      await page.locator("#wind-speed").focus();
      await page.keyboard.press("ArrowRight");
      await until("the role", async () => await text("#role") === "Watching");
      await until("it rests", () => page.locator("#wind-speed").isDisabled());
    } finally {
      fs.writeFileSync(file, all);
      asking.process.kill("SIGHUP");
      await until("as before", async () => (await asking.request("GET",
        "/v1/session")).role === "instruct");
    }
  });
});

// The page judges patches by itself: as the server does.
describe("patches", () => {
  const PATCHES = [
    { sea: { windSpeed: 3 } }, { ownShip: { rudder: 1 } },
    { ownShip: { rudder: 1, throttle: 0.5 } }, { ownShip: null },
    { ownShip: { rudder: null } }, { ownShip: { entity: 1 } },
    { entities: { 1: { speed: 1 } } }, { entities: { 1: { latitude: 52.6 } } },
    { entities: { 1: { speed: 1, name: "x" } } },
    { entities: { 1: { helm: { rudder: 1 } } } },
    { entities: { 2: { speed: 1 } } }, { entities: { 1: null } },
    { entities: { 9: { speed: 1 } } }, { entities: [] },
    { views: { bridge: { yaw: 3 } } },
    { views: { bridge: { yaw: 3, up: 4 } } },
    { views: { bridge: { yaw: null } } }, { views: { none: { yaw: 3 } } },
    { views: { bridge: null } }, { views: [] }, { views: null },
    { clock: { rate: 1 } }, { presets: { a: { title: "a" } } },
    { views: { bridge: { pitch: 1 } }, ownShip: { throttle: 0.2 } },
    { views: { bridge: { pitch: 1 } }, sky: { rain: 1 } },
  ];

  for (const role of ["watch", "steer"]) {
    test(`by ${role}`, async () => {
      await begin(role);
      await until("the role", async () => await text("#role") !== "");
      const judged = await page.evaluate(async (patches) => {
        const { mayPatch } = await import("/rights.js");
        const state = await fetch("/v1/state", { headers: { Authorization:
          `Bearer ${sessionStorage.getItem("pelagos-token")}` } })
          .then((r) => r.json());
        return patches.map((p) => mayPatch(p, state));
      }, PATCHES);
      for (const [i, patch] of PATCHES.entries()) {
        const answer = await fetch(`${asking.url}/v1/state`, { method: "PATCH",
          headers: { Authorization: `Bearer ${TOKENS[role]}`,
            "Content-Type": "application/merge-patch+json" },
          body: JSON.stringify(patch) });
        assert.equal(judged[i], answer.status !== 403, JSON.stringify(patch));
      }
      assert.equal(judged.some(Boolean), role === "steer");
    });
  }
});
