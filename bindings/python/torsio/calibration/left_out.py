"""Uncertainties that no fit knows: gaps of its models, and other drives."""

from __future__ import annotations

import math
from dataclasses import replace

from torsio.calibration.quantity import Quantity

__all__ = [
    "LEFT_OUT",
    "LEFT_OUT_BY_DRIVE",
    "LEFT_OUT_BY_SIMPLE_LOOP",
    "STATED_TOO_WIDE",
    "by_brake",
    "by_tick",
    "honest",
    "widened",
    "with_left_out",
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
    "rise_s": (2.5e-3, 0.0),
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
_TICK_S = 1e-4
_BY_TICK = {
    "coulomb_nm": (2.2e-4, 0.0),
    "viscous_nm_s_per_rad": (1.3e-3, 0.0),
    "stiffness_nm_per_rad": (1e-3, 0.0),
    "shaft_damping_nm_s_per_rad": (0.33, 0.0),
}


def honest(quantity: Quantity) -> Quantity:
    """Correct a fit's uncertainty for the effects that its model leaves out."""
    narrow = STATED_TOO_WIDE.get(quantity.name, 1.0)
    sigma = narrow * quantity.standard_uncertainty
    return with_left_out(replace(quantity, standard_uncertainty=sigma), LEFT_OUT)


def with_left_out(
    quantity: Quantity, left_out: dict[str, tuple[float, float]], times: float = 1.0
) -> Quantity:
    """Add to the uncertainty what a model leaves out, so many times."""
    share, least = left_out.get(quantity.name, (0.0, 0.0))
    return quantity.wider(times * math.hypot(share * quantity.value, least))


def by_tick(quantity: Quantity, tick_s: float) -> Quantity:
    """Add to the uncertainty what a tick longer than others leaves out."""
    return with_left_out(quantity, _BY_TICK, max(tick_s - _TICK_S, 0.0) / 1e-3)


def by_brake(found: dict[str, Quantity], top_nm: float, speed_rad_s: float) -> dict[str, Quantity]:
    """Add what a fast brake and a wide loop leave out of stairs up to a torque.

    A brake whose torque rises faster than the turning knob winds the shaft stops for a moment. And
    a loop that takes most of the stairs leaves little of them. Found on the numbers 300 to 315.
    """
    stiffness = found["stiffness_nm_per_rad"].value
    inertia = max(found["brake_inertia_kg_m2"].value, 0.0)
    winds_s = math.hypot(top_nm / (stiffness * speed_rad_s), math.sqrt(inertia / stiffness))
    added = {}
    share = 0.0
    for name in ("rise_s", "release_s"):
        fast = math.exp(-((found[name].value / (3.5 * winds_s)) ** 2))
        added[name] = fast * winds_s / 4.0
        share = max(share, 0.4 * fast * winds_s)
    loop_nm = found["hysteresis_nm"].value
    added["hysteresis_nm"] = 0.25 * share * top_nm
    added["brake_gain"] = share + 0.25 * (loop_nm / top_nm) ** 4
    added["brake_drag_nm"] = 0.5 * share * top_nm + loop_nm * added["brake_gain"]
    return found | {name: found[name].wider(sigma) for name, sigma in added.items()}


def widened(found: dict[str, Quantity], other: dict[str, Quantity]) -> dict[str, Quantity]:
    """Add the difference between both cases to the uncertainty of each value.

    A missing quantity counts as zero, so it is uncertain by all of itself.
    """
    values = {name: of.value for name, of in other.items()}
    return {name: of.wider(values.get(name, 0.0) - of.value) for name, of in found.items()}
