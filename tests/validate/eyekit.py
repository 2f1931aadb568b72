"""Pictures of a daemon as the eye gets them, and what is counted in them."""
import contextlib
import io
import os
import sys

import numpy as np
from PIL import Image

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(
    os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "tests"),
                os.path.join(ROOT, "clients", "python")]
from pelagos.exr import read_exr  # noqa: E402
from pelagos_daemon import Daemon  # noqa: E402

BASE = {"clock": {"mode": "STEPPED", "time": 100},
        "sea": {"windDirection": 250, "windSpeed": 8, "synthesiser": "FFT",
                "whitecaps": 0},
        "water": {}, "sky": {"sunElevation": 35, "sunAzimuth": 0,
                             "visibility": 40000}}
VIEW = {"name": "v", "width": 640, "height": 360, "fieldOfView": 60, "up": 6,
        "pitch": -2, "yaw": 0}


@contextlib.contextmanager
def eye(*options):
    """draw(view, state) → (8-bit RGB picture, EV)."""
    with Daemon(*options) as daemon:

        def get(path):
            answer = daemon.get(path)
            if answer.status != 200:
                sys.exit(f"{path}: {answer.status} {answer.body[:300]!r}")
            return answer.body

        def draw(view, **state):
            whole = {name: {**BASE.get(name, {}), **state.get(name, {})}
                     for name in {**BASE, **state}}
            # What an earlier scene had set goes.
            daemon.patch({"sea": None, "water": None, "sky": None,
                          "seabed": None, "views": None})
            answer = daemon.patch({**whole, "views": [{**VIEW, **view}]})
            if answer.status != 200:
                sys.exit(f"{state}: {answer.status} {answer.body[:300]!r}")
            picture = Image.open(io.BytesIO(get("/v1/views/v/frame.png")))
            small = get("/v1/views/v/frame.exr?layers=radiance")
            ev = read_exr(small).attributes.get("pelagos.exposure")
            return picture.convert("RGB"), float(ev)

        yield draw


def figures(picture):
    """Shares of pixels: one channel at 250 or above, all of them; the mean
    of the picture's luma, 0 to 255."""
    values = np.asarray(picture)
    return {"bright": float((values.max(2) >= 250).mean()),
            "white": float((values.min(2) >= 250).mean()),
            "mean": float((values @ [0.2126, 0.7152, 0.0722]).mean())}
