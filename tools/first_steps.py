"""What a user does first with the package: each wheel must do it, where it is installed.

``tools/wheel_trials.py`` copies this file beside the installed package, away from the tree.
"""

from __future__ import annotations

import sys

import torsio

if __name__ == "__main__":
    hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (1.0, 0.05)])
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(hand=hand)) as knob:
        knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
        knob.arm()
        log = knob.record(1.5)
    furthest_rad = log["angle_rad"].max()
    if not 0.125 < furthest_rad < 0.135:
        sys.exit(f"the knob was pushed to {furthest_rad:.3f} rad; 50 mN m should get it to 0.130")
    # Asks hidapi, inside the wheel, for knobs that are plugged in.
    if torsio.list_devices()[-1].transport != "emulated":
        sys.exit("the emulated knob is not listed")
    print(f"torsio {torsio.__version__}: pushed the knob to {furthest_rad:.3f} rad, into a wall")
