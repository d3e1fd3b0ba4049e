"""A selector switch: twelve notches a turn between two end stops, and a tick of roughness."""

from __future__ import annotations

import math
import sys

import numpy as np

import torsio

NOTCHES = 12


def main(device: str = "emulated") -> None:
    """Turn slowly through the notches and print where the knob likes to be."""
    pitch_rad = 2 * math.pi / NOTCHES
    scene = [
        torsio.Detents(per_turn=NOTCHES, torque_nm=0.03, profile="click", width=0.4),
        torsio.EndStops(
            lower_rad=-0.25 * pitch_rad, upper_rad=5.25 * pitch_rad, stiffness_nm_per_rad=1.0
        ),
        torsio.Texture(grains_per_turn=600, torque_nm=0.002),
    ]
    hand = torsio.ImpedanceHand(
        intended_angle_rad=[(0.0, 0.0), (3.0, 5.0 * pitch_rad)],
        stiffness_nm_per_rad=0.15,
        damping_nm_s_per_rad=2e-3,
        inertia_kg_m2=1e-4,
    )
    with torsio.open(device) as knob:
        knob.play(scene)
        knob.arm()
        if knob.is_emulated:  # a real one is turned by you
            knob.emulator.set_hand(hand)
        log = knob.record(3.2)

    # A soft hand dwells in the notches and jumps from one to the next.
    notch = np.round(log["angle_rad"] / pitch_rad).astype(int)
    sample_s = np.diff(log["time_s"]).min()
    near = np.abs(log["angle_rad"] - notch * pitch_rad) < 0.25 * pitch_rad
    for index in range(notch.min(), notch.max() + 1):
        share = np.mean(near[notch == index])
        stay_ms = 1e3 * sample_s * np.sum(notch == index)
        print(f"notch {index}: {stay_ms:.0f} ms, {100 * share:.0f} % of it in the notch")


if __name__ == "__main__":
    main(*sys.argv[1:])
