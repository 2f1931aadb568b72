#!/usr/bin/python3
"""The bridge to ROS 2. Its mapping with message classes made of ROS 2's own
lists of fields, which are compared with Debian's ROS 1 packages where the two
agree; its node with an rclpy of a few lines, against a daemon; its package by
colcon."""
import ast
import importlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import types
import unittest
import xml.etree.ElementTree as ET

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import ROOT, SLOW_S
from python_client_test import OceanCase
PACKAGE = pathlib.Path(ROOT) / "clients/ros2/pelagos_bridge"
sys.path.insert(0, str(PACKAGE))
import pelagos
from pelagos import Camera, Entity, Intrinsics, Ocean, Origin
from pelagos_bridge import mapping

PATIENCE_S = 10 * SLOW_S
F, I, S, B = float, int, str, bytes

# common_interfaces, rcl_interfaces and geometry2 of ROS 2 (the same in Humble
# and Jazzy): name of the package, then each field with its type; a list: a
# sequence, of so many where a number follows.
FIELDS = {
    "Time": ("builtin_interfaces", {"sec": I, "nanosec": I}),
    "Header": ("std_msgs", {"stamp": "Time", "frame_id": S}),
    "Clock": ("rosgraph_msgs", {"clock": "Time"}),
    "Point": ("geometry_msgs", {"x": F, "y": F, "z": F}),
    "Vector3": ("geometry_msgs", {"x": F, "y": F, "z": F}),
    "Quaternion": ("geometry_msgs", {"x": F, "y": F, "z": F, "w": F}),
    "Pose": ("geometry_msgs", {"position": "Point",
                               "orientation": "Quaternion"}),
    "PoseWithCovariance": ("geometry_msgs", {"pose": "Pose",
                                             "covariance": [F, 36]}),
    "Twist": ("geometry_msgs", {"linear": "Vector3", "angular": "Vector3"}),
    "TwistWithCovariance": ("geometry_msgs", {"twist": "Twist",
                                              "covariance": [F, 36]}),
    "Transform": ("geometry_msgs", {"translation": "Vector3",
                                    "rotation": "Quaternion"}),
    "TransformStamped": ("geometry_msgs", {
        "header": "Header", "child_frame_id": S, "transform": "Transform"}),
    "Odometry": ("nav_msgs", {
        "header": "Header", "child_frame_id": S, "pose": "PoseWithCovariance",
        "twist": "TwistWithCovariance"}),
    "Image": ("sensor_msgs", {
        "header": "Header", "height": I, "width": I, "encoding": S,
        "is_bigendian": I, "step": I, "data": B}),
    "CompressedImage": ("sensor_msgs", {"header": "Header", "format": S,
                                        "data": B}),
    "RegionOfInterest": ("sensor_msgs", {
        "x_offset": I, "y_offset": I, "height": I, "width": I,
        "do_rectify": bool}),
    "CameraInfo": ("sensor_msgs", {
        "header": "Header", "height": I, "width": I, "distortion_model": S,
        "d": [F], "k": [F, 9], "r": [F, 9], "p": [F, 12], "binning_x": I,
        "binning_y": I, "roi": "RegionOfInterest"}),
    "NavSatStatus": ("sensor_msgs", {"status": I, "service": I}),
    "NavSatFix": ("sensor_msgs", {
        "header": "Header", "status": "NavSatStatus", "latitude": F,
        "longitude": F, "altitude": F, "position_covariance": [F, 9],
        "position_covariance_type": I}),
    "TFMessage": ("tf2_msgs", {"transforms": ["TransformStamped"]}),
}
# pelagos_msgs/srv/WaveHeights.srv as it stands there.
SERVICE = (PACKAGE.parent / "pelagos_msgs/srv/WaveHeights.srv").read_text()


def make_message(name, fields):
    """As rclpy's: fields by keyword, of their types, and no others."""

    def initial(kind):
        if isinstance(kind, str):
            return CLASSES[kind]()
        if isinstance(kind, list):
            return [0.0] * kind[1] if len(kind) == 2 else []
        return kind()

    def check(field, kind, value):
        if isinstance(kind, list):
            value = list(value)
            if len(kind) == 2 and len(value) != kind[1]:
                raise AssertionError(f"{name}.{field}: {len(value)} elements")
            for one in value:
                check(field, kind[0], one)
        elif isinstance(kind, str):
            assert type(value) is CLASSES[kind], (name, field, value)
        elif kind is B:
            assert isinstance(value, bytes), (name, field)
        else:  # rclpy takes no NumPy scalar but float64, which is a float
            assert type(value) is kind or (kind is F and isinstance(
                value, float)), (name, field, type(value))

    class Message:
        __slots__ = tuple("_" + f for f in fields)

        def __init__(self, **given):
            assert given.keys() <= fields.keys(), (name, given.keys())
            for field, kind in fields.items():
                setattr(self, field, given.get(field) if field in given
                        else initial(kind))

        @classmethod
        def get_fields_and_field_types(cls):
            return dict(fields)

        def __repr__(self):
            return f"{name}({', '.join(f'{f}={getattr(self, f)!r}' for f in fields)})"

    def of(field, kind):
        def put(self, value):
            check(field, kind, value)
            setattr(self, "_" + field, value)
        return property(lambda self: getattr(self, "_" + field), put)
    for field, kind in fields.items():
        setattr(Message, field, of(field, kind))
    Message.__name__ = name
    return Message


CLASSES = {}
for _name, (_, _fields) in FIELDS.items():
    CLASSES[_name] = make_message(_name, _fields)


def service_part(text):
    kinds = {"bool": bool, "string": S, "float64": F, "Point": "Point",
             "Time": "Time", "Vector3": "Vector3"}
    fields = {}
    for line in text.splitlines():
        if line.strip() and not line.startswith("#"):
            kind, name = line.split()
            inner = kinds[kind.removesuffix("[]").split("/")[-1]]
            fields[name] = [inner] if kind.endswith("[]") else inner
    return fields


WaveRequest, WaveResponse = (make_message("WaveHeights" + part, service_part(
    text)) for part, text in zip(("Request", "Response"),
                                 SERVICE.split("\n---\n")))
T = types.SimpleNamespace(**CLASSES)


class FieldLists(unittest.TestCase):
    def test_of_ros_1_where_both_agree(self):
        """Debian 12 has ROS 1's messages: the same fields but for the header's
        seq, CameraInfo's capitals and the names of a time's parts."""
        for name, (package, fields) in FIELDS.items():
            if package == "builtin_interfaces":
                continue
            module = importlib.import_module(package + ".msg")
            old = [f for f in getattr(module, name).__slots__ if f != "seq"]
            if name == "CameraInfo":
                old = [f.lower() if len(f) == 1 else f for f in old]
            self.assertEqual(old, list(fields), name)

    def test_service_is_well_formed(self):
        import genmsg.msg_loader
        import genmsg.msgs
        context = genmsg.msg_loader.MsgContext.create_default()
        spec = genmsg.msg_loader.load_srv_from_string(
            context, SERVICE.replace("builtin_interfaces/Time", "time"),
            "pelagos_msgs/WaveHeights")
        self.assertEqual(spec.request.names, list(
            WaveRequest.get_fields_and_field_types()))
        self.assertEqual(spec.response.names, list(
            WaveResponse.get_fields_and_field_types()))
        cmake = (PACKAGE.parent / "pelagos_msgs/CMakeLists.txt").read_text()
        self.assertIn('"srv/WaveHeights.srv"', cmake)


class Mapping(unittest.TestCase):
    ORIGIN = Origin(latitude=52.6, longitude=5.2)

    def test_axes(self):
        """REP 103 by hand: a ship that heads east, bow up, starboard down."""
        level = mapping.body_rotation(90, 0, 0)
        np.testing.assert_allclose(level, np.eye(3), atol=1e-15)
        north = mapping.body_rotation(0, 0, 0)
        np.testing.assert_allclose(north[:, 0], [0, 1, 0], atol=1e-15)
        np.testing.assert_allclose(north[:, 1], [-1, 0, 0], atol=1e-15)  # port
        bow = mapping.body_rotation(90, 10, 0)[:, 0]
        self.assertAlmostEqual(bow[2], np.sin(np.radians(10)))
        starboard = -mapping.body_rotation(90, 0, 10)[:, 1]
        self.assertAlmostEqual(starboard[2], -np.sin(np.radians(10)))

    def test_rotations_go_round(self):
        random = np.random.default_rng(1)
        for heading, pitch, roll in [(0, 0, 0), (180, 0, 180), (359.9, 80, -170),
                                     *random.uniform([0, -89, -180],
                                                     [360, 89, 180], (60, 3))]:
            rotation = mapping.body_rotation(heading, pitch, roll)
            q = mapping.quaternion_of(rotation)
            self.assertAlmostEqual(np.linalg.norm(q), 1)
            np.testing.assert_allclose(mapping.matrix_of(q), rotation,
                                       atol=1e-12)
            back = np.subtract(mapping.attitude_of(rotation),
                               (heading, pitch, roll))
            np.testing.assert_allclose((back + 180) % 360 - 180, 0, atol=1e-6)

    def test_time(self):
        for seconds, parts in ((0.0, (0, 0)), (1.5, (1, 500000000)),
                               (0.9999999996, (1, 0)), (123456.25,
                                                        (123456, 250000000))):
            stamp = mapping.stamp(T, seconds)
            self.assertEqual((stamp.sec, stamp.nanosec), parts)
        self.assertEqual(mapping.seconds_of(mapping.stamp(T, 7.125)), 7.125)
        self.assertEqual(mapping.clock(T, 2.5).clock.nanosec, 500000000)

    def test_pictures(self):
        picture = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)
        m = mapping.image(T, 1.0, "a_optical_frame", picture)
        self.assertEqual((m.height, m.width, m.step, m.encoding, len(m.data),
                          m.header.frame_id),
                         (2, 3, 9, "rgb8", 18, "a_optical_frame"))
        self.assertEqual(m.data[:3], bytes([0, 1, 2]))
        jpeg = mapping.compressed(T, 1.0, "a", b"\xff\xd8")
        self.assertEqual((jpeg.format, jpeg.data), ("jpeg", b"\xff\xd8"))
        # A wall 10 m ahead, square to the axis, is 10 m in all of the picture.
        camera = Intrinsics(4, 3, -1, 1, 0.75, -0.75)
        ray = 10 / camera.rays()[..., 2]
        ray[0, 0] = np.inf
        m = mapping.depth_image(T, 1.0, "a", ray, camera)
        depth = np.frombuffer(m.data, "<f4").reshape(3, 4)
        self.assertEqual((m.encoding, m.step, np.isinf(depth[0, 0])),
                         ("32FC1", 16, True))
        np.testing.assert_allclose(depth.ravel()[1:], 10, rtol=1e-6)

    def test_camera_info(self):
        """The principal point of a picture of 4 pixels is between the middle
        two, 1.5 as ROS counts; P projects as K does."""
        m = mapping.camera_info(T, 1.0, "a", Intrinsics(4, 2, -1, 1, 0.5, -0.5))
        self.assertEqual(m.k, [2, 0, 1.5, 0, 2, 0.5, 0, 0, 1])
        self.assertEqual(m.p, [2, 0, 1.5, 0, 0, 2, 0.5, 0, 0, 0, 1, 0])
        self.assertEqual((m.height, m.width, m.d, m.r[::4]),
                         (2, 4, [0] * 5, [1, 1, 1]))
        off_axis = mapping.camera_info(T, 1.0, "a",
                                       Intrinsics(4, 2, -0.5, 1.5, 0.5, -0.5))
        self.assertEqual(off_axis.k[2], 0.5)

    def odometry(self, **fields):
        entity = Entity(**{**dict(id=1, latitude=52.7, longitude=5.5), **fields})
        return entity, mapping.entity_odometry(T, 3.0, "map", "base_link",
                                               entity, self.ORIGIN)

    def test_odometry_goes_round(self):
        random = np.random.default_rng(3)
        for values in random.uniform(
                [52, 4, -3, 0, -40, -60, 0.1, 0, -20, -3, -9, -9],
                [53, 6, 3, 360, 40, 60, 20, 360, 20, 3, 9, 9], (40, 12)):
            given = dict(zip(
                ("latitude", "longitude", "altitude", "heading", "pitch",
                 "roll", "speed", "course", "turnRate", "climbRate",
                 "pitchRate", "rollRate"), map(float, values)))
            _, odometry = self.odometry(**given)
            back = mapping.odometry_entity(odometry, self.ORIGIN)
            self.assertEqual(set(back), set(given))
            for name, value in given.items():
                self.assertAlmostEqual(back[name], value, places=6, msg=name)

    def test_odometry_by_hand(self):
        """Half a knot sideways, turning to port, as a vessel at the origin."""
        m = T.Odometry()
        m.pose.pose.orientation.w = 1.0  # heads east
        m.twist.twist.linear.x, m.twist.twist.linear.y = 3.0, 4.0
        m.twist.twist.angular.z = 0.1
        fields = mapping.odometry_entity(m, self.ORIGIN)
        self.assertAlmostEqual(fields["heading"], 90)
        self.assertAlmostEqual(fields["speed"], 5)
        self.assertAlmostEqual(fields["course"], 90 - np.degrees(
            np.arctan2(4, 3)))
        self.assertAlmostEqual(fields["turnRate"], -np.degrees(0.1))
        self.assertAlmostEqual(fields["latitude"], 52.6)
        m.pose.pose.position.x = float("nan")
        with self.assertRaises(ValueError):
            mapping.odometry_entity(m, self.ORIGIN)
        with self.assertRaises(ValueError):  # all of the orientation is 0
            mapping.odometry_entity(T.Odometry(), self.ORIGIN)

    def test_transforms(self):
        entity = Entity(latitude=52.6, longitude=5.2, altitude=2.0, heading=0.0)
        m = mapping.entity_transform(T, 1.0, "map", "base_link", entity,
                                     self.ORIGIN)
        self.assertEqual((m.header.frame_id, m.child_frame_id,
                          m.transform.translation.z), ("map", "base_link", 2))
        self.assertAlmostEqual(m.transform.rotation.z, np.sqrt(0.5))
        # ECEF of 52.6 N 5.2 E on the ellipsoid, by gdaltransform
        # (PROJ), EPSG:4979 to 4978.
        earth = mapping.earth_transform(T, 0.0, "earth", "map", self.ORIGIN)
        t, q = earth.transform.translation, earth.transform.rotation
        np.testing.assert_allclose(
            (t.x, t.y, t.z), (3866158.27138793, 351847.965562917,
                            5043631.03921096), atol=1e-6)
        axes = mapping.matrix_of((q.x, q.y, q.z, q.w))
        np.testing.assert_allclose(axes[2], [0, np.cos(np.radians(52.6)),
                                             np.sin(np.radians(52.6))],
                                   atol=1e-12)
        # An eye that looks north: its z is map's y, its x map's x.
        camera = Camera(Intrinsics(4, 2, -1, 1, 0.5, -0.5),
                        np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
                        np.array([1.0, 2, 3]))
        m = mapping.camera_transform(T, 1.0, "map", "a", camera)
        r = mapping.matrix_of((m.transform.rotation.x, m.transform.rotation.y,
                               m.transform.rotation.z, m.transform.rotation.w))
        np.testing.assert_allclose(r[:, 2], [0, 1, 0], atol=1e-12)
        np.testing.assert_allclose(r[:, 1], [0, 0, -1], atol=1e-12)

    def test_fix(self):
        m = mapping.fix(T, 1.0, "base_link", Entity(latitude=1.0, longitude=2.0))
        self.assertEqual((m.latitude, m.longitude, m.altitude), (1, 2, 0))


class FakeNode:
    """What the bridge uses of rclpy.node.Node."""
    given = {}

    def __init__(self, name):
        self.published, self.subscribed = {}, {}
        self.services, self.timers, self.errors = {}, [], []

    def declare_parameter(self, name, default):
        return types.SimpleNamespace(value=self.given.get(name, default))

    def create_publisher(self, kind, topic, qos):
        sent = self.published.setdefault(topic, [])

        def publish(message):
            assert type(message) is kind, (topic, message)
            sent.append(message)
        return types.SimpleNamespace(publish=publish)

    def create_subscription(self, kind, topic, callback, qos,
                            callback_group=None):
        self.subscribed[topic] = (kind, callback)

    def create_service(self, kind, name, callback, callback_group=None):
        self.services[name] = (kind, callback)

    def create_timer(self, period, callback):
        self.timers.append((period, callback))

    def get_logger(self):
        return types.SimpleNamespace(error=self.errors.append,
                                     warning=self.errors.append)

    def destroy_node(self):
        return True


def fake_modules(service):
    def module(name, **members):
        made = types.ModuleType(name)
        vars(made).update(members)
        return made
    group = type("Group", (), {})
    out = {
        "rclpy": module("rclpy", init=lambda args: None),
        "rclpy.node": module("rclpy.node", Node=FakeNode),
        "rclpy.callback_groups": module(
            "rclpy.callback_groups", ReentrantCallbackGroup=group,
            MutuallyExclusiveCallbackGroup=group),
        "rclpy.executors": module("rclpy.executors",
                                  MultiThreadedExecutor=group),
        "rclpy.qos": module(
            "rclpy.qos", qos_profile_sensor_data=5,
            QoSProfile=lambda depth, durability: (depth, durability),
            DurabilityPolicy=types.SimpleNamespace(TRANSIENT_LOCAL=1)),
    }
    for name, (package, _) in FIELDS.items():
        out.setdefault(package, module(package))
        out.setdefault(package + ".msg", module(package + ".msg"))
        setattr(out[package + ".msg"], name, CLASSES[name])
    out["pelagos_msgs"] = module("pelagos_msgs")
    out["pelagos_msgs.srv"] = module("pelagos_msgs.srv", **(
        {"WaveHeights": "WaveHeights"} if service else {}))
    return out


class TheNode(OceanCase):
    def make(self, service=True, **given):
        FakeNode.given = {"url": self.url, "timeout": PATIENCE_S, **given}
        kept = dict(sys.modules)
        sys.modules.update(fake_modules(service))
        sys.modules.pop("pelagos_bridge.node", None)
        try:
            from pelagos_bridge import node
            bridge = node.Bridge()
        finally:
            for name in set(sys.modules) - set(kept):
                if name.startswith(("rclpy", "pelagos_msgs")):
                    del sys.modules[name]
            sys.modules.update(kept)
        self.addCleanup(bridge.destroy_node)
        return bridge

    def setUp(self):
        self.ocean = Ocean(self.url, timeout=PATIENCE_S)
        self.addCleanup(self.ocean.close)
        self.ocean.reset(2, {"views": [{"name": "bow", "entity": 1, "up": 5,
                                        "width": 64, "height": 36}]})

    def test_a_moment_of_all_topics(self):
        bridge = self.make(views=["bow"], depth=True, step=0.25, rate=20.0)
        self.assertEqual(bridge.timers[0][0], 0.05)
        self.ocean.entities[1].set(heading=30, speed=2, course=30)
        bridge.timers[0][1]()
        out = bridge.published
        self.assertEqual(bridge.errors, [])
        self.assertEqual({t: len(m) for t, m in out.items()}, {
            "/clock": 1, "/tf": 2, "/tf_static": 1, "pose": 1, "fix": 1,
            "bow/camera_info": 1, "bow/image_raw": 1,
            "bow/depth/image_raw": 1})
        self.assertEqual(mapping.seconds_of(out["/clock"][0].clock), 0.25)
        image, info = out["bow/image_raw"][0], out["bow/camera_info"][0]
        depth = out["bow/depth/image_raw"][0]
        self.assertEqual({mapping.seconds_of(m.header.stamp) for m in
                          (image, info, depth)}, {0.25})
        np.testing.assert_array_equal(
            np.frombuffer(image.data, np.uint8).reshape(36, 64, 3),
            self.ocean.image("bow", time=0.25))
        # A pixel of depth, by camera_info and /tf, is on the sea.
        z = np.frombuffer(depth.data, "<f4").reshape(36, 64)
        k = np.reshape(info.k, (3, 3))
        frame = next(t for m in out["/tf"] for t in m.transforms
                     if t.child_frame_id == "bow_optical_frame").transform
        turn = mapping.matrix_of((frame.rotation.x, frame.rotation.y,
                                  frame.rotation.z, frame.rotation.w))
        at = np.array([frame.translation.x, frame.translation.y,
                       frame.translation.z])
        for v, u in ((30, 20), (34, 50)):
            ray = np.linalg.solve(k, [u, v, 1.0])
            place = at + turn @ (ray * z[v, u])
            self.assertAlmostEqual(
                place[2], float(self.ocean.surface(place[:2], 0.25).height),
                delta=0.03)
        self.assertEqual(out["/tf_static"][0].transforms[0].child_frame_id,
                         "map")

    def test_compressed_and_quiet(self):
        bridge = self.make(views=["bow"], compressed=True, publish_clock=False,
                           publish_tf=False, publish_odometry=False)
        bridge.timers[0][1]()
        self.assertEqual({t for t, m in bridge.published.items() if m},
                         {"bow/camera_info", "bow/image_raw/compressed"})
        self.assertEqual(bridge.published["bow/image_raw/compressed"][0]
                         .data[:2], b"\xff\xd8")
        self.ocean.views["bow"].remove()
        bridge.timers[0][1]()
        self.assertIn("bow", bridge.errors[0])

    def test_odometry_moves_the_entity(self):
        bridge = self.make(views=[], entity=5, pose_time=True)
        kind, take = bridge.subscribed["odom"]
        self.assertIs(kind, CLASSES["Odometry"])
        m = T.Odometry()
        m.header.stamp = mapping.stamp(T, 12.5)
        m.pose.pose.position.x, m.pose.pose.position.z = 100.0, 1.0
        m.pose.pose.orientation.w = 1.0
        m.twist.twist.linear.x = 4.0
        take(m)
        entity = self.ocean.entities[5].state
        self.assertEqual(bridge.errors, [])
        # True north there, 100 m east, is not quite the map's.
        self.assertAlmostEqual(entity.heading, 90, delta=0.002)
        self.assertEqual((entity.poseTime, entity.altitude, entity.speed),
                         (12.5, 1, 4))
        here = pelagos.to_local(entity.latitude, entity.longitude)
        self.assertAlmostEqual(here.east, 100, places=4)
        m.pose.pose.position.z = float("inf")
        take(m)
        self.assertIn("not finite", bridge.errors[-1])
        m.pose.pose.position.z = 1e6
        take(m)
        self.assertIn("altitude", bridge.errors[-1])

    def test_waves_are_answered(self):
        bridge = self.make(views=[])
        _, take = bridge.services["wave_heights"]
        request = WaveRequest(points=[T.Point(x=3.0, y=4.0),
                                      T.Point(x=-10.0, y=0.0)],
                              stamp=mapping.stamp(T, 8.0))
        answer = take(request, WaveResponse())
        there = self.ocean.surface([[3, 4], [-10, 0]], 8.0)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.heights, there.height.tolist())
        self.assertEqual(mapping.seconds_of(answer.stamp), 8)
        self.assertEqual(answer.normals[1].z, there.normal[1, 2])
        self.assertEqual(answer.velocities[0].x, there.velocity[0, 0])
        for bad in ([], [T.Point(x=float("nan"))], [T.Point(x=5e7)]):
            answer = take(WaveRequest(points=bad), WaveResponse())
            self.assertFalse(answer.success)
            self.assertTrue(answer.message)

    def test_without_the_service(self):
        bridge = self.make(service=False, views=[])
        self.assertEqual(bridge.services, {})
        self.assertIn("pelagos_msgs", bridge.errors[0])

    def test_readme_and_config_name_every_parameter(self):
        self.make(views=[])
        from pelagos_bridge import node
        readme = (PACKAGE / "README.md").read_text()
        for name, default in node.PARAMETERS:
            self.assertIn(f"| `{name}` |", readme)
        config = (PACKAGE / "config/bridge.yaml").read_text()
        named = {line.split(":")[0].strip() for line in config.splitlines()
                 if line.startswith("    ")}
        self.assertTrue(named <= {name for name, _ in node.PARAMETERS})


class Package(unittest.TestCase):
    def test_colcon_builds_it(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            shutil.copytree(PACKAGE, folder / "src/pelagos_bridge",
                            ignore=shutil.ignore_patterns("__pycache__"))
            done = subprocess.run(
                ["colcon", "--log-base", "log", "build"], cwd=folder,
                capture_output=True, text=True,
                env={**os.environ, "COLCON_HOME": str(folder / "home"),
                     "PATH": "/usr/bin:/bin"})
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("Finished <<< pelagos_bridge", done.stdout)
            made = folder / "install/pelagos_bridge"
            for file in ("lib/pelagos_bridge/bridge",
                         "share/pelagos_bridge/package.xml",
                         "share/pelagos_bridge/launch/bridge.launch.py",
                         "share/pelagos_bridge/config/bridge.yaml",
                         "share/ament_index/resource_index/packages/"
                         "pelagos_bridge"):
                self.assertTrue((made / file).exists(), file)
            where = next(made.glob("lib/python3*/site-packages"))
            said = subprocess.run(
                ["/usr/bin/python3", "-B", "-c",
                 "from pelagos_bridge import mapping; print(mapping.__file__)"],
                capture_output=True, text=True, cwd=folder, check=True,
                env={**os.environ, "PYTHONPATH": f"{where}:{ROOT}/clients/python"})
            self.assertIn(str(made), said.stdout)

    def test_humble(self):
        """Humble has the oldest Python of ROS 2, 3.10: client and
        bridge say so and use nothing newer, by mypy's lists of what each
        Python's library has (the client's: python_client_test)."""
        oldest = "3.10"
        client = pathlib.Path(ROOT) / "clients/python"
        said = (client / "pyproject.toml").read_text()
        self.assertIn(f'requires-python = ">={oldest}"', said)
        self.assertIn(f'python_version = "{oldest}"', said)
        self.assertIn(f'python_requires=">={oldest}"',
                      (PACKAGE / "setup.py").read_text())
        sources = [*client.glob("pelagos/**/*.py"), *PACKAGE.glob("**/*.py")]
        for file in sources:
            ast.parse(file.read_text(), str(file),
                      feature_version=tuple(map(int, oldest.split("."))))
        if not shutil.which("mypy"):
            self.skipTest("mypy is not installed")
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run(
                ["mypy", "--cache-dir", cache, "--python-version", oldest,
                 "--ignore-missing-imports", "--follow-imports", "silent",
                 str(PACKAGE / "pelagos_bridge")],
                capture_output=True, text=True, cwd=client)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_versions_and_dependencies(self):
        version = (pathlib.Path(ROOT) / "VERSION").read_text().strip()
        for package in ("pelagos_bridge", "pelagos_msgs"):
            tree = ET.parse(PACKAGE.parent / package / "package.xml")
            self.assertEqual(tree.find("version").text, version)
        self.assertIn(f'version="{version}"', (PACKAGE / "setup.py").read_text())
        named = {e.text for e in ET.parse(PACKAGE / "package.xml").iter(
            "exec_depend")}
        self.assertLessEqual({p for p, _ in FIELDS.values()}, named)


if __name__ == "__main__":
    unittest.main(verbosity=2)
