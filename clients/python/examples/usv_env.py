#!/usr/bin/env python3
"""An environment for reinforcement learning, with gymnasium's interface: an
uncrewed vessel keeps a track past a buoy, in waves.

    env = UsvEnv("http://127.0.0.1:8080", observe="depth")
    observation, info = env.reset(seed=3)
    for _ in range(100):
        observation, reward, terminated, truncated, info = env.step([0, 1])

The clock is STEPPED: an action, then STEP_S seconds. An episode's start is a
function of its seed alone, and so, on the same device, is all that follows from
the same actions, to the bit.

action       float32 (2,): rudder (1: 35 degrees to starboard), throttle
observation  a dict
    image    uint8 (height, width, 3), RGB; or
    depth    float32 (height, width), metres along the ray, at most FAR_M
    state    float32 (10,): off the track to starboard [m], to go [m], course
             off the track's (sine, cosine), speed [m/s], turn rate [deg/s],
             pitch, roll [deg], the buoy ahead and to starboard [m]
    waves    float32 (9,): the sea's height on the track ahead, at WAVES_M
reward       metres gained along the track, less OFF_COST of those off it, less
             HIT_COST on the buoy
terminated   at the end of the track, on the buoy, or LOST_M off the track
truncated    after `steps` steps

With gymnasium installed it is a gymnasium.Env and its spaces are gymnasium's;
without, plain_gym.py beside it does the same for both.

    usv_env.py [--url http://127.0.0.1:8080] [--seed 1] [--steps 60]

runs an episode under a helmsman of ten lines and prints it."""
from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterable
from typing import Any

import numpy as np

from pelagos import Ocean, PelagosError, State, to_geographic, to_local

STEP_S = 1.0
RUDDER_DEG = 35.0
FAR_M = 1000.0
TRACK_M = 400.0
LOST_M = 80.0
HIT_M = 8.0
OFF_COST = 0.02
HIT_COST = 100.0
WAVES_M = np.arange(0.0, 45.0, 5.0)

Array = np.ndarray[Any, Any]
Observation = dict[str, Array]

try:
    import gymnasium
    Env: Any = gymnasium.Env
    Box: Any = gymnasium.spaces.Box
    Dict: Any = gymnasium.spaces.Dict
except ImportError:
    import plain_gym
    Env, Box, Dict = plain_gym.Env, plain_gym.Box, plain_gym.Dict


class UsvEnv(Env):  # type: ignore[misc]
    """See above.

    observe      "image" or "depth"
    size         width and height of what is observed [px]
    steps        of an episode at most
    render_mode  None, or "rgb_array": what render() gives
    """
    metadata: dict[str, Any] = {"render_modes": ["rgb_array"],
                                "render_fps": 1 / STEP_S}

    def __init__(self, url: str | None = None, *, observe: str = "image",
                 size: tuple[int, int] = (96, 64), steps: int = 200,
                 render_mode: str | None = None,
                 timeout: float = 60.0) -> None:
        if observe not in ("image", "depth"):
            raise ValueError(f"observe is image or depth, not {observe!r}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode is rgb_array or None, not "
                             f"{render_mode!r}")
        self.render_mode, self.observe, self.steps = render_mode, observe, steps
        self.ocean = Ocean(url, timeout=timeout)
        self.width, self.height = size
        high = np.array([1e4, 1e4, 1, 1, 20, 90, 90, 180, 1e4, 1e4],
                        np.float32)
        seen = (Box(0, 255, (self.height, self.width, 3), np.uint8)
                if observe == "image" else
                Box(0, FAR_M, (self.height, self.width), np.float32))
        self.observation_space = Dict({
            observe: seen,
            "state": Box(-high, high, dtype=np.float32),
            "waves": Box(-30, 30, WAVES_M.shape, np.float32)})
        self.action_space = Box(-1, 1, (2,), np.float32)
        self._left = 0

    # --- gymnasium's interface ----------------------------------------------

    def reset(self, *, seed: int | None = None,
              options: dict[str, Any] | None = None
              ) -> tuple[Observation, dict[str, Any]]:
        """options: {"wind": m/s} instead of one by chance."""
        super().reset(seed=seed)
        random = self.np_random
        self.course = float(random.uniform(0, 360))
        wind = float((options or {}).get("wind", random.uniform(2, 10)))
        self.buoy = (float(random.uniform(0.35, 0.65)) * TRACK_M,
                     float(random.uniform(-6, 6)))  # along, to starboard
        start = float(random.uniform(-15, 15))
        state = self.ocean.reset(int(random.integers(1, 1 << 31)), {
            "sea": {"windSpeed": wind,
                    "windDirection": float(random.uniform(0, 360))},
            "sky": {"sunAzimuth": float(random.uniform(0, 360)),
                    "sunElevation": float(random.uniform(15, 60))},
            "entities": [
                {"id": 1, "name": "usv", "model": {"name": "usv"},
                 "heading": self.course, **self._degrees(0, start)},
                {"id": 2, "name": "buoy", "model": {"name": "safe-water"},
                 "afloat": True, **self._degrees(*self.buoy)}],
            "ownShip": {"on": True, "entity": 1, "length": 5.4, "beam": 2.6,
                        "maxSpeed": 5, "surgeTime": 3, "turnTime": 1},
            "views": [{"name": "bow", "entity": 1, "forward": 2.5, "up": 2.2,
                       "fieldOfView": 90, "width": self.width,
                       "height": self.height}]})
        self._left = self.steps
        observation, info = self._observe(state)
        self._along = info["along"]
        return observation, info

    def step(self, action: Any) -> tuple[Observation, float, bool, bool,
                                         dict[str, Any]]:
        if self._left <= 0:
            raise RuntimeError("the episode is over: reset() comes first")
        order = np.asarray(action, np.float64)
        if order.shape != (2,) or not (abs(order) <= 1).all():
            raise ValueError(f"an action is two numbers of -1 to 1, not "
                             f"{action!r}")
        self.ocean.set(ownShip={"rudder": RUDDER_DEG * order[0],
                                "throttle": order[1]})
        observation, info = self._observe(self.ocean.step(STEP_S))
        self._left -= 1
        hit = info["buoy"] < HIT_M
        reward = (info["along"] - self._along - OFF_COST * abs(info["off"])
                  - (HIT_COST if hit else 0.0))
        self._along = info["along"]
        terminated = bool(hit or info["along"] >= TRACK_M
                          or abs(info["off"]) > LOST_M)
        truncated = self._left == 0 and not terminated
        if terminated:
            self._left = 0
        return observation, float(reward), terminated, truncated, info

    def render(self) -> Array | None:
        if self.render_mode is None:
            return None
        return self.ocean.image("bow", width=480, height=320)

    def close(self) -> None:
        self.ocean.close()

    # --- the task -----------------------------------------------------------

    def _degrees(self, along: float, off: float) -> dict[str, float]:
        """A place by metres along the track and to starboard of it."""
        c, s = (math.cos(math.radians(self.course)),
                math.sin(math.radians(self.course)))
        place = to_geographic(along * s + off * c, along * c - off * s)
        return {"latitude": place.latitude, "longitude": place.longitude}

    def _observe(self, state: State) -> tuple[Observation, dict[str, Any]]:
        ship = state.entities[0]
        east, north = to_local(ship.latitude, ship.longitude)
        angle = math.radians(self.course)
        c, s = math.cos(angle), math.sin(angle)
        along, off = east * s + north * c, east * c - north * s
        turn = math.radians(ship.heading) - angle
        to = (self.buoy[0] - along, self.buoy[1] - off)
        ahead = to[0] * math.cos(turn) + to[1] * math.sin(turn)
        right = to[1] * math.cos(turn) - to[0] * math.sin(turn)
        at = np.stack([east + WAVES_M * s, north + WAVES_M * c], -1)
        time = state.clock.time if state.clock else 0.0
        waves = self.ocean.surface(at, time).height.astype(np.float32)
        numbers = np.array(
            [off, TRACK_M - along, math.sin(turn), math.cos(turn), ship.speed,
             ship.turnRate, ship.pitch, ship.roll, ahead, right], np.float32)
        observation = {self.observe: self._look(time), "state": numbers,
                       "waves": waves}
        info = {"time": time, "along": along, "off": off,
                "buoy": math.hypot(*to), "wind": state.sea.windSpeed
                if state.sea else 0.0}
        return observation, info

    def _look(self, time: float) -> Array:
        if self.observe == "image":
            return np.ascontiguousarray(self.ocean.image("bow", time=time))
        depth = self.ocean.frame("bow", "exr", layers=("depth",),
                                 time=time).exr()["depth"]
        return np.minimum(depth, FAR_M).astype(np.float32)


def helmsman(state: Iterable[float]) -> Array:
    """Towards the track ahead; around what is close ahead."""
    off, _, sine, cosine, _, rate, _, _, ahead, right = (
        float(n) for n in state)
    aim = -math.atan2(off, 30.0)
    if 0 < ahead < 60 and abs(right) < 18:
        aim += -0.6 if right > 0 else 0.6
    error = aim - math.atan2(sine, cosine)
    rudder = 2.0 * error - 0.02 * rate
    return np.array([min(max(rudder, -1), 1), 1], np.float32)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--url", help="of the daemon")
    parser.add_argument("--seed", default=1, type=int)
    parser.add_argument("--steps", default=120, type=int)
    parser.add_argument("--observe", default="image")
    options = parser.parse_args()
    with UsvEnv(options.url, observe=options.observe,
                steps=options.steps) as env:
        observation, info = env.reset(seed=options.seed)
        total, count, over, began = 0.0, 0, False, time.monotonic()
        while not over:
            observation, reward, terminated, truncated, info = env.step(
                helmsman(observation["state"]))
            total, count, over = total + reward, count + 1, (terminated
                                                             or truncated)
            if count % 10 == 0 or over:
                print(f"{info['time']:5.0f} s  {info['along']:6.1f} m along, "
                      f"{info['off']:6.1f} m off, buoy {info['buoy']:6.1f} m")
        rate = count / (time.monotonic() - began)
        print(f"{count} steps, {rate:.1f} a second; reward {total:.1f}; "
              + ("the end of the track" if info["along"] >= TRACK_M else
                 "on the buoy" if info["buoy"] < HIT_M else
                 "truncated" if truncated else "lost"))


if __name__ == "__main__":
    try:
        main()
    except PelagosError as error:
        sys.exit(f"usv_env.py: {error}")
