#!/usr/bin/python3
"""From a frame's stamp to its decoded pixels in a real Chromium, on the page.

    tests/bench/latency.py [--seconds 20] [--width 1280] [--height 720]
                           [--json FILE] [options of pelagosd …]

Starts a daemon on the software device and the page at / in headless Chromium,
which plays the view by WebSocket and WebCodecs. Each picture's header is noted
as it arrives, and the time when the decoder gives the picture, by the clock
that daemon and browser share. Prints rate, scale, first picture, the parts of
the latency, and how soon a state patch is shown.
"""
import argparse
import json
import os
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)),
                                ".."))
from pelagos_daemon import Daemon

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    sys.exit("python3-selenium is not installed")
DRIVER, BROWSER = "/usr/bin/chromedriver", "/usr/bin/chromium"

# Before the page's own scripts: what arrives, what is decoded, and when.
PROBE = """
(() => {
  const now = () => performance.timeOrigin + performance.now();
  const probe = window.pelagosProbe = { opened: 0, pictures: [] };
  let last = null;
  const waiting = new Map();
  const Socket = window.WebSocket;
  window.WebSocket = class extends Socket {
    constructor(...parts) {
      super(...parts);
      if (parts[0].toString().includes("/live")) {
        probe.opened ||= now();
        this.addEventListener("message", (event) => {
          if (typeof event.data === "string") return;
          const at = new DataView(event.data);
          last = {
            number: Number(at.getBigUint64(8, true)),
            stamp: Number(at.getBigUint64(32, true)) / 1000,
            drawn: at.getUint32(40, true) / 1000,
            encoded: at.getUint32(44, true) / 1000,
            queued: at.getUint32(48, true) / 1000,
            missed: at.getUint32(52, true),
            revision: Number(at.getBigUint64(56, true)),
            width: at.getUint16(4, true),
            drawnWidth: at.getUint16(72, true),
            came: now(),
          };
        });
      }
    }
  };
  const Decoder = window.VideoDecoder;
  window.VideoDecoder = class extends Decoder {
    constructor(init) {
      super({ ...init, output: (frame) => {
        const head = waiting.get(frame.timestamp);
        waiting.delete(frame.timestamp);
        if (head) {
          head.decoded = now();
          probe.pictures.push(head);
        }
        init.output(frame);
      } });
    }
    decode(chunk) {
      waiting.set(chunk.timestamp, last);
      super.decode(chunk);
    }
  };
})();
"""


def start_browser(profile):
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in ("--headless", "--no-sandbox", "--disable-gpu",
                 "--no-first-run", "--disable-dev-shm-usage",
                 "--disable-background-networking", "--disable-sync",
                 f"--user-data-dir={profile}", "--window-size=1360,900"):
        options.add_argument(flag)
    return webdriver.Chrome(service=Service(DRIVER), options=options)


def rank(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))]


def line(name, values):
    print(f"{name:44} {rank(values, 0.5):7.1f} {rank(values, 0.95):7.1f} "
          f"{max(values):7.1f}")
    return {"median": rank(values, 0.5), "p95": rank(values, 0.95)}


def take(browser):
    """The pictures decoded since the last call."""
    return browser.execute_script(
        "return window.pelagosProbe.pictures.splice(0)")


def patches(daemon, browser, count):
    """ms from the answer to a PATCH to the stamp, and to the decoded pixels,
    of the first picture that shows it; pictures that came before it."""
    take(browser)
    asked, pictures = [], []
    for i in range(count):
        answer = daemon.patch({"sea": {"windSpeed": 5 + i % 7}})
        asked.append((time.time() * 1000, int(answer.json()["revision"])))
        time.sleep(0.35)
        pictures += take(browser)
    stamps, shown = [], []
    for at, revision in asked:
        first = next((p for p in pictures if p["revision"] >= revision), None)
        if first:
            stamps.append(first["stamp"] - at)
            shown.append(first["decoded"] - at)
    return stamps, shown


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=720)
    parser.add_argument("--json")
    given, options = parser.parse_known_args()
    profile = tempfile.TemporaryDirectory(prefix="pelagos-latency-")
    with profile, Daemon(*options) as daemon:
        daemon.patch({"views": [{"name": "bridge", "entity": 1,
                                 "width": given.width,
                                 "height": given.height}]})
        browser = start_browser(profile.name)
        try:
            browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument",
                                    {"source": PROBE})
            browser.get(daemon.url("/"))
            time.sleep(6)  # the scale is found, caches are warm
            opened = browser.execute_script(
                "return window.pelagosProbe.opened")
            first = take(browser)
            if not first:
                sys.exit("the page decoded no picture")
            time.sleep(given.seconds)
            pictures = take(browser)
            stamps, shown = patches(daemon, browser, 20)
            quality = daemon.metrics()["pelagos_frames_quality"]
        finally:
            browser.quit()
    rate = (len(pictures) - 1) / (
        1e-3 * (pictures[-1]["stamp"] - pictures[0]["stamp"]))
    print(f"{given.width}x{given.height}: {rate:.1f} pictures a second "
          f"decoded, drawn at {quality:.2f} of the size; "
          f"{pictures[-1]['missed'] - pictures[0]['missed']} not sent")
    print(f"first picture decoded {first[0]['decoded'] - opened:.0f} ms after "
          f"opening")
    print(f"{'ms':44} {'median':>7} {'p95':>7} {'most':>7}")
    figures = {
        "rate": rate, "quality": quality,
        "firstPictureMs": first[0]["decoded"] - opened,
        "stampToPixelMs": line("stamp to decoded pixels",
                               [p["decoded"] - p["stamp"] for p in pictures]),
        "renderMs": line("  of it rendering", [p["drawn"] for p in pictures]),
        "encodeMs": line("  of it waiting for an encoder, encoding",
                         [p["encoded"] - p["drawn"] for p in pictures]),
        "sendMs": line("  of it the way to the page",
                       [p["came"] - p["stamp"] - p["encoded"]
                        for p in pictures]),
        "decodeMs": line("  of it decoding",
                         [p["decoded"] - p["came"] for p in pictures]),
        "beyondRenderMs": line(
            "beyond the render time (bars: 40, 100)",
            [p["decoded"] - p["stamp"] - p["drawn"] for p in pictures]),
        "patchToStampMs": line("patch to the stamp of a frame that shows it",
                               stamps),
        "patchToPixelMs": line("patch to its decoded pixels (bar: 67 + render)",
                               shown),
    }
    if given.json:
        with open(given.json, "w", encoding="utf-8") as f:
            json.dump(figures, f, indent=2)


if __name__ == "__main__":
    main()
