#!/usr/bin/python3 -B
"""The page in Debian's Qt WebEngine 5.15 (Chromium 87 of 2020, which consoles
have): it begins, shows pictures that go on, and can be worked with."""
import json
import os
import shutil
import sys
import time
import unittest

from pelagos_daemon import ROOT, SLOW_S, Daemon

# It draws by OpenGL, which a display of Xvfb's has.
if not os.environ.get("PELAGOS_XVFB"):
    if not shutil.which("xvfb-run"):
        print("no Xvfb to show it on")
        sys.exit(77)
    os.environ.update(PELAGOS_XVFB="1", QT_QPA_PLATFORM="xcb")
    os.execvp("xvfb-run", ["xvfb-run", "-a", "-s", "-screen 0 1400x1000x24",
                           sys.executable, "-B", *sys.argv])
os.environ.setdefault("QTWEBENGINE_DISABLE_SANDBOX", "1")
os.environ.setdefault("QTWEBENGINE_CHROMIUM_FLAGS",
                      "--disable-gpu --no-sandbox --no-proxy-server "
                      "--disable-dev-shm-usage")
try:
    from PyQt5.QtCore import QEventLoop, QTimer, QUrl
    from PyQt5.QtWebEngineWidgets import QWebEnginePage, QWebEngineView
    from PyQt5.QtWidgets import QApplication
except ImportError as error:
    print(f"no Qt WebEngine: {error}")
    sys.exit(77)

SHOTS = os.path.join(ROOT, "build/page")


class Page(QWebEnginePage):
    """Keeps what the page's scripts complain about."""

    def __init__(self, parent):
        super().__init__(parent)
        self.errors = []

    def javaScriptConsoleMessage(self, level, text, line, source):
        if level == QWebEnginePage.ErrorMessageLevel and "WebSocket" not in text:
            self.errors.append(f"{source}:{line}: {text}")


class Window:
    def __init__(self, url):
        self.view = QWebEngineView()
        self.view.resize(1360, 900)
        self.page = Page(self.view)
        self.view.setPage(self.page)
        self.view.show()
        self.view.load(QUrl(url))

    def ask(self, script):
        loop, found = QEventLoop(), []

        def take(answer):
            found.append(answer)
            loop.quit()
        self.page.runJavaScript(
            f"JSON.stringify((() => {{ {script} }})())", take)
        QTimer.singleShot(int(1000 * SLOW_S), loop.quit)
        if not found:
            loop.exec_()
        return json.loads(found[0]) if found and found[0] else None

    def rest(self, ms):
        loop = QEventLoop()
        QTimer.singleShot(ms, loop.quit)
        loop.exec_()

    def until(self, what, script):
        end = time.monotonic() + SLOW_S
        while not (found := self.ask(script)):
            if time.monotonic() > end:
                shown = self.ask("return document.body.innerText.slice(0, 600)")
                raise AssertionError(f"not within {SLOW_S} s: {what}; errors "
                                     f"{self.page.errors}; shown: {shown}")
            self.rest(50)
        return found

    def shot(self, name):
        self.rest(200)
        os.makedirs(SHOTS, exist_ok=True)
        self.view.grab().save(os.path.join(SHOTS, f"{name}.png"))


class QtTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.application = QApplication(["page_qt_test"])
        cls.daemon = Daemon()
        cls.daemon.patch({"views": [
            {"name": "bridge", "entity": 1, "up": 15, "width": 320,
             "height": 180}]})

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()

    def test_works(self):
        window = Window(f"http://127.0.0.1:{self.daemon.http_port}/")
        self.assertRegex(window.ask("return navigator.userAgent"),
                         r"QtWebEngine/5\.15.* Chrome/8[37]\.")
        window.until("a picture", """
            return document.querySelector(".tile-note[hidden]") !== null""")
        window.until("controls", """
            return document.querySelector("#panel:not(.waiting)") !== null""")
        self.assertEqual(window.ask(
            "return document.getElementById('link').textContent"), "connected")
        # One picture goes, another comes; none stands for the browser's sake.
        window.until("pictures one after the other", """
            return Number.parseFloat(
              document.getElementById("fps").textContent) > 0""")
        # It is as large as its view, without aspect-ratio.
        across, down = window.ask("""
            const seen = [...document.querySelectorAll(".picture")].find((n) =>
              !n.hidden).getBoundingClientRect();
            return [seen.width, seen.height]""")
        self.assertAlmostEqual(down, across * 180 / 320, delta=2)
        # A control sets what it says.
        window.ask("""
            const node = document.getElementById("wind-speed");
            node.value = 17;
            node.dispatchEvent(new Event("input"));
            node.dispatchEvent(new Event("change"));
            return true""")
        window.until("the wind", """
            return document.getElementById("rose-wind").textContent
              .includes("17")""")
        window.shot("qt")
        self.assertEqual(window.page.errors, [])

    def test_login(self):
        window = Window(f"http://127.0.0.1:{self.daemon.http_port}/")
        window.until("the page", """
            return document.documentElement.dataset.runs === ''""")
        window.ask("""
            document.getElementById("about-open").click(); return true""")
        window.until("the dialog", """
            const node = document.getElementById("about");
            return node !== null && node.open &&
              node.getBoundingClientRect().height > 50""")
        self.assertEqual(window.page.errors, [])


if __name__ == "__main__":
    unittest.main()
