#!/usr/bin/env node
// The page's exercises: chosen, loaded, run, rewound, stopped, their events and
// facts; the scene saved as one; edited, with the server's word on what is
// wrong; by keys, on a phone, in both colours, with a token.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, before, beforeEach, describe, test } from "node:test";

import { at, clean, inside, only, open, page, ready, saved, shot, text }
  from "./page.mjs";
import { Daemon, folder, ROOT, until } from "./pelagos_daemon.mjs";

const TOKEN = "0123456789abcdef0123456789abcdef";
const FOG = {
  title: "Fog, and a ship",
  state: { ownShip: { on: true, throttle: 0.5 }, entities: [
    { id: 1, latitude: 52.6, longitude: 5.2, speed: 5 },
    { id: 3, latitude: 52.62, longitude: 5.2, speed: 4, course: 180 }] },
  events: [
    { name: "fog", text: "It closes in", when: [{ at: 20 }],
      patch: { state: { sky: { visibility: 800 } } } },
    { name: "rain", when: [{ after: "fog", delay: 10 }],
      patch: { state: { sky: { rain: 3 } } } },
    { name: "near", when: [{ other: 3, rangeBelow: 100 }],
      patch: { state: { sky: { snow: 1 } } } }],
  limits: [{ name: "slow", speed: 3 }],
};
const home = folder();
let daemon;

const exercise = async () => (await daemon.state()).exercise;
const step = (seconds) => daemon.request("POST", "/v1/clock/step", { seconds });
const file = (name) => path.join(home, `${name}.json`);
const press = (name) => page.getByRole("button", { name, exact: true }).click();
const figure = (name) => text(`[data-fact=${name}] dd`);

before(async () => {
  daemon = await Daemon.start(["--exercises", home]);
});

after(() => daemon.stop());

beforeEach(async () => {
  fs.rmSync(home, { recursive: true });
  fs.mkdirSync(home);
  fs.writeFileSync(file("fog"), JSON.stringify(FOG));
  fs.writeFileSync(file("bad"), "{");
  await daemon.patch({ clock: { mode: "STEPPED", rate: 1 }, exercise: null,
    sky: null, sea: null, entities: [{ id: 1, name: "ownship" }],
    views: [{ name: "bridge", entity: 1, width: 320, height: 180 }] });
});

async function begin(size = "laptop", url = daemon.url) {
  await open(url, at(size));
  await ready();
  await only("exercises");
  await until("the list", () => page.locator("#exercise-list option").count());
}

describe("an exercise", () => {
  test("is loaded, run, rewound and stopped", async () => {
    await begin();
    assert.deepEqual(await page.locator("#exercise-list option")
      .allTextContents(), ["bad", "fog: Fog, and a ship"]);
    // The first is no good, and the card says why.
    await until("what is wrong", async () =>
      /bad cannot be loaded/.test(await text("#exercise-note")));
    assert.ok(await page.locator("#exercise-load").isDisabled());
    await page.locator("#exercise-list").selectOption("fog");
    await page.locator("#exercise-load").click();
    await until("ready", async () => await text("#exercise-phase") === "ready");
    assert.equal((await exercise()).name, "fog");
    assert.equal(await text("#exercise-next"), "Next: fog at 0:20.0");
    await page.locator("#exercise-start").click();
    await until("running", async () =>
      await text("#exercise-phase") === "running");
    await step(10);
    await step(10);
    await step(5.5);
    await until("its time", async () =>
      await text("#exercise-time") === "0:25.5");
    assert.deepEqual(await page.locator(".exercise-events li").evaluateAll(
      (rows) => rows.map((r) => [r.querySelector(".recording-name").textContent,
        r.querySelector(".event-when").textContent])), [
      ["fogat 0:20.0", "0:20.0"], ["rain10 s after fog", "waits"],
      ["nearown ship within 100 m of ship 3", "waits"]]);
    await until("facts", async () => await figure("speed_mps") !== "–");
    const lines = (await (await fetch(`${daemon.url}/v1/exercise.csv`)).text())
      .trim().split("\n").map((line) => line.split(","));
    const last = Object.fromEntries(lines[0].map((name, i) =>
      [name, lines.at(-1)[i]]));
    assert.equal(last.time_s, "25.000");
    assert.equal(await figure("speed_mps"),
      `${Number(last.speed_mps).toFixed(1)} m/s`);
    assert.equal(await figure("over_limit_s"), "25 s");
    assert.equal(await text(".exercise-facts tbody tr"),
      `3${Math.round(last.range_3_m)} m${[last.cpa_3_m].map((x) => Math.abs(x) <
        10 ? Number(x).toFixed(1) : Math.round(x))} m${
        Math.round(last.tcpa_3_s)} s${Math.round(last.closest_3_m)} m`);
    await inside();
    await shot("exercise-laptop");
    const csv = await saved(() => page.locator("#exercise-csv").click());
    assert.equal(path.basename(csv), "fog.csv");
    assert.equal(fs.readFileSync(csv, "utf8").split("\n").length,
      lines.length + 1);

    await page.locator("#exercise-pause").click();
    await until("paused", async () => (await exercise()).phase === "PAUSED");
    await page.locator("#exercise-to").fill("12");
    await page.locator("#exercise-rewind").click();
    await until("12 s", async () => (await exercise()).time === 12);
    await until("it is shown", async () =>
      await text("#exercise-time") === "0:12.0" &&
      await page.locator(".exercise-events .fired").count() === 0);
    await until("facts of then", async () => await figure("over_limit_s") ===
      "12 s");
    await page.getByRole("button", { name: "Let the exercise go on" }).click();
    await until("running", async () => (await exercise()).phase === "RUNNING");
    await step(9);
    await press("Rewind to just before fog");
    await until("19.9 s", async () => Math.abs((await exercise()).time - 19.9) <
      0.01);
    await page.locator("#exercise-stop").click();
    await until("ended", async () => await text("#exercise-phase") === "ended");
    // What cannot be is said where it was asked for.
    await page.evaluate(() => {
      const start = document.querySelector("#exercise-start");
      start.disabled = false;
      start.click();
    });
    await until("why not", async () =>
      /has ended/.test(await text("#exercise-note")));
  });

  test("is made of the scene, and deleted", async () => {
    await daemon.patch({ sea: { windSpeed: 11 }, entities: [
      { id: 1, name: "ownship", latitude: 52.61, longitude: 5.21, speed: 3 },
      { id: 4, name: "buoy", latitude: 52.62, longitude: 5.2 }] });
    await begin();
    await page.locator("#exercise-save").click();
    assert.equal(await text("#exercise-note"), "An exercise needs a name.");
    await page.locator("#exercise-title").fill("Evening watch");
    await page.keyboard.press("Enter");
    await until("it is saved", () => fs.existsSync(file("Evening-watch")));
    const kept = JSON.parse(fs.readFileSync(file("Evening-watch")));
    assert.equal(kept.title, "Evening watch");
    assert.equal(kept.state.sea.windSpeed, 11);
    assert.equal(kept.state.entities[1].name, "buoy");
    await until("it is chosen", async () =>
      await page.locator("#exercise-list").inputValue() === "Evening-watch");
    // A name that is taken is not taken again.
    await page.locator("#exercise-title").fill("Evening watch");
    await page.locator("#exercise-save").click();
    await until("it is said", async () =>
      /already/.test(await text("#exercise-note")));
    // As it was.
    await daemon.patch({ sea: { windSpeed: 2 }, entities: { 4: null } });
    await page.locator("#exercise-load").click();
    await until("loaded", async () => (await exercise())?.name ===
      "Evening-watch");
    const now = await daemon.state();
    assert.equal(now.sea.windSpeed, 11);
    assert.deepEqual(now.entities.map((e) => [e.id, e.latitude]),
      [[1, 52.61], [4, 52.62]]);
    await page.locator("#exercise-remove").click();
    assert.equal(await text("#exercise-remove"), "Sure?");
    await page.locator("#exercise-remove").click();
    await until("it is gone", () => !fs.existsSync(file("Evening-watch")));
    await until("nor is it listed", async () => !(await page.locator(
      "#exercise-list option").allTextContents()).some((t) => /Evening/.test(t)));
  });
});

describe("the editor", () => {
  const edit = async (name) => {
    await page.locator("#exercise-list").selectOption(name);
    await page.locator("#exercise-edit").click();
    await until("the editor", () => page.locator("#exercise-text").isVisible());
  };
  const body = async () => JSON.parse(
    await page.locator("#exercise-text").inputValue());
  const write = (value) => page.locator("#exercise-text").fill(
    typeof value === "string" ? value : JSON.stringify(value, null, 2));
  const selected = () => page.locator("#exercise-text").evaluate((t) =>
    t.value.slice(t.selectionStart, t.selectionEnd));

  test("has a good template of each condition", async () => {
    const schema = fs.readFileSync(path.join(ROOT, "proto/pelagos.proto"),
      "utf8");
    const fields = [...schema.match(/message ExerciseWhen \{([^}]*)\}/)[1]
      .matchAll(/optional \w+ (\w+) =/g)].map((m) =>
      m[1].replace(/_(\w)/g, (_, c) => c.toUpperCase()));
    await begin();
    await edit("fog");
    const kinds = await page.locator("#exercise-template option:not([value=''])")
      .evaluateAll((options) => options.map((o) => o.value));
    const before_ = (await body()).events.length;
    for (const [i, kind] of kinds.entries()) {
      await page.locator("#exercise-template").selectOption(kind);
      await until("another event", async () =>
        (await body()).events.length === before_ + i + 1);
      assert.match(await selected(), /^"event-\d+"$/);
    }
    const used = new Set((await body()).events.flatMap((e) =>
      Object.keys(e.when[0])));
    assert.deepEqual(fields.filter((f) => !used.has(f)), ["entity"]);
    await page.locator("#exercise-check").click();
    await until("it is good", async () => await text(
      "#exercise-editor [role=status]") === "It is a good one.");
    assert.equal(await text("#exercise-error"), "");
    assert.equal(JSON.parse(fs.readFileSync(file("fog"))).events.length, 3,
      "a check saves nothing");
    await page.locator("#exercise-keep").click();
    await until("saved", () => JSON.parse(fs.readFileSync(file("fog")))
      .events.length === 3 + kinds.length);
  });

  test("shows what is wrong, where it stands", async () => {
    await begin();
    await edit("fog");
    const wrong = async (change, says, where) => {
      const text_ = structuredClone(FOG);
      change(text_);
      await write(text_);
      await page.locator("#exercise-keep").click();
      await until(`${says}`, async () => says.test(await text("#exercise-error")));
      assert.equal(await selected(), where);
      assert.equal(await page.locator("#exercise-text").getAttribute(
        "aria-invalid"), "true");
    };
    await wrong((e) => { e.events[1].when[0].delay = -3; },
      /events\.rain\.when\.0\.delay/, '"delay"');
    await wrong((e) => { e.events[2].when[0].other = 77; },
      /events\.near\.when\.0\.other/, '"other"');
    await wrong((e) => { e.events[0].patch.state.sky.visibility = 1; },
      /visibility/, '"visibility"');
    await wrong((e) => { e.limits[0].speed = -1; }, /limits/, '"speed"');
    assert.deepEqual(JSON.parse(fs.readFileSync(file("fog"))), FOG, "unchanged");
    await shot("exercise-editor");
    await write('{"title": "x",}');
    await page.locator("#exercise-check").click();
    await until("no JSON", async () => /no JSON: .*(position|line)/.test(
      await text("#exercise-error")));
    await page.locator("#exercise-text").press("End");
    await page.locator("#exercise-text").press("Backspace");
    await until("it may be good now", async () =>
      await text("#exercise-error") === "");
    // By its title as another.
    await write({ ...FOG, title: "Night fog" });
    await page.locator("#exercise-copy").click();
    await until("another", () => fs.existsSync(file("Night-fog")));
    assert.deepEqual(JSON.parse(fs.readFileSync(file("fog"))), FOG);
  });
});

describe("the card", () => {
  for (const size of ["phone", "laptop"]) {
    test(`is fit for everybody (${size})`, async () => {
      await begin(size);
      await page.locator("#exercise-list").selectOption("fog");
      await page.locator("#exercise-load").click();
      await until("ready", async () =>
        await text("#exercise-phase") === "ready");
      await page.locator("#exercise-start").click();
      await until("running", async () =>
        (await exercise()).phase === "RUNNING");
      await step(10);
      await step(10);
      await step(2);
      await until("fog", () => page.locator(".exercise-events .fired").count());
      await until("facts", () => page.locator(".exercise-facts").isVisible());
      await page.locator("#exercise-edit").click();
      await until("the editor", () => page.locator("#exercise-text")
        .isVisible());
      await inside();
      await clean(`exercises (${size})`);
      const small = await page.locator("#exercises button:visible, " +
        "#exercises input:visible, #exercises select:visible").evaluateAll(
        (nodes) => nodes.filter((n) => n.getBoundingClientRect().height < 24 &&
          n.type !== "range").map((n) => n.outerHTML.slice(0, 90)));
      assert.deepEqual(small, [], "too small to touch");
      for (const theme of ["dark", "light"]) {
        await page.emulateMedia({ colorScheme: theme });
        for (const part of ["#exercise-list", "#exercise-to", ".exercise-facts",
          "#exercise-editor"]) {
          await page.locator(part).evaluate((n) => n.scrollIntoView());
          await shot(`exercises-${size}-${theme}-${part.replace(/^.(exercise-)?/,
            "")}`);
        }
      }
    });
  }

  test("shows the facts of the own ship that is chosen", async () => {
    const two = structuredClone(FOG);
    two.draught = 2;
    two.ships = [{ id: 3, draught: 4 }];
    two.state.entities[1].name = "ferry";
    fs.writeFileSync(file("two"), JSON.stringify(two));
    const lead = async (name) => {
      await page.locator("#exercise-list").selectOption(name);
      await page.locator("#exercise-load").click();
      await until("ready", async () => (await exercise())?.name === name &&
        await text("#exercise-phase") === "ready");
      await page.locator("#exercise-start").click();
      await until("running", async () =>
        (await exercise()).phase === "RUNNING");
      await step(8.5);
      await until("8 s", async () => await text("#exercise-time") === "0:08.5");
    };
    await begin();
    await lead("two");
    await until("facts", () => page.locator("#exercise-ship").isVisible());
    await until("its name", async () => (await page.locator(
      "#exercise-ship option").allTextContents()).join() === "1,3, ferry");
    assert.equal(await text(".exercise-facts tbody th"), "3");
    await page.locator("#exercise-ship").selectOption("3");
    await until("of ship 3", async () =>
      await text(".exercise-facts tbody th") === "1");
    const of = async (ship) => {
      const csv = await (await fetch(
        `${daemon.url}/v1/exercise.csv?ship=${ship}`)).text();
      const lines = csv.trim().split("\n").map((line) => line.split(","));
      return { csv, last: Object.fromEntries(lines[0].map((name, i) =>
        [name, lines.at(-1)[i]])) };
    };
    const [first, third] = [await of(1), await of(3)];
    assert.notEqual(first.last.speed_mps, third.last.speed_mps);
    await until("hers", async () => await figure("speed_mps") ===
      `${Number(third.last.speed_mps).toFixed(1)} m/s`);
    const kept = await saved(() => page.locator("#exercise-csv").click());
    assert.equal(path.basename(kept), "two-3.csv");
    assert.equal(fs.readFileSync(kept, "utf8"), third.csv);
    await page.locator("#exercise-ship").evaluate((n) => n.scrollIntoView());
    await shot("exercise-ships");
    await page.locator("#exercise-ship").selectOption("1");
    await until("of ship 1", async () => await figure("speed_mps") ===
      `${Number(first.last.speed_mps).toFixed(1)} m/s`);

    // A template about the one that is chosen.
    await page.locator("#exercise-edit").click();
    await until("the editor", () => page.locator("#exercise-about")
      .isVisible());
    await page.locator("#exercise-about").selectOption("3");
    await page.locator("#exercise-template").selectOption({
      label: "Closer than" });
    const events = async () => JSON.parse(
      await page.locator("#exercise-text").inputValue()).events;
    assert.deepEqual((await events()).at(-1).when,
      [{ entity: 3, other: 1, rangeBelow: 1852 }]);
    assert.equal(await page.locator("#exercise-about").inputValue(), "3");
    await page.locator("#exercise-template").selectOption({
      label: "At a time" });
    assert.deepEqual((await events()).at(-1).when, [{ at: 60 }]);
    await page.locator("#exercise-check").click();
    await until("it is good", async () => await text(
      "#exercise-editor [role=status]") === "It is a good one.");
    await clean("exercises, several own ships");

    // With one there is nothing to choose.
    await lead("fog");
    await until("facts", () => page.locator(".exercise-facts").isVisible());
    assert.ok(await page.locator("#exercise-ship").isHidden());
    await page.locator("#exercise-edit").click();
    await until("of fog", async () => !(await page.locator("#exercise-text")
      .inputValue()).includes("draught"));
    assert.ok(await page.locator("#exercise-about").isHidden());
  });

  test("is led by keys alone", async () => {
    await begin();
    const tab = async (id) => until(`the focus at ${id}`, async () => {
      await page.keyboard.press("Tab");
      return page.evaluate((wanted) => document.activeElement.id === wanted, id);
    });
    await page.locator("#exercises > summary").focus();
    await tab("exercise-list");
    await page.keyboard.press("ArrowDown");
    await tab("exercise-load");
    await page.keyboard.press("Enter");
    await until("ready", async () => (await exercise())?.phase === "READY");
    await tab("exercise-start");
    await page.keyboard.press("Space");
    await until("running", async () => (await exercise()).phase === "RUNNING");
    await step(8);
    await until("8 s", async () => await text("#exercise-time") === "0:08.0");
    await tab("exercise-to");
    for (let i = 0; i < 3; i++) {
      await page.keyboard.press("ArrowLeft");
    }
    await tab("exercise-rewind");
    await page.keyboard.press("Enter");
    await until("5 s", async () => (await exercise()).time === 5);
  });

  test("hands out the facts where a token is asked for too", async () => {
    const tokens = path.join(folder(), "token");
    fs.writeFileSync(tokens, TOKEN, { mode: 0o600 });
    const asking = await Daemon.start(["--token-file", tokens, "--exercises",
      home]);
    asking.token = TOKEN;
    try {
      await begin("laptop", `${asking.url}/#token=${TOKEN}`);
      await page.locator("#exercise-list").selectOption("fog");
      await page.locator("#exercise-load").click();
      await until("ready", async () =>
        await text("#exercise-phase") === "ready");
      await page.locator("#exercise-start").click();
      await until("facts", () => page.locator("#exercise-csv").isVisible());
      const csv = await saved(() => page.locator("#exercise-csv").click());
      assert.match(fs.readFileSync(csv, "utf8"), /^time_s,clock_s,/);
    } finally {
      await asking.stop();
    }
  });

  test("asks for its list when that is opened", async () => {
    await begin();
    const asks = [];
    page.on("request", (r) => asks.push(new URL(r.url()).pathname));
    fs.writeFileSync(file("later"), JSON.stringify(FOG));
    await until("three states", () => asks.filter((a) => a === "/v1/state")
      .length >= 3);
    assert.deepEqual(asks.filter((a) => /exercise/.test(a)), []);
    await page.locator("#exercise-list").focus();
    await until("it is listed", async () => (await page.locator(
      "#exercise-list option").allTextContents()).length === 3);
  });

  test("asks for nothing while it is closed", async () => {
    await open(daemon.url, at("laptop"));
    await ready();
    const asks = [];
    page.on("request", (r) => asks.push(new URL(r.url()).pathname));
    await until("two states", () => asks.filter((a) => a === "/v1/state").length
      >= 2);
    assert.deepEqual(asks.filter((a) => /exercise/.test(a)), []);
  });
});
