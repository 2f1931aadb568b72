#!/usr/bin/env node
// The page's card of an exercise's machines: two daemons on one log, seen from
// the one that follows; the other is killed, and this one takes over.
//
// Skipped (77) without etcd, Chromium or playwright-core. Screenshots:
// build/page/.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import fs from "node:fs";
import path from "node:path";
import { after, before, describe, test } from "node:test";

import { at, clean, inside, only, open, page, ready, shot, text }
  from "./page.mjs";
import { Daemon, folder, freePort, until } from "./pelagos_daemon.mjs";

if (spawnSync("etcd", ["--version"]).error) {
  console.log("skipped: no etcd (Debian: etcd-server)");
  process.exit(77);
}

const home = folder();
const nodes = new Map();
let store;

const cluster = (name) => nodes.get(name).request("GET", "/v1/cluster");
const row = (name) => page.locator(`.machine[data-node=${name}]`);

async function begin(name, url) {
  nodes.set(name, await Daemon.start(["--exercise", `${url}/bridge`,
    "--exercise-node", name, "--realtime", "off", "--waves", "20"]));
  await until(`${name} takes part`, async () =>
    ["MASTER", "FOLLOWER"].includes((await cluster(name)).role));
}

before(async () => {
  const [client, peer] = [await freePort(), await freePort()];
  const url = `http://127.0.0.1:${client}`;
  const own = `http://127.0.0.1:${peer}`;
  store = spawn("etcd", ["--name", "s", "--data-dir", path.join(home, "etcd"),
    "--listen-client-urls", url, "--advertise-client-urls", url,
    "--listen-peer-urls", own, "--initial-advertise-peer-urls", own,
    "--initial-cluster", `s=${own}`], { stdio: "ignore" });
  await until("etcd answers", async () =>
    (await fetch(`${url}/health`)).ok);
  await begin("alpha", url);
  await begin("beta", url);
  await nodes.get("alpha").patch({ views: [{ name: "bridge", entity: 1,
    width: 320, height: 180 }] });
});

after(async () => {
  for (const node of nodes.values()) {
    await node.stop("SIGKILL");
  }
  store.kill("SIGKILL");
  await once(store, "exit");
  fs.rmSync(home, { recursive: true, force: true });
});

describe("the machines of an exercise", () => {
  test("are told, with what they draw and what is wrong", async () => {
    await open(nodes.get("beta").url, at("laptop"));
    await ready();
    await until("the card", () => page.locator("#machines:visible").count());
    await only("machines");
    await until("who takes edits", async () =>
      /^alpha takes the edits/.test(await text("#machines-head")));
    await until("both", async () => await page.locator(".machine").count() === 2);
    // Who has spoken once only may be one who is gone, and counts as silent.
    const phases = { alpha: "master", beta: "follows, here" };
    for (const [name, phase] of Object.entries(phases)) {
      await until(`${name}: ${phase}`, async () =>
        await row(name).locator(".phase").textContent() === phase);
    }
    const link = await row("alpha").locator("a").getAttribute("href");
    assert.match(link, /^http:\/\/127\.0\.0\.1:\d+/);
    await until("the view that this page shows", async () =>
      /draws bridge/.test(await row("beta").textContent()));
    assert.match(await row("alpha").textContent(), /draws no live view/);
    assert.match(await row("beta").textContent(),
      /frame \d+.*delay [\d.]+ ms, state [0-9a-f]{16}/);
    assert.ok(await row("beta").locator(".machine-fault").isHidden());
    await inside();
    await clean("machines");
    await shot("machines-laptop");

    // A view that is placed at the other.
    assert.ok(await page.locator("#machines-places").isHidden());
    await nodes.get("alpha").request("PUT", "/v1/cluster/place/bridge",
      { node: "alpha" });
    const places = async () => text("#machines-places");
    await until("where it is drawn", async () =>
      /^bridge\s*placed at alpha, and drawn there$/.test(await places()));
    assert.match(await page.locator("#machines-places a").getAttribute("href"),
      /^http:\/\/127\.0\.0\.1:\d+/);
    await inside();
    await shot("machines-placed");

    await nodes.get("alpha").stop("SIGKILL");
    nodes.delete("alpha");
    await until("it takes over", async () =>
      /^beta takes the edits/.test(await text("#machines-head")));
    await until("the other is silent", async () =>
      await row("alpha").locator(".phase").textContent() === "silent");
    await until("this is the master", async () =>
      await row("beta").locator(".phase").textContent() === "master, here");
    await until("it is drawn here", async () =>
      /placed at alpha, drawn by beta: alpha is not there$/.test(
        await places()));
    assert.equal(await page.locator("#machines-places a").count(), 0);
    await shot("machines-silent");
  });

  test("are not shown where there is one", async () => {
    const alone = await Daemon.start();
    try {
      await open(alone.url, at("phone"));
      await ready();
      await until("all of the panel", () => page.locator("#exercises").count());
      assert.equal(await page.locator("#machines:visible").count(), 0);
    } finally {
      await alone.stop();
    }
  });
});
