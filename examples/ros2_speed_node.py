"""A ROS 2 node that chooses the speed of a robot along its path, with hazbot_gym.

This is an example to copy. It was NOT RUN under ROS by its authors, who had none: only the part
without ROS (``Inputs``) is tested. No policy of the library has driven a real robot: keep a
certified safety layer that can stop the robot without this node.

    ros2 run PACKAGE ros2_speed_node --ros-args -p policy:=ppo -p tier:=sonar -p robot:=robot.yaml

Subscribes, all in one fixed frame (parameter ``frame``):

- ``odom`` (nav_msgs/Odometry): pose in the fixed frame, velocity in the robot's
- ``plan`` (nav_msgs/Path): the path to follow; a new one begins a new round
- ``range/NAME`` (sensor_msgs/Range): one topic for each range sensor of the robot file
- ``people`` (people_msgs/People): tracked people; only with the tier ``tracks``

Publishes:

- ``speed`` (std_msgs/Float64): the speed to drive along the path [m/s], once in a decision period.
  Your path tracker steers, and must stop if this topic is silent for 0.3 s. Do not send it to
  Nav2's ``speed_limit``, where 0 means no limit.
- ``stop_reason`` (std_msgs/String): why the watchdog stops the robot; empty while it drives

Parameters: ``policy``, ``tier``, ``robot`` (YAML file, required), ``frame``, ``stale_s``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hazbot_gym import SpeedController

try:
    import rclpy
    from nav_msgs.msg import Odometry, Path
    from people_msgs.msg import People
    from rclpy.node import Node
    from rclpy.qos import qos_profile_sensor_data
    from sensor_msgs.msg import Range
    from std_msgs.msg import Float64, String
except ModuleNotFoundError:  # so that ``Inputs`` can be tested without ROS
    Node = object

LOOK_AHEAD_M = 1.0  # at which the policy sees the path's curvature
ARC_M = 0.5  # length over which that curvature is measured


class Inputs:
    """The newest messages, and the readings that they make: the part without ROS."""

    def __init__(self, names: Sequence[str], *, has_people: bool) -> None:
        self.ranges_m = dict.fromkeys(names, math.nan)
        self.people: list[dict[str, Any]] = []
        self.route = np.zeros((0, 2))
        self.pose = (0.0, 0.0, 0.0)
        self.velocity = (0.0, 0.0)
        # A topic that has never been heard has an infinite age, so that the robot stands.
        topics = (*names, "odom", *(["people"] if has_people else []))
        self.heard_s = dict.fromkeys(topics, -math.inf)

    def hear_range(self, name: str, message: Any, now_s: float) -> None:
        """Keep a range; readings beyond the sensor's limits are none (REP 117)."""
        range_m = message.range
        if range_m > message.max_range:
            range_m = math.inf
        self.ranges_m[name], self.heard_s[name] = range_m, now_s

    def hear_odometry(self, message: Any, now_s: float) -> None:
        """Keep pose and velocity."""
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        yaw = math.atan2(2.0 * turn.w * turn.z, 1.0 - 2.0 * turn.z**2)  # for turns about z
        self.pose = place.x, place.y, yaw
        twist = message.twist.twist
        self.velocity = twist.linear.x, twist.angular.z
        self.heard_s["odom"] = now_s

    def hear_people(self, message: Any, now_s: float) -> None:
        """Keep people in the fixed frame; the tracker must report empty lists, too."""
        self.people = [
            {"track": one.name, "place": one.position, "velocity": one.velocity}
            for one in message.people
        ]
        self.heard_s["people"] = now_s

    def hear_path(self, message: Any) -> None:
        """Keep the path, without points that repeat."""
        points = np.array([[p.pose.position.x, p.pose.position.y] for p in message.poses])
        points = points.reshape(-1, 2)
        moves = np.hypot(*np.diff(points, axis=0).T) > 1e-6 if len(points) else []
        self.route = points[np.concatenate([[True], moves])] if len(points) else points

    def readings(self, now_s: float) -> dict[str, Any]:
        """Return the arguments of ``SpeedController.step``.

        Without a path the path's fields are missing, and the robot stands.
        """
        speed_mps, yaw_rate_radps = self.velocity
        return {
            "ranges_m": self.ranges_m,
            "speed_mps": speed_mps,
            "yaw_rate_radps": yaw_rate_radps,
            "people": [self._in_robot_frame(one) for one in self.people],
            "age_s": max(0.0, now_s - min(self.heard_s.values())),
            **(along(self.route, self.pose) if len(self.route) > 1 else {}),
        }

    def _in_robot_frame(self, one: Mapping[str, Any]) -> dict[str, Any]:
        """Return a person relative to the robot; the velocity stays over ground."""
        x, y, yaw = self.pose
        place, velocity = one["place"], one["velocity"]
        x_m, y_m = _turned(place.x - x, place.y - y, yaw)
        vx_mps, vy_mps = _turned(velocity.x, velocity.y, yaw)
        return {
            "x_m": x_m, "y_m": y_m, "vx_mps": vx_mps, "vy_mps": vy_mps, "track": one["track"],
        }  # fmt: skip


def _turned(x: float, y: float, yaw: float) -> tuple[float, float]:
    """Return the components ahead and to the left of a vector in the fixed frame."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return cosine * x + sine * y, cosine * y - sine * x


def along(route: np.ndarray, pose: tuple[float, float, float]) -> dict[str, float]:
    """Return the fields of the path for a robot, from the nearest point of a polyline.

    A path tracker with a reference point that moves gives its own errors instead; here that point
    is abreast of the robot, so that the along-track error is 0.
    """
    starts, steps = route[:-1], np.diff(route, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    position = np.array(pose[:2])
    shares = np.einsum("ij,ij->i", position - starts, steps) / lengths**2
    shares = np.clip(shares, 0.0, 1.0)
    offsets = position - (starts + shares[:, None] * steps)
    k = int(np.argmin(np.hypot(offsets[:, 0], offsets[:, 1])))
    ends = np.cumsum(lengths)
    heading = math.atan2(steps[k, 1], steps[k, 0])
    s = ends[k] - (1.0 - shares[k]) * lengths[k]

    def heading_at(distance: float) -> float:
        i = min(int(np.searchsorted(ends, distance)), len(ends) - 1)
        return math.atan2(steps[i, 1], steps[i, 0])

    bend = heading_at(s + LOOK_AHEAD_M + ARC_M / 2) - heading_at(s + LOOK_AHEAD_M - ARC_M / 2)
    return {
        "x_e_m": 0.0,
        "y_e_m": float(_turned(*offsets[k], heading)[1]),
        "theta_e_rad": math.remainder(pose[2] - heading, math.tau),
        "remaining_m": float(ends[-1] - s),
        "curvature_ahead_per_m": math.remainder(bend, math.tau) / ARC_M,
    }


class SpeedNode(Node):  # type: ignore[misc,valid-type,unused-ignore]
    """The node: newest messages in, one speed in each decision period out."""

    def __init__(self) -> None:
        super().__init__("hazbot_speed")
        defaults = {"policy": "ppo", "tier": "sonar", "robot": "", "frame": "odom", "stale_s": 0.3}
        for name, default in defaults.items():
            self.declare_parameter(name, default)
        given = {name: self.get_parameter(name).value for name in ("policy", "tier", "robot")}
        # Refuses a robot that the policy is not made for, and loads all compiled code: seconds.
        self.controller = SpeedController(**given, stale_s=self.get_parameter("stale_s").value)
        self.frame = self.get_parameter("frame").value
        layout = self.controller.layout
        names = [sensor.name for sensor in layout.sensors]
        self.inputs = Inputs(names, has_people=layout.has_people)
        self.reason = None

        sensor_data = qos_profile_sensor_data
        self.create_subscription(Odometry, "odom", self.on_odometry, sensor_data)
        self.create_subscription(Path, "plan", self.on_path, 1)
        for name in names:
            self.create_subscription(Range, f"range/{name}", self.range_of(name), sensor_data)
        if layout.has_people:
            self.create_subscription(People, "people", self.on_people, sensor_data)
        self.speed = self.create_publisher(Float64, "speed", 1)
        self.stop_reason = self.create_publisher(String, "stop_reason", 1)
        self.create_timer(self.controller.robot.decision_period_s, self.decide)

    def stamp_s(self, message) -> float:
        """Return when a message was measured: its own stamp, not its arrival."""
        return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec

    def is_ours(self, message) -> bool:
        """Return False for a message in another frame, which would be misread."""
        if message.header.frame_id == self.frame:
            return True
        self.get_logger().error(f"frame {message.header.frame_id!r}, expected {self.frame!r}")
        return False

    def range_of(self, name):
        """Return the callback of one range sensor."""
        return lambda message: self.inputs.hear_range(name, message, self.stamp_s(message))

    def on_odometry(self, message) -> None:
        """Keep pose and velocity."""
        if self.is_ours(message):
            self.inputs.hear_odometry(message, self.stamp_s(message))

    def on_people(self, message) -> None:
        """Keep people."""
        if self.is_ours(message):
            self.inputs.hear_people(message, self.stamp_s(message))

    def on_path(self, message) -> None:
        """Begin a new round on a new path."""
        if self.is_ours(message):
            self.inputs.hear_path(message)
            self.controller.reset()

    def decide(self) -> None:
        """Ask the policy, and publish its speed and why it stops."""
        now_s = 1e-9 * self.get_clock().now().nanoseconds
        self.speed.publish(Float64(data=self.controller.step(**self.inputs.readings(now_s))))
        stop = self.controller.stop
        reason = f"{stop.cause}: {stop.message}" if stop else ""
        self.stop_reason.publish(String(data=reason))
        if reason and reason != self.reason:
            self.get_logger().warning(reason)
        self.reason = reason


def main() -> None:
    """Run the node until it is interrupted."""
    rclpy.init()
    node = SpeedNode()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.speed.publish(Float64(data=0.0))
        node.destroy_node()


if __name__ == "__main__":
    main()
