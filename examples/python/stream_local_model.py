"""Render something of your own: stream local models from a loop in Python.

A hundred times a second the host computes the knob's surroundings: a torque, a spring and a damper.
The device renders that at its own rate, so that it stays firm and calm although the host is slow.
Here the surroundings are a ball in a bowl that swings.
"""

from __future__ import annotations

import math
import sys

import numpy as np

import torsio

PERIOD_S = 0.01


def main(device: str = "emulated") -> None:
    """Let a swinging spring carry the knob along and print how well it follows."""
    with torsio.open(device) as knob:
        knob.start_telemetry()
        knob.arm()
        begin_s = knob.clock().time_s
        logs = []
        for step in range(300):
            middle_rad = 0.5 * math.sin(2 * math.pi * 0.5 * step * PERIOD_S)
            knob.stream_local_model(
                angle_rad=middle_rad,
                stiffness_nm_per_rad=0.2,
                damping_nm_s_per_rad=2e-3,
                deadline_s=0.1,
            )
            knob.sleep(PERIOD_S)
            logs.append(knob.read(timeout_s=0.0))
        knob.stream_local_model(deadline_s=0.0)  # the end of the stream, in good order
        refused = knob.statistics().local_models_refused
    log = np.concatenate(logs)
    middle = 0.5 * np.sin(2 * math.pi * 0.5 * (log["time_s"] - begin_s))
    behind = np.sqrt(np.mean(np.square(log["angle_rad"] - middle)))
    print(f"{len(log)} samples, {refused} models refused,", end=" ")
    print(f"the knob follows to within {behind:.3f} rad RMS")


if __name__ == "__main__":
    main(*sys.argv[1:])
