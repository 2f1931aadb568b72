#!/usr/bin/python3
"""The page in a real browser: pictures, controls, errors, loss of the server.

Skipped (77) without Chromium and selenium. Screenshots: build/page/.
"""
import os
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, Daemon

try:
    from selenium import webdriver
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.chrome.service import Service
except ImportError:
    print("python3-selenium is not installed")
    sys.exit(77)
DRIVER, BROWSER = "/usr/bin/chromedriver", "/usr/bin/chromium"
if not (os.path.exists(DRIVER) and os.path.exists(BROWSER)):
    print("chromium-driver is not installed")
    sys.exit(77)

SHOTS = os.path.join(ROOT, "build", "page")
WAIT_S = 20


def start_browser(profile, width, height):
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in ("--headless", "--no-sandbox", "--disable-gpu",
                 "--disable-quic", "--no-first-run", "--disable-dev-shm-usage",
                 "--disable-background-networking",
                 "--disable-component-update", "--disable-sync",
                 f"--user-data-dir={profile}",
                 f"--window-size={width},{height}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(DRIVER), options=options)


def until(what, test, seconds=WAIT_S):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            if result := test():
                return result
        except Exception:  # the page may be redrawing itself
            pass
        time.sleep(0.1)
    raise AssertionError(f"not within {seconds} s: {what}")


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        os.makedirs(SHOTS, exist_ok=True)
        cls.profile = tempfile.TemporaryDirectory(prefix="pelagos-page-")
        cls.daemon = Daemon()
        cls.browser = start_browser(cls.profile.name, 1360, 900)

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.daemon.stop()
        cls.profile.cleanup()

    def setUp(self):
        self.browser.set_window_size(1360, 900)
        self.daemon.patch({"views": [{"name": "bridge", "entity": 1,
                                      "width": 640, "height": 360}]})
        self.browser.get(self.daemon.url("/"))
        self.pictures(1)

    def tearDown(self):
        errors = [entry for entry in self.browser.get_log("browser")
                  if entry["level"] == "SEVERE"
                  and "Failed to load resource" not in entry["message"]
                  and "ERR_" not in entry["message"]]
        self.assertEqual(errors, [])

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def run_js(self, text, *values):
        return self.browser.execute_script(text, *values)

    def pictures(self, count):
        return until(f"{count} pictures", lambda: self.run_js(
            "return [...document.querySelectorAll('.tile')].filter(t =>"
            " t.querySelector('.tile-note').hidden).length") == count)

    def shot(self, name):
        self.browser.save_screenshot(os.path.join(SHOTS, name + ".png"))

    def slide(self, selector, value):
        self.run_js("arguments[0].value = arguments[1];"
                    "arguments[0].dispatchEvent(new Event('input'))",
                    self.find(selector), value)

    def way(self):
        return self.find(".tile").get_attribute("data-way")

    def pixels(self):
        """Mean, spread and a sum of the picture's lower half."""
        return self.run_js("""
            const p = [...document.querySelectorAll('.picture')]
              .find(n => !n.hidden);
            const c = document.createElement('canvas');
            c.width = 320; c.height = 180;
            const g = c.getContext('2d', { willReadFrequently: true });
            g.drawImage(p, 0, 0, 320, 180);
            const d = g.getImageData(0, 100, 320, 80).data;
            let n = 0, s = 0, q = 0, m = 0;
            for (let i = 0; i < d.length; i += 4) {
              const y = 0.3 * d[i] + 0.6 * d[i + 1] + 0.1 * d[i + 2];
              n++; s += y; q += y * y; m = (m * 31 + d[i + 1]) % 1000003;
            }
            return [s / n, Math.sqrt(Math.max(0, q / n - s * s / n / n)), m];
            """)

    def test_picture_moves(self):
        first = self.pixels()[2]
        until("a newer picture", lambda: self.pixels()[2] != first)
        if self.way() == "webcodecs":
            size = self.run_js("const c = document.querySelector("
                               "'canvas.picture'); return [c.width, c.height]")
        else:
            why = self.find(".why").text
            self.assertIn("Motion-JPEG: ", why)
            print(why)
            size = self.run_js("const i = document.querySelector("
                               "'img.picture');"
                               "return [i.naturalWidth, i.naturalHeight]")
        self.assertEqual(size, [640, 360])
        until("latency", lambda: " ms" in self.find(".rate").text
              or self.way() == "mjpeg")
        time.sleep(2)
        print(f"{self.way()}: {self.find('.rate').text}")
        until("the controls", lambda: self.find("#wind-speed")
              .get_attribute("aria-valuetext") == "8 metres per second")
        until("a rate", lambda: "fps" in self.find("#fps").text)
        self.assertIn("2026-06-21 12:", self.find("#time").text)
        self.shot("wide")

    def test_picture_shows_the_sea_state(self):
        self.daemon.patch({"sea": {"windSpeed": 1}, "sky": {
            "sunElevation": 30, "sunAzimuth": 180}})
        time.sleep(1)
        calm = self.pixels()
        self.daemon.patch({"sea": {"windSpeed": 20}})
        time.sleep(1)
        rough = self.pixels()
        self.daemon.patch({"sea": {"windSpeed": None}, "sky": {
            "sunElevation": None, "sunAzimuth": None}})
        print(f"spread of the sea's brightness: calm {calm[1]:.1f}, "
              f"rough {rough[1]:.1f}")
        # Waves of 20 m/s have slopes, foam and shadows that 1 m/s has not.
        self.assertGreater(abs(rough[1] - calm[1]) +
                           abs(rough[0] - calm[0]), 3)

    def test_falls_back_and_says_why(self):
        script = self.browser.execute_cdp_cmd(
            "Page.addScriptToEvaluateOnNewDocument",
            {"source": "delete window.VideoDecoder;"})
        try:
            self.browser.get(self.daemon.url("/"))
            self.pictures(1)
            self.assertEqual(self.way(), "mjpeg")
            self.assertEqual(self.find(".why").text,
                             "Motion-JPEG: this browser has no VideoDecoder")
            until("the rate names the way",
                  lambda: "Motion-JPEG" in self.find(".rate").text)
            self.shot("fallback")
        finally:
            self.browser.execute_cdp_cmd(
                "Page.removeScriptToEvaluateOnNewDocument",
                {"identifier": script["identifier"]})

    def test_server_without_encoder(self):
        with Daemon("--video-encoder", "none") as daemon:
            daemon.patch({"views": [{"name": "bridge", "width": 320,
                                     "height": 180}]})
            self.browser.get(daemon.url("/"))
            self.pictures(1)
            until("the reason", lambda: "no H.264 encoder" in
                  self.find(".why").text)
            self.assertEqual(self.way(), "mjpeg")
            self.browser.get("about:blank")

    def test_wind_slider_sets_the_state(self):
        self.slide("#wind-speed", 14.5)
        until("the wind", lambda:
              self.daemon.state()["sea"]["windSpeed"] == 14.5)
        until("the rose", lambda: "14.5" in self.find("#rose-wind").text)

    def test_state_set_elsewhere_is_shown(self):
        self.daemon.patch({"sea": {"windSpeed": 3.5}})
        until("the slider", lambda: float(
            self.find("#wind-speed").get_attribute("value")) == 3.5)

    def test_refused_value_is_explained(self):
        until("the panel", lambda: self.find("#wind-speed"))
        before = self.daemon.state()["sea"]["windSpeed"]
        entry = self.find(".control:has(#wind-speed) input[type=number]")
        entry.send_keys(Keys.CONTROL, "a")
        entry.send_keys("99")
        error = self.find("#wind-speed-error")
        until("the error", lambda: "0 to 30 m/s" in error.text)
        self.shot("refused")
        self.assertEqual(self.daemon.state()["sea"]["windSpeed"], before)
        entry.send_keys(Keys.CONTROL, "a")
        entry.send_keys("9")
        until("the wind", lambda:
              self.daemon.state()["sea"]["windSpeed"] == 9)
        until("no error", lambda: not error.is_displayed())

    def test_sun_by_hand_and_by_the_clock(self):
        box = self.find("#sun-clock")
        until("the box", lambda: box.is_selected())
        box.click()
        until("a fixed Sun", lambda:
              "sunElevation" in self.daemon.state()["sky"])
        self.slide("#sun-elevation", 12)
        until("its elevation", lambda:
              self.daemon.state()["sky"]["sunElevation"] == 12)
        until("not held", lambda: not box.is_selected())
        box.click()
        until("the clock's Sun", lambda:
              "sunElevation" not in self.daemon.state()["sky"])

    def test_swell_seed_heading(self):
        self.find("#swell-on").click()
        until("a swell", lambda: self.daemon.state()["sea"].get("swell"))
        self.slide("#swell-height", 2.5)
        until("its height", lambda:
              self.daemon.state()["sea"]["swell"][0]["height"] == 2.5)
        self.slide("#heading", 123)
        until("the heading", lambda:
              self.daemon.state()["entities"][0]["heading"] == 123)
        self.daemon.patch({"sea": {"swell": []}})

    def test_keys_turn_the_view(self):
        body = self.find("body")
        body.send_keys(Keys.ARROW_RIGHT)
        body.send_keys(Keys.ARROW_RIGHT)
        until("the yaw", lambda: self.daemon.state()["views"][0]["yaw"] == 10)
        body.send_keys(Keys.ARROW_UP)
        until("the pitch", lambda:
              self.daemon.state()["views"][0]["pitch"] == 2)
        body.send_keys("f")
        until("full screen", lambda: self.run_js(
            "return document.fullscreenElement !== null ||"
            " document.querySelector('.tile.filled') !== null"))
        self.shot("full")
        body.send_keys("f")
        until("the end of full screen", lambda: self.run_js(
            "return document.fullscreenElement === null &&"
            " document.querySelector('.tile.filled') === null"))

    def test_views_come_and_go(self):
        for i in range(5):
            self.daemon.request("PUT", f"/v1/views/v{i}",
                                {"entity": 1, "yaw": 40 * (i + 1),
                                 "width": 320, "height": 180})
        self.pictures(6)
        time.sleep(1)
        self.shot("six")
        for i in range(5):
            self.daemon.request("DELETE", f"/v1/views/v{i}")
        self.pictures(1)

    def test_narrow(self):
        self.browser.set_window_size(500, 900)
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": 360, "height": 780, "deviceScaleFactor": 2,
            "mobile": True})
        try:
            time.sleep(0.5)
            wide, window = self.run_js(
                "return [document.documentElement.scrollWidth,"
                " window.innerWidth]")
            self.shot("narrow")
            self.assertLessEqual(wide, 360)
            self.assertEqual(window, 360)
            self.run_js("window.scrollTo(0, 500)")
            self.shot("narrow-below")
        finally:
            self.browser.execute_cdp_cmd(
                "Emulation.clearDeviceMetricsOverride", {})

    def test_every_control_has_a_name(self):
        nameless = self.run_js("""
            return [...document.querySelectorAll('input,select,button')]
              .filter(n => !n.labels?.length && !n.getAttribute('aria-label'))
              .map(n => n.outerHTML)""")
        self.assertEqual(nameless, [])

    def test_loss_and_return_of_the_server(self):
        port = self.daemon.http_port
        self.daemon.stop()
        until("the message", lambda:
              "does not answer" in self.find("#gone").text)
        self.shot("gone")
        type(self).daemon = Daemon(http_port=port)
        until("recovery", lambda: not self.find("#gone").is_displayed())
        until("a picture again", lambda: self.run_js(
            "return document.querySelector('.rate').textContent"
            ".match(/[0-9.]+ fps/) !== null"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
