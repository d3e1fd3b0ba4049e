"""The example for ROS 2, with ROS's own library, in the environment that `./dev ros` makes.

By its name it is none of the tests that `./dev test` finds, since it needs that environment.
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import torsio

TREE = Path(__file__).parents[2]
PYTHON = TREE / "build/ros/bin/python"
EXAMPLE = TREE / "examples/ros/publish_joint_state.py"
RATE_HZ = 200.0
COUNT_RAD = 2 * np.pi / 8192  # the emulated encoder's

# The knob keeps no pace with the clock, so that all stamps are of the device's alone.
SENDER = """
import json, sys, time
import publish_joint_state as example
import rclpy, torsio
from rclpy.duration import Duration
from sensor_msgs.msg import JointState

emulator = torsio.EmulatorOptions(log_truth=True)
with rclpy.init(), torsio.open("emulated", emulator=emulator) as knob:
    knob.play(torsio.Wall(angle_rad=0.5, stiffness_nm_per_rad=0.05))
    knob.arm()
    # Fast enough that no two ticks in a row are at the same angle.
    knob.emulator.set_hand(torsio.ImpedanceHand(
        intended_angle_rad=[(0.0, 0.0), (2.0, 8.0)], stiffness_nm_per_rad=0.5,
        damping_nm_s_per_rad=4e-3, inertia_kg_m2=1e-4,
    ))
    knob.emulator.advance(0.25)
    node = rclpy.create_node("torsio")
    joint_states = node.create_publisher(JointState, "joint_states", example.QUEUED)
    while joint_states.get_subscription_count() == 0:
        time.sleep(0.01)
    device_s = [knob.clock().time_s]
    ros_ns = [node.get_clock().now().nanoseconds]
    sent = example.publish(
        knob, joint_states, lambda: node.get_clock().now().nanoseconds, 1.0, float(sys.argv[1])
    )
    ros_ns.append(node.get_clock().now().nanoseconds)
    device_s.append(knob.clock().time_s)
    truth = knob.emulator.truth()
    print(json.dumps({
        "sent": sent, "ros_ns": ros_ns, "device_s": device_s,
        **{name: truth[name].tolist() for name in truth.dtype.names},
    }))
    assert joint_states.wait_for_all_acked(Duration(seconds=100))
"""
LISTENER = """
import json, sys
import rclpy
from sensor_msgs.msg import JointState

rows = []

def keep(message):
    stamp = message.header.stamp
    rows.append([
        list(message.name), 10**9 * stamp.sec + stamp.nanosec,
        message.position[0], message.velocity[0], message.effort[0],
    ])

with rclpy.init():
    node = rclpy.create_node("listener")
    subscription = node.create_subscription(JointState, "joint_states", keep, 1000)
    while len(rows) < int(sys.argv[1]):
        rclpy.spin_once(node)
print(json.dumps(rows))
"""


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """ROS that stays on this machine, apart from what else there is, with our package beside it."""
    package = Path(torsio.__file__).parents[1]
    return {
        **os.environ,
        "PYTHONPATH": f"{package}{os.pathsep}{EXAMPLE.parent}",
        "PYTHONDONTWRITEBYTECODE": "1",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
        "ROS_HOME": str(tmp_path),
    }


def test_example_runs_by_itself(environment: dict[str, str]) -> None:
    result = subprocess.run(
        [PYTHON, EXAMPLE, "emulated", "0.1", str(RATE_HZ)],
        env=environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert (result.returncode, result.stderr) == (0, "")
    assert " messages on joint_states" in result.stdout


def test_joint_is_where_the_knob_is_at_the_time_of_the_device(environment: dict[str, str]) -> None:
    """Heard by another program; beside it, what the emulated knob knows of itself."""
    with subprocess.Popen(
        [PYTHON, "-c", LISTENER, str(int(RATE_HZ))],
        env=environment, stdout=subprocess.PIPE, text=True,
    ) as listening:  # fmt: skip
        try:
            told = json.loads(
                subprocess.run(
                    [PYTHON, "-c", SENDER, str(RATE_HZ)],
                    env=environment, stdout=subprocess.PIPE, text=True, timeout=120, check=True,
                ).stdout
            )  # fmt: skip
            heard, _ = listening.communicate(timeout=120)
        finally:
            listening.kill()
    names, stamps, positions, speeds, efforts = zip(*json.loads(heard), strict=True)
    assert told["sent"] >= RATE_HZ
    assert set(map(tuple, names)) == {("knob",)}
    # The device's own clock: its ticks, to the nanosecond that a stamp has.
    stamps_ns = np.array(stamps)
    assert np.abs(np.diff(stamps_ns) - 1e9 / RATE_HZ).max() <= 1
    truth_s, truth_rad = np.array(told["time_s"]), np.array(told["angle_rad"])
    # The device's first moment: from the only one where all later positions are the truth.
    after_s = (stamps_ns - stamps_ns[0]) / 1e9
    firsts_s = truth_s[(truth_s >= told["device_s"][0]) & (truth_s + after_s[-1] <= truth_s[-1])]
    errors_rad = [
        np.abs(np.interp(first_s + after_s, truth_s, truth_rad) - positions).max()
        for first_s in firsts_s
    ]
    first_s = firsts_s[np.argmin(errors_rad)]
    least_rad, next_rad = sorted(errors_rad)[:2]
    assert least_rad < COUNT_RAD < next_rad
    # ROS's value at a moment of the device between two known ones.
    offset_ns = stamps_ns[0] - 1e9 * first_s
    assert told["ros_ns"][0] - 1e9 * told["device_s"][1] <= offset_ns
    assert offset_ns <= told["ros_ns"][1] - 1e9 * told["device_s"][0]

    def true(name: str) -> np.ndarray:
        return np.array(np.interp(first_s + after_s, truth_s, told[name]))

    # Estimated and sensed, at some 4 rad/s, and in a wall of 0.15 N m in the end.
    assert speeds == pytest.approx(true("speed_rad_s"), abs=0.3)
    felt_nm = true("spring_torque_nm") + true("motor_torque_nm")
    assert efforts == pytest.approx(felt_nm, abs=5e-3)
    assert np.ptp(efforts) > 0.1
