#!/usr/bin/env python3
"""Shows a view live in an OpenCV window.

    live.py [VIEW] [--url http://127.0.0.1:8080]

Keys: w and s wind up and down, a and d look left and right, q ends. Without
OpenCV or without a screen it writes the pictures to --out instead, --frames of
them.
"""
from __future__ import annotations

import argparse
import os
import pathlib
import sys
import time

from pelagos import LiveStream, Ocean, PelagosError, ViewHandle


def have_window() -> bool:
    if sys.platform.startswith("linux") and not (
            os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    try:
        import cv2
    except ImportError:
        return False
    return hasattr(cv2, "imshow")


def steer(key: str, ocean: Ocean, view: ViewHandle) -> None:
    if key in "ws":
        wind = ocean["sea.windSpeed"] + (1 if key == "w" else -1)
        ocean["sea.windSpeed"] = min(max(wind, 0), 30)
    elif key in "ad":
        view["yaw"] = (view["yaw"] + (5 if key == "d" else -5)) % 360


def show(ocean: Ocean, view: ViewHandle, stream: LiveStream,
         count: int) -> None:
    import cv2
    title = f"Pelagos: {view.name}"
    last = time.monotonic()
    for frame in stream:
        now = time.monotonic()
        rate, last = 1 / max(now - last, 1e-3), now
        image = frame.image()[:, :, ::-1].copy()  # OpenCV shows BGR
        cv2.putText(image, f"{frame.time:.2f} s  {rate:.0f} Hz  "
                    f"{stream.dropped} dropped", (10, 25),
                    cv2.FONT_HERSHEY_SIMPLEX, 0.6, (255, 255, 255), 1)
        cv2.imshow(title, image)
        key = cv2.waitKey(1) & 0xFF
        count -= 1
        if key == ord("q") or count == 0:
            break
        if key != 0xFF:
            steer(chr(key), ocean, view)
    cv2.destroyAllWindows()


def write(stream: LiveStream, folder: pathlib.Path, count: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number, frame in enumerate(stream):
        frame.save(folder / f"{frame.view}-{frame.number:06}.jpg")
        print(f"frame {frame.number}, {frame.time:.3f} s, "
              f"{len(frame.data)} bytes, {stream.dropped} dropped so far")
        if number + 1 == count:
            break


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("view", nargs="?", help="the first, unless given")
    parser.add_argument("--url", help="of the daemon")
    parser.add_argument("--fps", type=float, help="at most so many [1/s]")
    parser.add_argument("--frames", type=int, default=0,
                        help="end after so many; without a window: 10")
    parser.add_argument("--out", default="live", type=pathlib.Path)
    options = parser.parse_args()
    with Ocean(options.url) as ocean:
        names = [options.view] if options.view else ocean.views.names()
        if not names:
            sys.exit("live.py: the scene has no view")
        view = ocean.views[names[0]]
        with view.live(fps=options.fps) as stream:
            if have_window():
                show(ocean, view, stream, options.frames)
            else:
                print(f"no window here: pictures go to {options.out}/")
                write(stream, options.out, options.frames or 10)


if __name__ == "__main__":
    try:
        main()
    except PelagosError as error:
        sys.exit(f"live.py: {error}")
    except KeyboardInterrupt:
        pass
