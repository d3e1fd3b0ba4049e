"""Gaps of the models, as measured; `doubts` adds them to the uncertainties."""

from __future__ import annotations

__all__ = [
    "LEFT_OUT",
    "LEFT_OUT_BY_DRIVE",
    "LEFT_OUT_BY_SIMPLE_LOOP",
    "LEFT_OUT_BY_TICK",
    "STATED_TOO_WIDE",
    "TICK_S",
]

# All of these were found on emulated knobs that `torsio study calibration` does not use: the
# numbers 0 to 130, and with a drive 200 to 259, with a pico2's loop and with a pico's.

# Share of a fit's stated uncertainty that remains. The fit takes equal errors of all steps up, and
# of all steps down, for chance. They cancel in the difference.
STATED_TOO_WIDE = {"hysteresis_nm": 0.6, "rise_s": 0.55, "knob_coulomb_nm": 0.8}

# Gaps of the models, as a share and at least.
LEFT_OUT = {
    "inertia_kg_m2": (5e-4, 0.0),
    "viscous_nm_s_per_rad": (2e-4, 0.0),
    "offset_nm": (0.0, 5e-7),
    "cogging_nm": (4e-3, 0.0),
    "stiffness_nm_per_rad": (8e-4, 0.0),
    "backlash_rad": (0.0, 1.5e-5),
    "knee_rad": (4e-3, 0.0),
    "stiffness_factor": (7e-3, 0.0),
    "knob_coulomb_nm": (1e-3, 0.0),
    "knob_inertia_kg_m2": (7e-3, 0.0),
    "shaft_damping_nm_s_per_rad": (0.15, 1e-5),
    "brake_gain": (7e-5, 0.0),
    "brake_curve": (8e-4, 0.0),
    "hysteresis_nm": (5e-4, 1e-5),
    "rise_s": (0.0, 5e-5),
    "release_s": (0.0, 6e-5),
}
# The same of a drive, on top.
LEFT_OUT_BY_DRIVE = {
    "inertia_kg_m2": (5e-4, 0.0),
    "viscous_nm_s_per_rad": (1e-2, 2e-6),
    "offset_nm": (0.0, 1.0e-5),
    "cogging_nm": (4e-2, 0.0),
    "brake_gain": (3.0e-3, 0.0),
    "brake_curve": (4.4e-3, 2e-4),
    "hysteresis_nm": (4e-3, 1.3e-5),
    "rise_s": (3e-3, 0.0),  # too small by as much: the coil gets warm, and the supply sags
    "release_s": (2.5e-3, 0.0),
}
# And of the simple loop, on top of both.
LEFT_OUT_BY_SIMPLE_LOOP = {
    "offset_nm": (0.0, 1.0e-5),
    "brake_gain": (2e-3, 0.0),
}
# All of the above holds for ticks of 0.1 ms and less. Each millisecond of the tick adds so much:
# the moment of a torque is known to a fiftieth of a tick. The shaft's damping feels it most. Found
# on the numbers 0 to 119.
TICK_S = 1e-4
LEFT_OUT_BY_TICK = {
    "coulomb_nm": (2.2e-4, 0.0),
    "viscous_nm_s_per_rad": (1.3e-3, 0.0),
    "stiffness_nm_per_rad": (1e-3, 0.0),
    "shaft_damping_nm_s_per_rad": (0.33, 0.0),
}
