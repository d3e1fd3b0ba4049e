"""A ROS 2 node that publishes the knob as a joint, stamped with the time of the device.

The stamps are the device's own, moved to ROS's clock by one offset, so that their distances are the
device's. Needs `pip install --prefer-binary ros-rclpy ros-rmw-fastrtps-cpp ros-sensor-msgs`, or a
ROS 2 that is there already.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import rclpy
from rclpy.publisher import Publisher
from rclpy.time import Time
from sensor_msgs.msg import JointState

import torsio

# As many messages wait for a subscriber that is busy.
QUEUED = 1000
HAND = torsio.ImpedanceHand(
    intended_angle_rad=[(0.0, 0.0), (1.0, 0.2)],
    stiffness_nm_per_rad=0.5,
    damping_nm_s_per_rad=4e-3,
    inertia_kg_m2=1e-4,
)


def publish(
    knob: torsio.Knob,
    joint_states: Publisher,
    ros_time_ns: Callable[[], int],
    duration_s: float,
    rate_hz: float,
) -> int:
    """Publish the knob's telemetry for a while, and return how many messages that were."""
    knob.start_telemetry(rate_hz)
    before_ns = ros_time_ns()
    begin_s = knob.clock().time_s
    # The device answered between the two; half a millisecond is what a cable takes.
    offset_ns = (before_ns + ros_time_ns()) // 2 - round(1e9 * begin_s)
    sent = 0
    time_s = begin_s
    while time_s < begin_s + duration_s:
        for sample in knob.read():
            time_s = float(sample["time_s"])
            message = JointState(name=["knob"])
            message.header.stamp = Time(nanoseconds=offset_ns + round(1e9 * time_s)).to_msg()
            message.position = [float(sample["angle_rad"])]
            message.velocity = [float(sample["speed_rad_s"])]
            # Torques on the knob, without the hand's.
            message.effort = [float(sample["spring_torque_nm"] + sample["motor_command_nm"])]
            joint_states.publish(message)
            sent += 1
    return sent


def main(device: str = "emulated", duration_s: str = "2", rate_hz: str = "200") -> None:
    """Play a wall, and publish what happens at it for a while."""
    # In real time, as a plugged-in knob is.
    emulator = torsio.EmulatorOptions(paced=True) if device == "emulated" else None
    with rclpy.init(), torsio.open(device, emulator=emulator) as knob:
        knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.0))
        knob.arm()
        if knob.is_emulated:  # a real one is turned by you
            knob.emulator.set_hand(HAND)
        node = rclpy.create_node("torsio")
        joint_states = node.create_publisher(JointState, "joint_states", QUEUED)
        clock = node.get_clock()
        sent = publish(
            knob, joint_states, lambda: clock.now().nanoseconds, float(duration_s), float(rate_hz)
        )
        node.destroy_node()
    print(f"{sent} messages on joint_states")


if __name__ == "__main__":
    main(*sys.argv[1:])
