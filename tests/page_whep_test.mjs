#!/usr/bin/env node
// A view by WebRTC in a real browser: on the page where WebCodecs is missing, and
// by an RTCPeerConnection without the page. Sizes, pictures that follow each other,
// and what is on them.
//
// Skipped (77) without Chromium or playwright-core. Screenshots: build/page/.
import assert from "node:assert/strict";
import { beforeEach, describe, test } from "node:test";

import { daemon, fresh, open, page, shot, text } from "./page.mjs";
import { sleep, until } from "./pelagos_daemon.mjs";

// Of 255: the mean over 64 x 36 patches of how far a colour is from the PNG's,
// decoded by the same browser. 3.4 were seen: live views are drawn coarser on a
// slow machine, colours are halved; upside down it is 47.
const ALIKE = 5;

// Mean difference of a patch's colours between the video and the PNG of now, and
// between the PNG upside down and itself, as a measure.
const compare = () => page.evaluate(async () => {
  const png = await createImageBitmap(await (await fetch(
    "/v1/views/bridge/frame.png", { cache: "no-store" })).blob());
  const patches = (source, flip) => {
    const canvas = new OffscreenCanvas(64, 36);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.imageSmoothingQuality = "high";
    if (flip) {
      context.scale(1, -1);
      context.translate(0, -36);
    }
    context.drawImage(source, 0, 0, 64, 36);
    return context.getImageData(0, 0, 64, 36).data;
  };
  const apart = (a, b) => a.reduce((sum, v, i) =>
    sum + Math.abs(v - b[i]), 0) / a.length * 4 / 3;
  const still = patches(png, false);
  return { video: apart(patches(document.querySelector("video"), false), still),
    wrong: apart(patches(png, true), still) };
});

const frames = () => page.evaluate(() =>
  document.querySelector("video").getVideoPlaybackQuality().totalVideoFrames);
const size = () => page.evaluate(() => {
  const { videoWidth, videoHeight } = document.querySelector("video");
  return [videoWidth, videoHeight];
});

// It plays, in its size; and when time stands, what is on it is the PNG.
async function plays() {
  await until("a picture", async () => (await size())[0] > 0);
  assert.deepEqual(await size(), [640, 360]);
  const before = await frames();
  await until("more pictures", async () => await frames() > before + 10);
  await daemon.patch({ clock: { mode: "STEPPED" } });
  let seen;
  await until("the picture of now", async () => {
    await daemon.request("POST", "/v1/clock/step", { seconds: 0.001 });
    await sleep(200);
    seen = await compare();
    return seen.video < ALIKE;
  });
  assert.ok(seen.wrong > 3 * ALIKE, `upside down: ${seen.wrong}`);
  await daemon.patch({ clock: { mode: "FREE" } });
  console.log(`from the PNG: ${seen.video.toFixed(2)} of 255 (bar ${ALIKE}); ` +
    `upside down ${seen.wrong.toFixed(1)}`);
}

describe("WebRTC", () => {
  beforeEach(fresh);

  test("on the page, where WebCodecs is missing", async () => {
    await open(daemon.url, { init: () => {
      delete window.VideoDecoder;
    } });
    assert.equal(await page.locator(".tile").getAttribute("data-way"), "whep");
    assert.equal(await text(".why"),
      "WebRTC: this browser has no VideoDecoder");
    await plays();
    await until("rate and latency", async () =>
      /[\d.]+ fps\d+ ms\d+ droppedWebRTC$/.test(await text(".rate")));
    console.log(await text(".rate"));
    await shot("whep");
    assert.equal(await daemon.metric("pelagos_whep_connected"), 1);
    await page.goto("about:blank");
    await until("its session ends", async () =>
      await daemon.metric("pelagos_whep_sessions") === 0);
  });

  test("where the address says so", async () => {
    await open(`${daemon.url}/?way=whep`);
    assert.equal(await page.locator(".tile").getAttribute("data-way"), "whep");
    assert.equal(await text(".why"), "WebRTC: the address says way=whep");
  });

  test("falls back where no answer comes", async () => {
    await open(`${daemon.url}/?way=whep`, { init: () => {
      const plain = window.fetch;
      window.fetch = (at, ...more) => String(at).endsWith("/whep")
        ? Promise.resolve(new Response("", { status: 404 }))
        : plain(at, ...more);
    } });
    await until("the way", async () =>
      await page.locator(".tile").getAttribute("data-way") === "mjpeg");
    assert.equal(await text(".why"),
      "Motion-JPEG: the address says way=whep; WebRTC: HTTP 404");
  });

  test("says the server's reason", async () => {
    const why = "no UDP port is free for media; see pelagosd --whep-ports";
    await open(`${daemon.url}/?way=whep`, { init: () => {
      const plain = window.fetch;
      window.fetch = (at, ...more) => String(at).endsWith("/whep")
        ? Promise.resolve(Response.json({ status: 400, detail:
          "no UDP port is free for media; see pelagosd --whep-ports" },
        { status: 400 }))
        : plain(at, ...more);
    } });
    await until("the way", async () =>
      await page.locator(".tile").getAttribute("data-way") === "mjpeg");
    assert.equal(await text(".why"),
      `Motion-JPEG: the address says way=whep; WebRTC: ${why}`);
  });

  // Sound first, and all by one transport: what its line refuses ends the rest.
  for (const lines of [["audio", "video"], ["data", "video", "video"]]) {
    test(`of ${lines.join(", ")}, by one transport, in VP8`, async () => {
      await open(`${daemon.url}/healthz`, { wait: false });
      await page.evaluate(async (lines) => {
        const video = document.createElement("video");
        document.body.append(video);
        video.muted = true;
        const peer = new RTCPeerConnection({ bundlePolicy: "max-bundle" });
        for (const kind of lines) {
          if (kind === "data") {
            peer.createDataChannel("d");
            continue;
          }
          const transceiver = peer.addTransceiver(kind,
            { direction: "recvonly" });
          if (kind === "video") {
            transceiver.setCodecPreferences(RTCRtpReceiver.getCapabilities(
              "video").codecs.filter((c) => /VP8|rtx/.test(c.mimeType)));
          }
        }
        peer.ontrack = ({ track }) => {
          if (track.kind === "video" && !video.srcObject) {
            video.srcObject = new MediaStream([track]);
            video.play();
          }
        };
        await peer.setLocalDescription();
        const answer = await fetch("/v1/views/bridge/whep", { method: "POST",
          body: peer.localDescription.sdp,
          headers: { "Content-Type": "application/sdp" } });
        await peer.setRemoteDescription({ type: "answer",
          sdp: await answer.text() });
      }, lines);
      await plays();
      // What Chromium sends for its channel of data ends nothing.
      const before = await frames();
      await until("pictures go on", async () => await frames() > before + 10);
      assert.equal(await daemon.metric("pelagos_whep_connected"), 1);
      await page.goto("about:blank");
      await until("its session ends", async () =>
        await daemon.metric("pelagos_whep_sessions") === 0);
    });
  }

  test("without the page", async () => {
    await open(`${daemon.url}/healthz`, { wait: false });
    await page.evaluate(async () => {
      const video = document.createElement("video");
      document.body.append(video);
      video.muted = true;
      const peer = new RTCPeerConnection();
      peer.addTransceiver("video", { direction: "recvonly" });
      peer.addTransceiver("audio", { direction: "recvonly" });
      peer.ontrack = ({ track }) => {
        if (track.kind === "video") {
          video.srcObject = new MediaStream([track]);
          video.play();
        }
      };
      await peer.setLocalDescription();
      const answer = await fetch("/v1/views/bridge/whep", { method: "POST",
        body: peer.localDescription.sdp,
        headers: { "Content-Type": "application/sdp" } });
      await peer.setRemoteDescription({ type: "answer",
        sdp: await answer.text() });
      window.ended = () => fetch(answer.headers.get("Location"),
        { method: "DELETE" }).then(({ status }) => status);
    });
    await plays();
    assert.equal(await page.evaluate(() => window.ended()), 204);
    const last = await frames();
    await sleep(500);
    assert.ok(await frames() <= last + 5, "nothing comes after the end");
  });
});
