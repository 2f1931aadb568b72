#!/usr/bin/env node
// The page's controls in a real browser: what they offer, what they set, and
// that on a slow link nothing is set back or goes elsewhere.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import { beforeEach, describe, test } from "node:test";

import { daemon, fresh, open, openSections, page, pictures, shot, slide, state,
  text, view } from "./page.mjs";
import { sleep, until } from "./pelagos_daemon.mjs";

describe("controls", () => {
  beforeEach(async () => {
    await fresh();
    await open(daemon.url);
    await openSections();
  });

  test("are complete, and bound to the schema's ranges", async () => {
    const fields = new Map((await daemon.request("GET", "/v1/fields"))
      .fields.map((f) => [f.path, f]));
    await daemon.patch({ sea: { swell: [{}] } });
    const found = await page.locator("[data-path]").evaluateAll((nodes) =>
      nodes.map((n) => ({ ...n.dataset, options:
        [...n.querySelectorAll("option")].map((o) => o.value) })));
    const shown = new Map(found.map((f) => [f.path, f]));
    await until("a train", () => page.locator("#swell-train").isVisible());
    const wide = await page.locator(".control:visible > *").evaluateAll(
      (nodes) => nodes.filter((n) => n.getBoundingClientRect().right >
        n.closest(".section").getBoundingClientRect().right)
        .map((n) => n.outerHTML));
    assert.deepEqual(wide, [], "wider than their section");
    for (const part of ["sea.windSpeed", "sea.windDirection",
      ...["height", "period", "direction", "spread"].map((n) =>
        `sea.swell.*.${n}`), "sky.sunElevation", "sky.sunAzimuth",
      "sky.visibility", ...["chlorophyll", "jerlov", "named", "depth",
        "bottom", "absorption680", "scattering440"].map((n) => `water.${n}`),
      ...["yaw", "pitch", "roll", "up", "forward", "right", "fieldOfView",
        "exposure", "tone", "vision", "glare"].map((n) => `views.*.${n}`)]) {
      assert.ok(shown.has(part), `a control for ${part}`);
    }
    for (const [name, control] of shown) {
      const field = fields.get(name);
      if (control.minimum !== undefined) {
        assert.deepEqual([Number(control.minimum), Number(control.maximum)],
          [field.minimum, field.maximum], name);
      } else {
        assert.deepEqual(control.options, field.values.filter((value) =>
          !(field.unusable ?? []).includes(value)), name);
      }
    }
  });

  test("set the state, and show what others set", async () => {
    await slide("wind-speed", 14.5);
    await until("the wind", async () => (await state()).sea.windSpeed === 14.5);
    await until("the rose", async () =>
      /14.5 m\/s, force 7/.test(await text("#rose-wind")));
    await daemon.patch({ sea: { windSpeed: 3.5 } });
    await until("the slider", async () =>
      await page.locator("#wind-speed").inputValue() === "3.5");
    await page.locator("#sun-clock").click();
    await until("a fixed Sun", async () =>
      (await state()).sky.sunElevation === 30);
    await slide("sun-elevation", 12);
    await until("its elevation", async () =>
      (await state()).sky.sunElevation === 12);
    await slide("heading", 123);
    await until("the heading", async () =>
      (await state()).entities[0].heading === 123);
    // Sliders bent for decades end at the ends of the range.
    for (const [x, metres] of [[0, 200], [1000, 300000]]) {
      await slide("visibility", x);
      await until(`visibility ${metres}`, async () =>
        (await state()).sky.visibility === metres);
    }
    for (const [x, metres] of [[0, -100], [1000, 1e7]]) {
      await slide("up", x);
      await until(`up ${metres}`, async () => (await view()).up === metres);
    }
    await shot("controls");
  });

  test("make several trains of swell", async () => {
    await page.locator("#swell-on").click();
    await until("a swell", async () => (await state()).sea.swell?.length === 1);
    await slide("swell-height", 2.5);
    await until("its height", async () =>
      (await state()).sea.swell[0].height === 2.5);
    await page.getByRole("button", { name: "Add a train of swell" }).click();
    await until("two", async () => (await state()).sea.swell.length === 2);
    await slide("swell-period", 15);
    await until("the second's period", async () => {
      const { swell } = (await state()).sea;
      return swell[1].period === 15 && swell[0].height === 2.5;
    });
    await page.getByRole("button", { name: "Remove this train" }).click();
    await until("the first is left", async () => {
      const { swell } = (await state()).sea;
      return swell.length === 1 && swell[0].height === 2.5;
    });
  });

  test("describe the water in each way", async () => {
    await slide("chlorophyll", 1000);
    await until("chlorophyll", async () =>
      (await state()).water.chlorophyll === 30);
    await page.locator("#water-way").selectOption("jerlov");
    await until("a type", async () => (await state()).water.jerlov === "IB");
    await until("its choice", () => page.locator("#jerlov").isVisible());
    await page.locator("#jerlov").selectOption("C7");
    await until("another", async () => (await state()).water.jerlov === "C7");
    await page.locator("#water-way").selectOption("numbers");
    await until("coefficients", async () => {
      const { water } = await state();
      return water.absorption680 > 0 && water.jerlov === undefined;
    });
    await page.locator("#water-way").selectOption("chlorophyll");
    await until("none of them", async () =>
      (await state()).water.absorption680 === undefined);
  });

  test("explain what is refused", async () => {
    const entry = page.locator(".control:has(#wind-speed) input[type=number]");
    await entry.fill("99");
    const error = page.locator("#wind-speed-error");
    await until("the error", async () =>
      /0 to 30 m\/s/.test(await error.textContent()));
    await shot("refused");
    assert.equal((await state()).sea.windSpeed, 8);
    await entry.fill("9");
    await until("the wind", async () => (await state()).sea.windSpeed === 9);
    await until("no error", () => error.isHidden());
  });
});

describe("on a slow link", () => {
  const SLOW_MS = 300;
  beforeEach(async () => {
    await fresh();
    await open(daemon.url);
    await openSections();
    await page.route("**/v1/state", async (route) => {
      await sleep(SLOW_MS);
      await route.continue().catch(() => {}); // the page is closed
    });
  });

  // Every value that a control shows from now on.
  const watch = (id) => page.locator(`#${id}`).evaluate((node) => {
    const seen = [];
    window.pelagosSeen = seen;
    setInterval(() => {
      if (seen.at(-1) !== node.value) {
        seen.push(node.value);
      }
    }, 5);
  });
  const seen = () => page.evaluate(() => window.pelagosSeen);
  const swell = async () => (await state()).sea.swell ?? [];

  test("nothing older sets back what a person sets", async () => {
    await slide("wind-speed", 10);
    await watch("wind-speed");
    for (const speed of [11, 12, 13]) {
      await slide("wind-speed", speed);
      await sleep(SLOW_MS);
    }
    await until("the wind", async () => (await state()).sea.windSpeed === 13);
    await sleep(3 * SLOW_MS);
    const order = (await seen()).map(Number);
    assert.deepEqual(order, [10, 11, 12, 13]);
  });

  test("nor what a person holds, until it is let go", async () => {
    await page.locator("#wind-speed").scrollIntoViewIfNeeded();
    const box = await page.locator("#wind-speed").boundingBox();
    const y = box.y + box.height / 2;
    await page.mouse.move(box.x + box.width / 2, y);
    await page.mouse.down();
    await until("the middle", async () =>
      Math.abs((await state()).sea.windSpeed - 15) < 0.5);
    await watch("wind-speed");
    await daemon.patch({ sea: { windSpeed: 3 } });
    await sleep(1000 + 3 * SLOW_MS);
    assert.equal((await seen()).length, 1);
    await page.mouse.up();
    await until("what others set", async () =>
      await page.locator("#wind-speed").inputValue() === "3");
  });

  test("each change goes where it was meant", async () => {
    await daemon.patch({ views: { stern: { name: "stern", entity: 1, width: 320,
      height: 180, yaw: 180 } } });
    await pictures(2);
    await slide("yaw", 7);
    await page.locator("#view-name").selectOption("stern");
    await slide("yaw", 170);
    await slide("pitch", -3);
    await until("yaw and pitch of both", async () => {
      const [a, b] = (await state()).views;
      return a.yaw === 7 && a.pitch === 0 && b.yaw === 170 && b.pitch === -3;
    });
  });

  test("a view that is deleted in one's hand stays so", async () => {
    await daemon.patch({ views: { stern: { name: "stern", entity: 1, width: 320,
      height: 180, yaw: 180 } } });
    await pictures(2);
    await page.locator("#view-name").selectOption("stern");
    await page.locator("#yaw").focus();
    await daemon.request("DELETE", "/v1/views/stern");
    await slide("yaw", 90);
    await until("the choice of another", async () =>
      await page.locator("#view-name").inputValue() === "bridge");
    await slide("yaw", 60);
    await sleep(3 * SLOW_MS);
    assert.deepEqual((await state()).views.map((v) => [v.name, v.yaw]),
      [["bridge", 0]]);
  });

  test("keys turn from where the view is to be", async () => {
    for (let i = 0; i < 5; i++) {
      await page.keyboard.press("ArrowRight");
      await sleep(0.7 * SLOW_MS);
    }
    await until("yaw 25", async () => (await view()).yaw === 25);
  });

  test("trains of swell are made and set without waiting", async () => {
    const add = page.getByRole("button", { name: "Add a train of swell" });
    await page.locator("#swell-on").click();
    await slide("swell-height", 2.5);
    await add.click();
    await slide("swell-period", 15);
    await slide("swell-height", 0.5);
    await add.click();
    await slide("swell-direction", 90);
    await page.locator("#swell-train").selectOption({ index: 0 });
    await slide("swell-spread", 20);
    await until("three trains", async () => {
      const [a, b, c] = await swell();
      return a?.height === 2.5 && a.period === 10 && a.spread === 20 &&
        b?.height === 0.5 && b.period === 15 && b.spread === 10 &&
        c?.height === 1 && c.direction === 90 && c.spread === 10;
    });
  });

  test("a train is known again when others change the list", async () => {
    await daemon.patch({ sea: { swell: [1, 2, 3].map((height) =>
      ({ height })) } });
    const trains = page.locator("#swell-train");
    await until("three", async () =>
      await trains.locator("option").count() === 3);
    await trains.selectOption({ index: 1 });
    await slide("swell-period", 12);
    await sleep(SLOW_MS / 2); // on its way, made of the old list
    await daemon.patch({ sea: { swell: [2, 3].map((height) =>
      ({ height })) } });
    await until("the same train's period", async () => {
      const list = await swell();
      return list.length === 2 && list[0].period === 12 &&
        list[1].period === 10 && list[1].height === 3;
    });
    await until("its choice", async () =>
      /^1: 2 m/.test(await trains.locator("option:checked").textContent()));
  });
});
