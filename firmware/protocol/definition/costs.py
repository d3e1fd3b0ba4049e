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
        "stiff wall, calibrated 1": 456,
        "straight shaft 1": 315,
        "bent shaft 1": 320,
        "wall 1": 234,
        "spring 1": 249,
        "damper 1": 219,
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
        "disarmed 0": 1462,
        "walls 0": 1468,
        "walls 1": 2473,
        "walls 2": 3151,
        "walls 4": 4539,
        "walls 8": 7354,
        "walls 16": 12876,
        "walls, 16 written 1": 2473,
        "walls, telemetry 1": 2493,
        "walls, soft start 1": 3538,
        "walls, calibrated 1": 4318,
        "walls, compensated 1": 2524,
        "walls, parallel 1": 2599,
        "walls, motor_only 1": 2370,
        "stiff wall, calibrated 1": 6367,
        "straight shaft 1": 4297,
        "bent shaft 1": 4401,
        "wall 1": 2407,
        "spring 1": 2375,
        "damper 1": 2014,
        "friction 1": 2111,
        "inertia 1": 2113,
        "constant 1": 1950,
        "ramp 1": 2122,
        "periodic 1": 2928,
        "detents 1": 2879,
        "end_stops 1": 2128,
        "texture 1": 2929,
        "curve 1": 2194,
        "impact 1": 3021,
        "control law, walls 0": 1305,
        "control law, walls 1": 1644,
        "control law, walls 2": 1961,
        "control law, walls 16": 6622,
    },
}

TIMES_NS: Final[dict[str, dict[str, float]]] = {
    "pico2": {"period": 50_000, "empty": 6_600, "instruction": 12.2},
    "pico": {"period": 100_000, "empty": 31_100, "instruction": 7.4},
}
"""The last is the slope of the table of damped walls: 16 of them on pico2, 6 on pico."""
