"""The first steps of a user with the package. Each installed wheel must do them.

With the word ``plugged`` it does so with the knob that is plugged in: it prints ``armed``, and who
holds that knob then pushes as the emulated hand does. ``tools/wheel_trials.py`` copies this file
beside the installed package, away from the tree.
"""

from __future__ import annotations

import sys

import torsio


def feel_a_wall(knob: torsio.Knob) -> float:
    """Have the hand push the knob into a wall, and return the angle where it came to rest."""
    knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
    knob.arm()
    print("armed", flush=True)
    return float(knob.record(1.5)["angle_rad"].max())


if __name__ == "__main__":
    # Asks hidapi, inside the wheel, for knobs that are plugged in.
    *plugged, emulated = torsio.list_devices()
    if emulated.transport != "emulated":
        sys.exit("the emulated knob is not listed")
    if "plugged" in sys.argv:
        if [device.transport for device in plugged] != ["hid"]:
            sys.exit(f"one knob is plugged in, and listed are {plugged}")
        knob = torsio.open()
    else:
        hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (1.0, 0.05)])
        knob = torsio.open("emulated", emulator=torsio.EmulatorOptions(hand=hand))
    with knob:
        furthest_rad = feel_a_wall(knob)
    if not 0.125 < furthest_rad < 0.135:
        sys.exit(f"the knob was pushed to {furthest_rad:.3f} rad; 50 mN m should get it to 0.130")
    print(f"torsio {torsio.__version__}: pushed the knob to {furthest_rad:.3f} rad, into a wall")
