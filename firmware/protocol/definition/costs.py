"""Instructions of a control tick on each board, as `./dev bench mcu` counts them, and its time.

The first number of a scene's name tells how many effects play. The keys without a number are from the
firmware's binary in the emulated chip: `period_ns`, the time of an interrupt with an empty scene, and the
time that a further instruction takes (docs/results.md, "A tick of the control loop").
"""

from __future__ import annotations

from typing import Final

INSTRUCTIONS: Final[dict[str, dict[str, int]]] = {
    "pico2": {
        "disarmed 0": 167,
        "walls 0": 171,
        "walls 1": 237,
        "walls 2": 277,
        "walls 4": 360,
        "walls 8": 530,
        "walls 16": 861,
        "walls, 16 written 1": 236,
        "walls, telemetry 1": 253,
        "walls, soft start 1": 509,
        "walls, calibrated 1": 318,
        "walls, compensated 1": 239,
        "walls, parallel 1": 237,
        "walls, motor_only 1": 236,
        "straight shaft 1": 315,
        "bent shaft 1": 320,
        "wall 1": 234,
        "spring 1": 249,
        "damper 1": 216,
        "friction 1": 225,
        "inertia 1": 225,
        "constant 1": 256,
        "ramp 1": 261,
        "periodic 1": 288,
        "detents 1": 262,
        "end_stops 1": 235,
        "texture 1": 275,
        "curve 1": 233,
        "impact 1": 444,
        "control law, walls 0": 76,
        "control law, walls 1": 118,
        "control law, walls 2": 149,
        "control law, walls 16": 584,
    },
    "pico": {
        "disarmed 0": 1831,
        "walls 0": 1836,
        "walls 1": 3390,
        "walls 2": 4429,
        "walls 4": 6539,
        "walls 8": 10791,
        "walls 16": 19182,
        "walls, 16 written 1": 3390,
        "walls, telemetry 1": 3429,
        "walls, soft start 1": 4514,
        "walls, calibrated 1": 5682,
        "walls, compensated 1": 3450,
        "walls, parallel 1": 3583,
        "walls, motor_only 1": 3225,
        "straight shaft 1": 5592,
        "bent shaft 1": 5679,
        "wall 1": 3305,
        "spring 1": 3060,
        "damper 1": 2574,
        "friction 1": 2730,
        "inertia 1": 2788,
        "constant 1": 2564,
        "ramp 1": 2798,
        "periodic 1": 4037,
        "detents 1": 3988,
        "end_stops 1": 2742,
        "texture 1": 3905,
        "curve 1": 2677,
        "impact 1": 3893,
        "control law, walls 0": 1665,
        "control law, walls 1": 2157,
        "control law, walls 2": 2626,
        "control law, walls 16": 8952,
    },
}

TIMES_NS: Final[dict[str, dict[str, float]]] = {
    "pico2": {"period": 50_000, "empty": 6_600, "instruction": 12.2},
    "pico": {"period": 100_000, "empty": 31_600, "instruction": 7.6},
}
"""The last is the slope of the table of damped walls: 16 of them on pico2, 6 on pico."""
