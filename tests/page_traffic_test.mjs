#!/usr/bin/env node
// Ships and marks on the page, in a real browser: the list, the plan by mouse,
// finger and keys, what is refused, views that follow, scenes.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import { beforeEach, describe, test } from "node:test";

import { daemon, fresh, open, openSections, page, shot, slide, state, text,
  view } from "./page.mjs";
import { sleep, until } from "./pelagos_daemon.mjs";

const RAD = Math.PI / 180;
const M_PER_DEGREE = 111267; // of latitude 52.6, WGS 84
const HERE = { latitude: 52.6, longitude: 5.2 };

const entity = async (name) =>
  (await state()).entities.find((e) => e.name === name);
// Metres east and north of own ship's place, by a sphere of its own radius.
const away = (e) => [(e.longitude - HERE.longitude) * RAD * 6391300 *
  Math.cos(52.6 * RAD), (e.latitude - HERE.latitude) * M_PER_DEGREE];
const near = (a, b, by) => Math.abs(a - b) <= by;

// A place on the plan, in metres east and north of its middle.
async function spot(east, north) {
  const canvas = page.locator("#plan");
  await canvas.scrollIntoViewIfNeeded();
  const box = await canvas.boundingBox();
  const scale = Number(await canvas.getAttribute("data-scale"));
  return [box.x + box.width / 2 + east / scale,
    box.y + box.height / 2 - north / scale];
}

async function begin(options) {
  await fresh();
  await open(daemon.url, options);
  await openSections();
  await until("the models", () => page.locator("#add-model option").count());
  await until("the plan", () =>
    page.locator("#plan").getAttribute("data-scale"));
}

const still = (id, name, north, more = {}) => ({ [id]: { name, ...HERE,
  latitude: HERE.latitude + north / M_PER_DEGREE, afloat: true,
  model: { name: "tug" }, ...more } });

describe("the plan", () => {
  beforeEach(() => begin());

  test("offers every model, and puts one where it is clicked", async () => {
    const { models } = await daemon.request("GET", "/v1/models");
    assert.deepEqual((await page.locator("#add-model option").evaluateAll(
      (nodes) => nodes.map((n) => n.value))).sort(),
    models.map((m) => m.name).sort());
    await page.locator("#add-model").selectOption("tanker");
    const [x, y] = await spot(150, 240);
    await page.mouse.click(x, y);
    const made = await until("a tanker", () => entity("tanker"));
    const [east, north] = away(made);
    // A pixel is 3 m.
    assert.ok(near(east, 150, 4) && near(north, 240, 4), `${east} ${north}`);
    assert.deepEqual([made.model.name, made.speed, made.afloat],
      ["tanker", 0, true]);
    await until("its controls", async () =>
      await text("#ship-edited") === "tanker" &&
      await page.locator("#ship-length").isVisible());
    await until("its row: distance and bearing from the camera", async () =>
      /tanker.*28\d m03[123]°0\.0 kn$/.test(await page.locator(
        "#traffic tr:has([aria-pressed=true])").textContent()));
    await shot("plan");
  });

  test("pulling away gives course and speed, not to a buoy", async () => {
    for (const [model, speed] of [["ferry", true],
      ["lateral-port-a", false]]) {
      await page.locator("#add-model").selectOption(model);
      const [x, y] = await spot(-100, 0);
      const [tx, ty] = await spot(200, 0);
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(tx, ty, { steps: 4 });
      await page.mouse.up();
      const made = await until(model, () =>
        entity(model.replaceAll("-", " ")));
      assert.equal(made.course, 90);
      // 300 m in the minute of its arrows.
      assert.ok(near(made.speed, speed ? 5 : 0, speed ? 0.11 : 0),
        `${made.speed}`);
    }
  });

  test("carries things by the mouse, and is moved beside them", async () => {
    await daemon.patch({ entities: still(7, "Stevin", 150) });
    await until("its row", () => page.locator("#traffic tr").count()
      .then((n) => n === 2));
    const [x, y] = await spot(0, 150);
    const [tx, ty] = await spot(-180, 90);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(tx, ty, { steps: 6 });
    await page.mouse.up();
    await until("its new place", async () => {
      const [east, north] = away(await entity("Stevin"));
      return near(east, -180, 7) && near(north, 90, 7);
    });
    await sleep(500); // what the hand asked for last has come
    const before = await state();
    await page.mouse.move(...await spot(100, -100));
    await page.mouse.down();
    await page.mouse.move(...await spot(0, 0), { steps: 4 });
    await page.mouse.up();
    await sleep(500);
    assert.equal((await state()).revision, before.revision,
      "moving the plan moves no ship");
    // The plan's middle lies 100 m to the east, 100 m to the south.
    await page.locator("#add-model").selectOption("rib");
    // As the introduction says it: choose, press, click. A second press ends it.
    const armed = () => page.locator("#add").getAttribute("aria-pressed");
    assert.equal(await armed(), "true", "choosing arms");
    await page.locator("#add").click();
    assert.equal(await armed(), "true", "the button does not take that away");
    await page.locator("#add").click();
    assert.equal(await armed(), "false");
    await page.locator("#add").click();
    await page.mouse.click(...await spot(0, 0));
    const [east, north] = away(await until("a boat", () => entity("rib")));
    assert.ok(near(east, 100, 8) && near(north, -100, 8), `${east} ${north}`);
  });

  test("head up turns it", async () => {
    await daemon.patch({ entities: { 1: { heading: 90 } } });
    await page.locator("#plan-up").click();
    assert.equal(await text("#plan-up"), "Head up");
    await until("the heading", async () =>
      await text("#rose-ship") === "090°");
    await page.locator("#add-model").selectOption("person");
    await page.mouse.click(...await spot(0, 150)); // ahead: east
    const [east, north] = away(await until("a person", () =>
      entity("person")));
    assert.ok(near(east, 150, 5) && near(north, 0, 5), `${east} ${north}`);
  });

  test("by keys: choose, move, put, remove", async () => {
    await daemon.patch({ entities: still(7, "Stevin", 150) });
    await until("its row", () => page.locator("#traffic tr").count()
      .then((n) => n === 2));
    await page.locator("#plan").focus();
    await page.keyboard.press("PageDown");
    await page.keyboard.press("PageDown");
    await until("its name", async () =>
      await text("#ship-edited") === "Stevin");
    await page.keyboard.press("Shift+ArrowRight");
    await until("8 pixels to the east", async () =>
      near(away(await entity("Stevin"))[0], 24, 2));
    assert.equal((await view()).yaw, 0, "pictures do not turn meanwhile");
    await page.keyboard.press("Delete");
    await until("it is gone", async () => !await entity("Stevin"));
    await page.locator("#add-model").selectOption("beacon");
    await page.locator("#plan").focus();
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("Enter");
    const made = await until("a beacon", () => entity("beacon"));
    assert.ok(near(away(made)[1], 72, 3), `${away(made)}`);
  });

  test("says why it is refused, with a cure", async () => {
    await daemon.patch({ entities: Object.fromEntries([...Array(255).keys()]
      .map((i) => [i + 2, { name: `t${i}` }])) });
    await page.locator("#add-model").selectOption("rib");
    await page.mouse.click(...await spot(0, 90));
    await until("the limit", async () =>
      /256/.test(await text("#plan-note")));
    assert.ok(await page.locator("#plan-note.error").isVisible());
    await shot("plan-full");
  });
});

describe("many", () => {
  test("256 things are drawn and listed, in few requests", async () => {
    await begin();
    await daemon.patch({ entities: Object.fromEntries([...Array(255).keys()]
      .map((i) => [i + 2, { name: `t${i}`, speed: 5, course: i,
        latitude: 52.6 + (i % 16 - 8) / 1000,
        longitude: 5.2 + (i / 16 - 8) / 600 }])) });
    await until("all rows", async () =>
      await page.locator("#traffic tr").count() === 256);
    // The sea-state card has questions of its own while it is open.
    await page.locator("#sea-state > summary").click();
    await until("its last answer", async () => {
      const before = await page.evaluate(() =>
        performance.getEntriesByType("resource").filter((r) =>
          /surface|spectrum/.test(r.name)).length);
      await sleep(2500);
      return before === await page.evaluate(() =>
        performance.getEntriesByType("resource").filter((r) =>
          /surface|spectrum/.test(r.name)).length);
    });
    let asked = 0;
    page.on("request", () => {
      asked += 1;
    });
    await page.getByRole("button", { name: "Plan: show everything" }).click();
    await sleep(5000);
    // The state once a second, and pictures by a socket.
    assert.ok(asked <= 8, `${asked} requests in 5 s`);
    const ms = await page.evaluate(async () => {
      const canvas = document.getElementById("plan");
      const g = canvas.getContext("2d");
      const taken = [];
      const fill = g.fillRect;
      await new Promise((done) => {
        g.fillRect = function count(...a) {
          taken.push(performance.now());
          fill.apply(this, a);
          if (taken.length > 5) {
            done();
          }
        };
      });
      delete g.fillRect;
      return (taken.at(-1) - taken[0]) / (taken.length - 1);
    });
    console.log(`the plan of 256 is drawn every ${ms.toFixed(0)} ms`);
    await shot("plan-many");
  });
});

describe("on a phone", () => {
  test("a finger puts and moves things, two zoom", async () => {
    await begin({ viewport: { width: 390, height: 844 }, hasTouch: true,
      isMobile: true, deviceScaleFactor: 2 });
    const cdp = await page.context().newCDPSession(page);
    const touch = (type, ...points) => cdp.send("Input.dispatchTouchEvent", {
      type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    await page.locator("#add-model").selectOption("tug");
    let at = await spot(0, 120);
    await touch("touchStart", at);
    await touch("touchEnd");
    await until("a tug", () => entity("tug"));
    await sleep(600);
    at = await spot(0, 120);
    await touch("touchStart", at);
    for (let i = 1; i <= 5; i++) {
      await touch("touchMove", [at[0] + 6 * i, at[1]]);
    }
    await touch("touchEnd");
    await until("30 pixels to the east", async () =>
      near(away(await entity("tug"))[0], 90, 5));
    const [x, y] = await spot(0, 0);
    await touch("touchStart", [x - 30, y - 60], [x + 30, y - 60]);
    for (let i = 1; i <= 5; i++) {
      await touch("touchMove", [x - 30 - 6 * i, y - 60],
        [x + 30 + 6 * i, y - 60]);
    }
    await touch("touchEnd");
    await until("twice as large", async () => near(Number(
      await page.locator("#plan").getAttribute("data-scale")), 1.5, 0.05));
    await shot("plan-phone");
  });
});

describe("without a picture", () => {
  test("scenes and the plan work all the same", async () => {
    await fresh();
    await daemon.patch({ views: null });
    await open(daemon.url, { wait: false });
    await openSections();
    await page.getByRole("button", { name: "Scene: harbour" }).click();
    await until("its things", async () =>
      (await state()).entities.length === 20);
    await until("their rows", async () =>
      await page.locator("#traffic tr").count() === 20);
  });
});

describe("a thing", () => {
  beforeEach(async () => {
    await begin();
    await daemon.patch({ entities: still(7, "Stevin", 150) });
    await until("its row", () => page.locator("#traffic tr").count()
      .then((n) => n === 2));
    await page.locator("#traffic tr").nth(1).locator("button").click();
    await until("its name", async () =>
      await text("#ship-edited") === "Stevin");
  });

  test("is changed and removed", async () => {
    await until("a tug's length", async () => await page.locator(
      ".control:has(#ship-length) .entry").inputValue() === "32");
    await page.locator(".control:has(#ship-length) .entry").fill("40");
    await until("40 m", async () =>
      (await entity("Stevin")).model.length === 40);
    await until("its beam follows", async () => await page.locator(
      ".control:has(#ship-beam) .entry").inputValue() === "14.5");
    await page.locator("#ship-colour").fill("#aa3311");
    await until("red", async () =>
      (await entity("Stevin")).model.colour === 0xaa3311);
    await slide("course", 45);
    await slide("speed", 6);
    await until("course and speed", async () => {
      const { course, speed } = await entity("Stevin");
      return course === 45 && speed === 6;
    });
    await page.locator("#ship-model").selectOption("ferry");
    await until("a ferry of its own length", async () => {
      const { model } = await entity("Stevin");
      return model.name === "ferry" && model.length === undefined;
    });
    await page.locator("#ship-lights").selectOption("AUTO");
    await page.locator("#ship-status").selectOption("TOWING");
    await page.locator("#ship-light").fill("Fl(2) R 10s");
    await page.locator("#ship-light").press("Enter");
    await page.locator("#searchlight").check();
    await until("its lights", async () => {
      const { lights, navigationStatus, light, searchlight } =
        await entity("Stevin");
      return lights === "AUTO" && navigationStatus === "TOWING" &&
        light?.character === "Fl(2) R 10s" && searchlight?.on === true;
    });
    await page.locator("#ship-name").fill("Wagenborg");
    await page.locator("#ship-name").press("Enter");
    await until("its name", () => entity("Wagenborg"));
    await page.locator("#remove").click();
    await until("it is gone", async () => !await entity("Wagenborg"));
  });

  test("is not set out of range, and the page says which", async () => {
    await page.locator(".control:has(#ship-length) .entry").fill("2000");
    await until("value, range and what to do", async () =>
      /2000 m.*0\.1 to 1000 m/.test(await text("#ship-length-error")));
    assert.equal((await entity("Stevin")).model.length, undefined);
  });

  test("that stands without new poses goes on", async () => {
    await daemon.patch({ clock: { reckoning: 1 },
      entities: { 7: { speed: 3, course: 90 } } });
    await until("that it stands", () => page.locator("#standing").isVisible());
    await sleep(1500);
    const before = away(await entity("Stevin"));
    await page.locator("#go-on").click();
    await until("a long time", async () =>
      (await state()).clock.reckoning === 86400);
    // From where it stood, 3 m on, not from where it would be by now.
    const [east] = away(await entity("Stevin"));
    assert.ok(near(east - before[0], 3, 0.5), `${east - before[0]} m`);
    await until("that none stands", () => page.locator("#standing").isHidden());
  });

  test("is looked at and followed, from its bridge too", async () => {
    await page.locator("#look-at").click();
    await until("ahead", async () => near((await view()).yaw, 0, 0.2));
    await page.locator("#follow-it").click();
    await until("from behind, level", async () => {
      const v = await view();
      return v.entity === 7 && v.level === true && near(v.yaw, 0, 0.1) &&
        v.forward < -40 && near(v.right, 0, 0.1) && v.pitch < 0;
    });
    await until("the way", async () =>
      await page.locator("#view-way").inputValue() === "chase");
    await slide("orbit", 90);
    await until("from starboard", async () => {
      const v = await view();
      return near(v.yaw, -90, 0.1) && near(v.forward, 0, 0.1) && v.right > 40;
    });
    await shot("orbit");
    await page.locator("#view-way").selectOption("eye 0");
    const { models } = await daemon.request("GET", "/v1/models");
    const [eye] = models.find((m) => m.name === "tug").eyes;
    await until("its bridge", async () => {
      const v = await view();
      return near(v.forward, eye.forward, 0.01) && near(v.up, eye.up, 0.01) &&
        v.level === false && v.yaw === 0;
    });
    await page.locator("#view-entity").selectOption("place");
    await until("a place", async () => {
      const v = await view();
      return v.entity === undefined && v.at?.latitude !== undefined;
    });
    const entry = page.locator(
      "[data-path='views.*.at.longitude'] input.entry");
    await entry.fill("-157.5");
    await until("another", async () => (await view()).at.longitude === -157.5);
    await page.locator("#view-entity").selectOption("");
    await until("the world", async () => {
      const v = await view();
      return v.entity === undefined && v.at === undefined;
    });
  });
});

describe("scenes", () => {
  beforeEach(() => begin());

  test("set wind, Sun and air at once", async () => {
    const press = (name) => page.getByRole("button",
      { name: `Scene: ${name}` }).click();
    await press("storm");
    await until("a storm", async () => {
      const { sea } = await state();
      return sea.windSpeed === 24 && sea.swell.length === 1;
    });
    await press("sunset");
    await until("a low Sun near the bow", async () => {
      const { sky, sea } = await state();
      return sky.sunElevation === 3 && sky.sunAzimuth === 12 &&
        sea.windSpeed === 5;
    });
    await press("calm");
    await until("no swell", async () => {
      const { sea } = await state();
      return sea.windSpeed === 2 && (sea.swell ?? []).length === 0;
    });
  });

  test("the harbour brings its traffic, once", async () => {
    await daemon.patch({ entities: { 1: { heading: 90 } } });
    await until("the heading", async () =>
      await text("#rose-ship") === "090°");
    for (let i = 0; i < 2; i++) {
      await page.getByRole("button", { name: "Scene: harbour" }).click();
      await until("its things", async () =>
        (await state()).entities.length === 20);
      await sleep(600);
    }
    assert.equal((await state()).entities.length, 20);
    const [east, north] = away(await entity("red 2"));
    assert.ok(near(east, 420, 2) && near(north, 95, 2),
      `to port of the channel: ${east} ${north}`);
    const ship = await entity("Maasvlakte");
    assert.deepEqual([ship.course, ship.heading], [270, 270]);
    await page.locator("#clear").click();
    await until("a question", async () =>
      /Really remove 19/.test(await text("#clear")));
    assert.equal((await state()).entities.length, 20);
    await page.locator("#clear").click();
    await until("own ship alone", async () =>
      (await state()).entities.length === 1);
    await page.getByRole("button", { name: "Scene: harbour" }).click();
    await until("its things", async () =>
      (await state()).entities.length === 20);
    await page.keyboard.press("p");
    await until("the large plan", () =>
      page.locator("#plan-large #plan").isVisible());
    await sleep(1500);
    await shot("harbour");
  });
});

test("own ship's shape takes the camera to its bridge", async () => {
  await fresh();
  await daemon.patch({ views: [
    { name: "bridge", entity: 1, up: 15, yaw: 20, width: 320, height: 180 },
    { name: "mast", entity: 1, up: 90, forward: 3, width: 320, height: 180 },
    { name: "shore", width: 320, height: 180 }] });
  await open(daemon.url);
  await openSections();
  await until("the models", () =>
    page.locator("#ship-model option[value=container-ship]").count());
  await page.locator("#ship-id").selectOption("1");
  await page.locator("#ship-model").selectOption("container-ship");
  let models;
  await until("their eye points", async () => {
    ({ models } = await daemon.request("GET", "/v1/models"));
    return ["container-ship", "tug"].every((name) =>
      models.find((m) => m.name === name).eyes);
  });
  const [eye] = models.find((m) => m.name === "container-ship").eyes;
  const views = async () => Object.fromEntries((await state()).views.map((v) =>
    [v.name, v]));
  await until("her bridge", async () => {
    const { bridge } = await views();
    return Math.abs(bridge.forward - eye.forward) < 0.02 &&
      Math.abs(bridge.up - eye.up) < 0.02 && bridge.yaw === 20;
  });
  const { mast, shore } = await views();
  assert.deepEqual([mast.up, mast.forward, shore.up], [90, 3, 10],
    "what stands outside her stays");
  assert.equal(await page.locator("#view-way").inputValue(), "eye 0");
  await page.locator("#ship-model").selectOption("tug");
  const tug = models.find((m) => m.name === "tug").eyes[0];
  await until("a tug's", async () =>
    Math.abs((await views()).bridge.up - tug.up) < 0.02);
});

test("a ship that outran her reckoning is no silent input", async () => {
  await fresh();
  const { time } = (await state()).clock;
  await daemon.patch({ clock: { mode: "STEPPED" }, entities: { 5: {
    name: "Stevin", latitude: 52.601, longitude: 5.2, speed: 4,
    poseTime: time } } });
  await daemon.request("POST", "/v1/clock/step", { seconds: 90 });
  await open(daemon.url);
  await until("what stands", async () => await page.locator(".stale-note")
    .isVisible() && await text(".stale-note"));
  assert.equal(await text(".stale-note"),
    "Stevin stands: no new pose for 60 s");
  assert.equal(await page.locator("#silent").isVisible(), false);
  await daemon.patch({ entities: { 5: null }, clock: { mode: "FREE" } });
});
