"""Feel a wall: play it, and record what the knob does while a hand pushes against it."""

from __future__ import annotations

import sys

import torsio


def main(device: str = "emulated") -> None:
    """Play a wall for a second and print how hard it was pressed."""
    with torsio.open(device) as knob:
        knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
        knob.arm()
        if knob.is_emulated:  # a real one is pushed by you
            knob.emulator.set_hand(torsio.TorqueHand(torque_nm=[(0.0, 0.0), (0.8, 0.05)]))
        log = knob.record(1.0)
    felt_nm = log["spring_torque_nm"] + log["motor_command_nm"]
    print(f"turned by {log['angle_rad'].max():.3f} rad,", end=" ")
    print(f"the wall pushed back with {1e3 * -felt_nm.min():.0f} mN m")


if __name__ == "__main__":
    main(*sys.argv[1:])
