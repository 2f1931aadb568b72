#!/usr/bin/env python3
"""A hull in Gazebo that floats on Pelagos' sea: hears the poses of a world,
asks for the water at the hull's columns at that very simulated time, and
publishes the force and torque of buoyancy and drag.

    hull_wrench.py --world sea --model usv --link base_link
                   [--url http://127.0.0.1:8080] [--hull 5.4x2.6x0.4]

The world needs the system gz-sim-apply-link-wrench-system, and the model
gravity but no buoyancy of its own. Needs Gazebo Harmonic's Python packages
(python3-gz-transport13, python3-gz-msgs10); the class Hull needs NumPy alone.
"""
from __future__ import annotations

import argparse
import sys
import threading
from typing import Any

import numpy as np

from pelagos import Ocean, PelagosError

WATER_KG_M3 = 1025.0
GRAVITY = 9.81
Array = np.ndarray[Any, Any]


class Hull:
    """A box of columns about a body's origin, which lies amidships in the
    waterline: x forward, y to port, z up [m].

    mass      [kg]: that of the water it displaces at its draught
    columns   along and across; each is one point of a query
    """

    def __init__(self, length: float, beam: float, draught: float, *,
                 columns: tuple[int, int] = (6, 3), heave_damping: float = 0.4,
                 drag: float = 0.1) -> None:
        along, across = columns
        x = (np.arange(along) + 0.5) / along - 0.5
        y = (np.arange(across) + 0.5) / across - 0.5
        grid = np.stack(np.meshgrid(x * length, y * beam, indexing="ij"), -1)
        self.keel = np.concatenate(
            [grid.reshape(-1, 2), np.full((along * across, 1), -draught)], 1)
        self.area = length * beam / len(self.keel)
        self.draught = draught
        self.mass = WATER_KG_M3 * length * beam * draught
        # Of what is critical for heave of the whole.
        stiff = WATER_KG_M3 * GRAVITY * length * beam
        critical = 2 * np.sqrt(stiff * self.mass) / len(self.keel)
        self.damping = critical * np.array([drag, drag, heave_damping])

    def points(self, place: Array, rotation: Array) -> Array:
        """Of the columns' feet in the world, (n, 3)."""
        return place + self.keel @ rotation.T

    def wrench(self, place: Array, rotation: Array, velocity: Array,
               spin: Array, water: Any) -> tuple[Array, Array]:
        """Force and torque about the body's origin [N, N m], in the world's
        axes. rotation: body to world; velocity, spin: of the body in the
        world's axes; water: the Surface at the points."""
        feet = self.points(place, rotation)
        # A column is as high as to swim twice as deep.
        wet = np.clip(water.height - feet[:, 2], 0, 3 * self.draught)
        arm = feet - place
        slip = water.velocity - (velocity + np.cross(spin, arm))
        force = self.damping * slip * (wet / self.draught).clip(0, 1)[:, None]
        force[:, 2] += WATER_KG_M3 * GRAVITY * self.area * wet
        return force.sum(0), np.cross(arm, force).sum(0)


class Follower:
    """Of one link: from each pose to the wrench that belongs to it."""

    def __init__(self, ocean: Ocean, hull: Hull) -> None:
        self.ocean, self.hull = ocean, hull
        self.last: tuple[float, Array, Array] | None = None

    def take(self, time: float, place: Array, rotation: Array
             ) -> tuple[Array, Array] | None:
        """None for the first pose, whose velocity is not known, and for one
        that is no newer than the last."""
        last, velocity, spin = self.last, np.zeros(3), np.zeros(3)
        if last is not None:
            step = time - last[0]
            if step <= 0:
                return None
            velocity = (place - last[1]) / step
            turn = rotation @ last[2].T
            spin = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0],
                             turn[1, 0] - turn[0, 1]]) / (2 * step)
        self.last = (time, place, rotation)
        if last is None:
            return None
        feet = self.hull.points(place, rotation)
        water = self.ocean.surface(feet[:, :2], time)
        return self.hull.wrench(place, rotation, velocity, spin, water)


def rotation_of(q: Any) -> Array:
    x, y, z, w = np.array([q.x, q.y, q.z, q.w]) / np.linalg.norm(
        [q.x, q.y, q.z, q.w])
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def connect(follower: Follower, world: str, model: str, link: str) -> Any:
    """Subscribes to the world's poses; the node, which is to be kept."""
    from gz.msgs10.entity_pb2 import Entity
    from gz.msgs10.entity_wrench_pb2 import EntityWrench
    from gz.msgs10.pose_v_pb2 import Pose_V
    from gz.transport13 import Node
    node = Node()
    out = node.advertise(f"/world/{world}/wrench", EntityWrench)

    def take(poses: Any) -> None:
        stamp = poses.header.stamp
        for pose in poses.pose:
            if pose.name != model:
                continue
            p = pose.position
            given = follower.take(stamp.sec + 1e-9 * stamp.nsec,
                                  np.array([p.x, p.y, p.z]),
                                  rotation_of(pose.orientation))
            if given is not None:
                message = EntityWrench()
                message.entity.name = f"{model}::{link}"
                message.entity.type = Entity.LINK
                for part, value in zip((message.wrench.force,
                                        message.wrench.torque), given):
                    part.x, part.y, part.z = (float(v) for v in value)
                out.publish(message)

    node.subscribe(Pose_V, f"/world/{world}/dynamic_pose/info", take)
    return node


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--url", help="of pelagosd")
    parser.add_argument("--world", required=True)
    parser.add_argument("--model", required=True)
    parser.add_argument("--link", default="base_link")
    parser.add_argument("--hull", default="5.4x2.6x0.4",
                        help="length, beam, draught [m]")
    options = parser.parse_args()
    hull = Hull(*(float(n) for n in options.hull.split("x")))
    print(f"the link's mass is to be {hull.mass:.0f} kg")
    node = connect(Follower(Ocean(options.url), hull), options.world,
                   options.model, options.link)
    assert node
    threading.Event().wait()


if __name__ == "__main__":
    try:
        main()
    except PelagosError as error:
        sys.exit(f"hull_wrench.py: {error}")
    except KeyboardInterrupt:
        pass
