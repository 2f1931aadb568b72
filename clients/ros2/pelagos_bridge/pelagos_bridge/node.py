"""The node: what is asked of Pelagos when, and which topic has it."""
from __future__ import annotations

import types as module_types
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import (Point, Pose, PoseWithCovariance, Quaternion,
                               Transform, TransformStamped, Twist,
                               TwistWithCovariance, Vector3)
from nav_msgs.msg import Odometry
from rclpy.callback_groups import (MutuallyExclusiveCallbackGroup,
                                   ReentrantCallbackGroup)
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import (DurabilityPolicy, QoSProfile, qos_profile_sensor_data)
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import (CameraInfo, CompressedImage, Image, NavSatFix,
                             NavSatStatus)
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from pelagos import Camera, Ocean, Origin, PelagosError
from pelagos_bridge import mapping

TYPES = module_types.SimpleNamespace(
    Time=Time, Point=Point, Pose=Pose, PoseWithCovariance=PoseWithCovariance,
    Quaternion=Quaternion, Transform=Transform,
    TransformStamped=TransformStamped, Twist=Twist,
    TwistWithCovariance=TwistWithCovariance, Vector3=Vector3,
    Odometry=Odometry, Clock=Clock, CameraInfo=CameraInfo,
    CompressedImage=CompressedImage, Image=Image, NavSatFix=NavSatFix,
    NavSatStatus=NavSatStatus, Header=Header)

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

# Name, default: README.md says what each is.
PARAMETERS: tuple[tuple[str, Any], ...] = (
    ("url", ""), ("token", ""), ("timeout", 30.0), ("views", ["bridge"]),
    ("entity", 1), ("rate", 10.0), ("compressed", False), ("depth", False),
    ("step", 0.0), ("publish_clock", True), ("publish_tf", True),
    ("publish_odometry", True), ("pose_time", False), ("map_frame", "map"),
    ("base_frame", "base_link"), ("earth_frame", "earth"),
)


class Bridge(Node):  # type: ignore[misc]
    """Parameters and topics: README.md."""

    def __init__(self) -> None:
        super().__init__("pelagos_bridge")
        for name, default in PARAMETERS:
            setattr(self, "p_" + name,
                    self.declare_parameter(name, default).value)
        self.ocean = Ocean(self.p_url or None, token=self.p_token or None,
                           timeout=self.p_timeout)
        self.origin = self.ocean.state().origin or Origin()
        self.clock_out = (self.create_publisher(Clock, "/clock", 10)
                          if self.p_publish_clock else None)
        self.tf_out = self.create_publisher(TFMessage, "/tf", 100)
        self.static_out = self.create_publisher(TFMessage, "/tf_static",
                                                LATCHED)
        self.odometry_out = self.create_publisher(Odometry, "pose", 10)
        self.fix_out = self.create_publisher(NavSatFix, "fix", 10)
        self.cameras = {name: self.make_camera(name) for name in self.p_views}
        # Poses and waves do not wait for pictures.
        self.create_subscription(
            Odometry, "odom", self.take_odometry, 10,
            callback_group=MutuallyExclusiveCallbackGroup())
        self.make_service()
        if self.p_publish_tf:
            self.static_out.publish(TFMessage(transforms=[
                mapping.earth_transform(TYPES, 0.0, self.p_earth_frame,
                                        self.p_map_frame, self.origin)]))
        self.create_timer(1.0 / self.p_rate, self.tick)

    def make_camera(self, name: str) -> dict[str, Any]:
        out = {"info": self.create_publisher(
            CameraInfo, f"{name}/camera_info", qos_profile_sensor_data)}
        if self.p_compressed:
            out["image"] = self.create_publisher(
                CompressedImage, f"{name}/image_raw/compressed",
                qos_profile_sensor_data)
        else:
            out["image"] = self.create_publisher(
                Image, f"{name}/image_raw", qos_profile_sensor_data)
        if self.p_depth:
            out["depth"] = self.create_publisher(
                Image, f"{name}/depth/image_raw", qos_profile_sensor_data)
        return out

    def make_service(self) -> None:
        try:
            from pelagos_msgs.srv import WaveHeights
        except ImportError:
            self.get_logger().warning(
                "no service wave_heights: build and source pelagos_msgs")
        else:
            self.create_service(WaveHeights, "wave_heights", self.take_waves,
                                callback_group=ReentrantCallbackGroup())

    # --- from ROS ----------------------------------------------------------

    def take_odometry(self, odometry: Any) -> None:
        try:
            fields = mapping.odometry_entity(odometry, self.origin)
            if self.p_pose_time:
                fields["poseTime"] = mapping.seconds_of(odometry.header.stamp)
            self.ocean.entities.add(self.p_entity, **fields)
        except (PelagosError, ValueError) as error:
            self.get_logger().error(f"odom: {error}")

    def take_waves(self, request: Any, answer: Any) -> Any:
        try:
            # A stamp of 0 is no time: the clock's.
            time = mapping.seconds_of(request.stamp) or None
            surface = self.ocean.surface(mapping.wave_points(request), time)
        except (PelagosError, ValueError) as error:
            return mapping.wave_failure(answer, str(error))
        return mapping.wave_answer(TYPES, answer, surface)

    # --- to ROS -------------------------------------------------------------

    def tick(self) -> None:
        try:
            state = (self.ocean.step(self.p_step) if self.p_step > 0
                     else self.ocean.state())
            # One moment for all that is told.
            time = state.clock.time if state.clock else 0.0
            self.origin = state.origin or Origin()
            self.tell_time(time)
            self.tell_entity(time, state)
            for name, out in self.cameras.items():
                self.tell_camera(name, out, time)
        except PelagosError as error:
            self.get_logger().error(str(error))

    def tell_time(self, time: float) -> None:
        if self.clock_out is not None:
            self.clock_out.publish(mapping.clock(TYPES, time))

    def tell_entity(self, time: float, state: Any) -> None:
        entity = next((e for e in state.entities if e.id == self.p_entity),
                      None)
        if entity is None:
            return
        # A pose holds at poseTime; of what moves itself that is now.
        at = time if entity.poseTime is None else entity.poseTime
        if self.p_publish_tf:
            self.tf_out.publish(TFMessage(transforms=[
                mapping.entity_transform(TYPES, at, self.p_map_frame,
                                         self.p_base_frame, entity,
                                         self.origin)]))
        if self.p_publish_odometry:
            self.odometry_out.publish(mapping.entity_odometry(
                TYPES, at, self.p_map_frame, self.p_base_frame, entity,
                self.origin))
            self.fix_out.publish(mapping.fix(TYPES, at, self.p_base_frame,
                                             entity))

    def tell_camera(self, name: str, out: dict[str, Any],
                    time: float) -> None:
        frame = f"{name}_optical_frame"
        if self.p_depth:
            exr = self.ocean.frame(name, "exr", layers=("depth",),
                                   time=time).exr()
            camera = Camera.of_exr(exr)
            out["depth"].publish(mapping.depth_image(
                TYPES, time, frame, exr["depth"], camera.intrinsics))
        else:
            camera = self.ocean.views[name].camera(time=time)
        if self.p_compressed:
            picture = self.ocean.frame(name, "jpg", time=time)
            out["image"].publish(mapping.compressed(TYPES, time, frame,
                                                    picture.data))
        else:
            out["image"].publish(mapping.image(
                TYPES, time, frame, self.ocean.image(name, time=time)))
        out["info"].publish(mapping.camera_info(TYPES, time, frame,
                                                camera.intrinsics))
        if self.p_publish_tf:
            self.tf_out.publish(TFMessage(transforms=[
                mapping.camera_transform(TYPES, time, self.p_map_frame, frame,
                                         camera)]))

    def destroy_node(self) -> Any:
        self.ocean.close()
        return super().destroy_node()


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    node = Bridge()
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
