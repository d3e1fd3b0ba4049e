"""The steps of a calibration: what each plays, what it adds to the findings, what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from torsio.calibration.brake import estimate_brake, hold_and_let_go, slip
from torsio.calibration.circuit import ELECTRIC_STEPS, CircuitSteps
from torsio.calibration.found import Findings, Runs, flexible_s2, knob_inertia_kg_m2
from torsio.calibration.free import SLOW_S, estimate_free, spin, through_shaft
from torsio.calibration.play import Player
from torsio.calibration.quantity import Refusal
from torsio.calibration.shaft import estimate_shaft, hold_and_push
from torsio.calibration.signs import find_signs
from torsio.printed.config import ActuatorConfig

__all__ = ["STEPS", "Plan", "Step", "steps_of"]

STEPS = ("signs", "friction and inertia", "shaft", "brake")
"""In their order, as `progress` names them."""

# Largest factor between a device and its configuration; beyond it is a fault.
_PLAUSIBLE = 5.0
# Share of a wave of the cogging beyond which the slow turns do not tell its size.
_SEEN_THROUGH_SHAFT = 0.6
_LEAST_WAVE_NM = 2e-4  # smaller ones may be noise, and widen the intervals alone


@dataclass(frozen=True)
class Step:
    """One step.

    Attributes
    ----------
    name
        As `progress` hears it; empty for one that belongs to the step before.
    play
        Moves the knob, by what is found, and gives the runs.
    estimate
        Adds to the findings what the runs tell.
    check
        Refuses what cannot be.
    finds
        What it estimates from runs alone; a later step takes the place of an earlier one.
    """

    name: str
    play: Callable[[Player, Findings], Runs]
    estimate: Callable[[Runs, Findings], Findings] = lambda _, found: found
    check: Callable[[Findings], object] = lambda _: None
    finds: str = ""


@dataclass(frozen=True)
class Plan:
    """How much the steps ask for, and how each plays and estimates."""

    actuator: ActuatorConfig
    motor_nm: float
    brake_nm: float
    demagnetised: bool
    drift: bool

    @property
    def slow_s(self) -> float:
        """Duration of the slow turns."""
        return 0.8 if self.drift else SLOW_S

    def signs(self, player: Player, _: Findings) -> Runs:
        """All steps shall find the brake as it is left, whether it was used before or not."""
        hold_and_let_go(player, self.brake_nm, STEPS[0])
        find_signs(player, self.motor_nm, self.actuator.knob_inertia_kg_m2)
        return ()

    def spin(self, player: Player, _: Findings) -> Runs:
        """Turn the free knob."""
        return (spin(player, self.motor_nm, slow_s=self.slow_s),)

    def free(self, runs: Runs, found: Findings) -> Findings:
        """Estimate friction and inertia."""
        free = estimate_free(runs[0], slow_s=self.slow_s)
        return {**found, "turns": runs[0], "free": free}

    def check_inertia(self, found: Findings) -> None:
        """Refuse an inertia far from the configured one."""
        inertia, knob_alone = found["free"].inertia.value, self.actuator.knob_inertia_kg_m2
        if not knob_alone / _PLAUSIBLE < inertia < 2.0 * _PLAUSIBLE * knob_alone:
            raise Refusal(
                STEPS[1], "inertia", f"all that turns has {inertia:.2e} kg m^2, but "
                f"knob_inertia_kg_m2 is {knob_alone:.2e}: the motor's torque constant or the "
                "encoder's counts are wrong, or something heavy is on the knob. Otherwise correct "
                "the configuration",
            )  # fmt: skip

    def _most(self, found: Findings) -> dict[str, Any]:
        coulomb_nm = found["free"].coulomb.value
        return {"motor_nm": self.motor_nm, "brake_nm": self.brake_nm, "coulomb_nm": coulomb_nm}

    def push(self, player: Player, found: Findings) -> Runs:
        """Push against the held brake."""
        return hold_and_push(player, **self._most(found), drift=self.drift)

    def shaft(self, runs: Runs, found: Findings) -> Findings:
        """Estimate the shaft, then the cogging through it, and the shaft with that cogging."""
        free, (pulls, steps) = found["free"], runs
        shaft = estimate_shaft(pulls, steps, free.cogging.torque_nm, free.inertia.value)
        if free.cogging.periods_per_rev:
            first: Findings = {**found, "shaft": shaft}
            knob_kg_m2 = knob_inertia_kg_m2(first)
            free = through_shaft(free, found["turns"], flexible_s2(first), knob_kg_m2)
            shaft = estimate_shaft(pulls, steps, free.cogging.torque_nm, free.inertia.value)
        return {**found, "free": free, "shaft": shaft}

    def check_cogging(self, found: Findings) -> None:
        """Refuse waves that the turns did not tell."""
        free, shaft = found["free"], found["shaft"]
        if self.drift:
            return
        if free.amplitude.value > _LEAST_WAVE_NM and free.through_shaft > _SEEN_THROUGH_SHAFT:
            raise Refusal(
                STEPS[2], "unexplained", "the turns do not tell how large the motor's cogging is: "
                "it cogs so often in a turn that the brake's side swings with it",
            )  # fmt: skip
        if shaft.shape_nm > _LEAST_WAVE_NM:
            raise Refusal(
                STEPS[2], "unexplained", f"the slow pulls leave {1e3 * shaft.shape_nm:.1f} mN m "
                "that a shaft with one bend does not explain: it softens early, the brake's loop "
                "is wide, the motor cogs often, or something rubs or slips",
                residual_nm=shaft.shape_nm,
            )  # fmt: skip

    def slip(self, player: Player, found: Findings) -> Runs:
        """Relax the shaft, and turn the knob through the brake."""
        hold_and_let_go(player, self.brake_nm)
        return (slip(player, **self._most(found)),)

    def brake(self, runs: Runs, found: Findings) -> Findings:
        """Estimate the brake."""
        brake = estimate_brake(
            runs[0], found["free"], flexible_s2(found), demagnetised=self.demagnetised
        )
        return {**found, "brake": brake}


def steps_of(plan: Plan, electric: CircuitSteps | None) -> list[Step]:
    """Give the steps in their order; the electrical ones lie between the others."""
    signs = Step(STEPS[0], plan.signs)
    turn = Step(STEPS[1], plan.spin, plan.free, plan.check_inertia, finds="free")
    push = Step(STEPS[2], plan.push, plan.shaft, plan.check_cogging, finds="shaft")
    if plan.drift:
        return [signs, turn, push]
    rest = [push, Step(STEPS[3], plan.slip, plan.brake, finds="brake")]
    if electric is None:
        return [signs, turn, *rest]
    sensor, turning, holding = ELECTRIC_STEPS
    return [
        *(Step(sensor, electric.look), signs, Step(turning, electric.turn)),
        Step(turn.name, turn.play, turn.estimate),  # in torques that may be wrong
        Step(holding, electric.hold, electric.circuit),
        replace(turn, name="", play=electric.turns),
        *rest,
    ]
