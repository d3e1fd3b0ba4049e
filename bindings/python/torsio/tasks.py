"""Tasks on many emulated knobs at once, for learning; `torsio.gym` makes them Gymnasium's.

A task draws its knobs at random within ranges, says what a learner may see and do, and rewards it.
All arrays have a row for each knob.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from torsio.batch import MOST_AT_ONCE, Actions, Knobs
from torsio.closed_loop import InitialState, LoopOptions
from torsio.common import checks
from torsio.errors import InvalidArgument
from torsio.printed.config import ControlConfig, Law
from torsio.printed.hands import ImpedanceHand, TorqueHand
from torsio.printed.plant import PlantParams
from torsio.printed.scenes import Curve, Wall
from torsio.telemetry import Record

__all__ = ["FindDetent", "Floats", "IdentifyShaft", "Law", "Ranges", "RenderWall", "Task"]

Floats = npt.NDArray[np.float64]
Ranges = Mapping[str, tuple[float, float]]

_NUMBERS = tuple(
    field.name for field in fields(PlantParams) if type(field.default) is float
)  # what can be drawn


def _range(name: str, bounds: Any) -> tuple[float, float]:
    ends = checks.numbers(name, bounds)
    if len(ends) != 2:
        raise InvalidArgument(f"{name} must be a range (lowest, highest), has {len(ends)} numbers")
    low, high = (checks.finite(name, end) for end in ends)
    if low > high:
        raise InvalidArgument(f"{name} is from {low:g} to {high:g}, upside down")
    return low, high


class Task(ABC):
    """A task for a learner.

    Parameters
    ----------
    plant
        Ranges of fields of `PlantParams`, each drawn evenly for every knob. The controller keeps
        believing in the reference actuator.
    kinds
        Number of different knobs. Beyond that, knobs repeat with other encoder noise. It bounds the
        memory.
    """

    actions: ClassVar[Actions]
    observation_names: ClassVar[tuple[str, ...]]
    action_names: ClassVar[tuple[str, ...]]
    ticks_per_step: ClassVar[int] = 1
    """Ticks of 1 ms."""
    steps: ClassVar[int]
    """Steps of an episode."""
    drawn: ClassVar[tuple[str, ...]] = ()
    """Fields of `PlantParams` that the task itself draws."""

    def __init__(self, *, plant: Ranges | None = None, kinds: int = 64) -> None:
        """Look at the ranges."""
        self.plant: dict[str, tuple[float, float]] = checks.table("plant", plant or {})
        self.kinds: int = checks.whole("kinds", kinds, 1, 1_000_000)
        for name, bounds in self.plant.items():
            if name not in _NUMBERS:
                raise InvalidArgument(
                    f"no number of PlantParams is called {name!r}; there are " + ", ".join(_NUMBERS)
                )
            if name in self.drawn:
                raise InvalidArgument(f"plant[{name!r}]: this task draws that itself")
            self.plant[name] = _range(f"plant[{name!r}]", bounds)

    def knobs(
        self,
        n: int,
        rng: np.random.Generator,
        *,
        law: Law | None = None,
        threads: int | None = None,
    ) -> Knobs:
        """Draw knobs for the task; it keeps what they are, so it has these and no others now.

        Parameters
        ----------
        law
            Controls in the place of a learner, which then has no actions.
        """
        checks.kind("rng", rng, np.random.Generator, "as numpy.random.default_rng(1) gives it")
        count = min(checks.whole("n", n, 1, MOST_AT_ONCE), self.kinds)
        drawn = [self._draw_kind(rng) for _ in range(count)]
        self.kind_of: npt.NDArray[np.int_] = np.arange(n) % count
        self._keep(drawn)
        loops = [loop for loop, _ in drawn]
        if law is not None:
            loops = [replace(loop, control=ControlConfig(law=law)) for loop in loops]
        return Knobs(
            n,
            [loops[kind] for kind in self.kind_of],
            actions=self.actions if law is None else "none",
            seeds=int(rng.integers(2**63)),
            threads=threads,
        )

    def _draw_kind(self, rng: np.random.Generator) -> tuple[LoopOptions, dict[str, float]]:
        values: dict[str, Any] = {
            name: float(rng.uniform(low, high)) for name, (low, high) in self.plant.items()
        }
        plant = PlantParams(**values)
        loop = LoopOptions(plant=plant, actuator=PlantParams().matching_config())
        return self.draw(loop, rng)

    def _keep(self, drawn: list[tuple[LoopOptions, dict[str, float]]]) -> None:
        self.hidden: dict[str, Floats] = {
            name: np.array([hidden[name] for _, hidden in drawn])[self.kind_of]
            for name in drawn[0][1]
        }

    @abstractmethod
    def draw(
        self, loop: LoopOptions, rng: np.random.Generator
    ) -> tuple[LoopOptions, dict[str, float]]:
        """Make of a knob one of this task; and what the learner does not see, by name."""

    @abstractmethod
    def act(self, actions: Floats, knobs: Knobs) -> None:
        """Translate a learner's actions, -1 to 1, shape (n, len(action_names))."""

    @abstractmethod
    def observe(self, states: Record) -> Floats:
        """Give what the learner sees, shape (n, len(observation_names)), about -1 to 1."""

    @abstractmethod
    def reward(self, states: Record, actions: Floats) -> Floats:
        """Give what the last step was worth, shape (n,)."""


class RenderWall(Task):
    """Be the controller: share a wall's torque between motor and brake, as the laws do.

    A hand presses the knob into a virtual wall and out again. The learner sees what the device
    senses and commands motor and brake. The reward is 0 for what feels like the wall, and falls
    with the square of the difference.

    Parameters
    ----------
    stiffness_nm_per_rad
        Range of the walls.
    """

    actions: ClassVar[Actions] = "commands"
    observation_names: ClassVar[tuple[str, ...]] = (
        "wanted",
        "spring",
        "brake capacity",
        "speed",
        "motor",
        "brake",
    )
    action_names: ClassVar[tuple[str, ...]] = ("motor", "brake")
    steps: ClassVar[int] = 500

    WALL_RAD: ClassVar[float] = 0.05
    MOTOR_NM: ClassVar[float] = PlantParams().motor_limit_nm
    BRAKE_NM: ClassVar[float] = PlantParams().brake_limit_nm

    def __init__(
        self,
        *,
        stiffness_nm_per_rad: tuple[float, float] = (0.6, 3.0),
        plant: Ranges | None = None,
        kinds: int = 64,
    ) -> None:
        """Look at the ranges."""
        super().__init__(plant=plant, kinds=kinds)
        self._stiffness = _range("stiffness_nm_per_rad", stiffness_nm_per_rad)
        checks.positive("stiffness_nm_per_rad", self._stiffness[0])

    def draw(
        self, loop: LoopOptions, rng: np.random.Generator
    ) -> tuple[LoopOptions, dict[str, float]]:
        """Draw a wall, and how deep it is pressed."""
        stiffness = float(rng.uniform(*self._stiffness))
        peak_nm = float(rng.uniform(0.04, 0.08))
        deep_rad = self.WALL_RAD + peak_nm / stiffness + peak_nm / 0.8
        hand = ImpedanceHand(
            stiffness_nm_per_rad=0.8,
            damping_nm_s_per_rad=4e-3,
            inertia_kg_m2=1e-4,
            intended_angle_rad=[(0.0, 0.0), (0.2, deep_rad), (0.3, deep_rad), (0.5, 0.0)],
        )
        wall = Wall(angle_rad=self.WALL_RAD, stiffness_nm_per_rad=stiffness)
        return replace(loop, hand=hand, scene=wall), {"stiffness": stiffness}

    def law(self, n: int, rng: np.random.Generator, law: Law = "paper") -> Floats:
        """Give what a law of the device earns in an episode, shape (n,), with knobs drawn anew."""
        knobs = self.knobs(n, rng, law=law)
        total = np.zeros(n)
        nothing = np.zeros((n, len(self.action_names)))
        for _ in range(self.steps):
            knobs.step(self.ticks_per_step)
            total += self.reward(knobs.states, nothing)
        return total

    def act(self, actions: Floats, knobs: Knobs) -> None:
        """Command motor and brake; a negative brake is a free one."""
        knobs.actions["motor_command_nm"] = self.MOTOR_NM * actions[:, 0]
        knobs.actions["brake_command_nm"] = self.BRAKE_NM * np.maximum(actions[:, 1], 0.0)

    def observe(self, states: Record) -> Floats:
        """Give what the device senses, and what it commanded last."""
        angle_rad = states["position_counts"] * (2 * np.pi / PlantParams().counts_per_rev)
        return np.column_stack(
            [
                self._wanted_nm(angle_rad) / self.MOTOR_NM,
                states["sensed_spring_torque_nm"] / self.MOTOR_NM,
                states["sensed_brake_capacity_nm"] / self.BRAKE_NM,
                states["estimated_speed_rad_s"] / 5.0,
                states["motor_command_nm"] / self.MOTOR_NM,
                states["brake_command_nm"] / self.BRAKE_NM,
            ]
        ).astype(float)

    def reward(self, states: Record, actions: Floats) -> Floats:
        """Compare what is felt with the wall, in units of 5 mN m."""
        felt_nm = states["spring_torque_nm"] + states["motor_torque_nm"]
        error = (felt_nm - self._wanted_nm(states["angle_rad"])) / 5e-3
        worth: Floats = -(error**2) / self.steps
        return worth

    def _wanted_nm(self, angle_rad: Floats) -> Floats:
        wanted: Floats = -self.hidden["stiffness"] * np.maximum(angle_rad - self.WALL_RAD, 0.0)
        return wanted


class FindDetent(Task):
    """Be the hand: find the only notch, somewhere to the right, by feel, and stay in it.

    The learner pushes the knob and sees how far it has turned it, how fast, and what it feels.
    """

    actions: ClassVar[Actions] = "hand"
    observation_names: ClassVar[tuple[str, ...]] = ("turned", "speed", "felt", "pushed")
    action_names: ClassVar[tuple[str, ...]] = ("push",)
    ticks_per_step: ClassVar[int] = 5
    steps: ClassVar[int] = 300

    PUSH_NM: ClassVar[float] = 0.05
    WIDTH_RAD: ClassVar[float] = 0.06
    """Half of the notch."""

    def draw(
        self, loop: LoopOptions, rng: np.random.Generator
    ) -> tuple[LoopOptions, dict[str, float]]:
        """Draw where the notch is."""
        middle_rad = float(rng.uniform(0.15, 0.75))
        shape = 0.035 * np.sin(np.linspace(np.pi, -np.pi, 33))
        shape[[0, -1]] = 0.0
        notch = Curve(
            torque_nm=shape,
            angle_rad=middle_rad - self.WIDTH_RAD,
            span_rad=2 * self.WIDTH_RAD,
        )
        hand = TorqueHand(torque_nm=0.0)
        return replace(loop, hand=hand, scene=notch), {"middle_rad": middle_rad}

    def act(self, actions: Floats, knobs: Knobs) -> None:
        """Push."""
        knobs.actions["hand_torque_nm"] = self.PUSH_NM * actions[:, 0]

    def observe(self, states: Record) -> Floats:
        """Give what a hand knows of itself."""
        felt_nm = states["spring_torque_nm"] + states["motor_torque_nm"]
        return np.column_stack(
            [
                states["angle_rad"],
                states["speed_rad_s"] / 10.0,
                felt_nm / self.PUSH_NM,
                states["hand_torque_nm"] / self.PUSH_NM,
            ]
        )

    def reward(self, states: Record, actions: Floats) -> Floats:
        """Reward being within half the notch, and slow; charge the way to it."""
        off_rad = np.abs(states["angle_rad"] - self.hidden["middle_rad"])
        there = (off_rad < 0.5 * self.WIDTH_RAD) & (np.abs(states["speed_rad_s"]) < 1.0)
        worth: Floats = (there - np.minimum(off_rad, 1.0)) / self.steps
        return worth


class IdentifyShaft(Task):
    """Be the hand: push against the held brake and say how stiff the shaft is.

    The learner's second action is its guess, from half (-1) to twice (1) the reference's stiffness.
    """

    actions: ClassVar[Actions] = "hand and commands"
    observation_names: ClassVar[tuple[str, ...]] = ("turned", "speed", "pushed")
    action_names: ClassVar[tuple[str, ...]] = ("push", "guess")
    drawn: ClassVar[tuple[str, ...]] = ("shaft_stiffness_nm_per_rad",)
    ticks_per_step: ClassVar[int] = 5
    steps: ClassVar[int] = 60

    PUSH_NM: ClassVar[float] = 0.08
    BRAKE_NM: ClassVar[float] = PlantParams().brake_limit_nm

    def draw(
        self, loop: LoopOptions, rng: np.random.Generator
    ) -> tuple[LoopOptions, dict[str, float]]:
        """Draw a stiffness; the brake holds all it can, and the motor does nothing."""
        octave = float(rng.uniform(-1.0, 1.0))
        stiffness = PlantParams().shaft_stiffness_nm_per_rad * 2.0**octave
        loop = replace(
            loop,
            plant=replace(loop.plant, shaft_stiffness_nm_per_rad=stiffness),
            hand=TorqueHand(torque_nm=0.0),
            initial=InitialState(brake_magnetic_nm=self.BRAKE_NM),
        )
        return loop, {"octave": octave}

    def act(self, actions: Floats, knobs: Knobs) -> None:
        """Push; the brake holds."""
        knobs.actions["hand_torque_nm"] = self.PUSH_NM * actions[:, 0]
        knobs.actions["brake_command_nm"] = self.BRAKE_NM

    def observe(self, states: Record) -> Floats:
        """Give what a hand knows of itself."""
        return np.column_stack(
            [
                states["angle_rad"] / 0.05,
                states["speed_rad_s"] / 5.0,
                states["hand_torque_nm"] / self.PUSH_NM,
            ]
        )

    def reward(self, states: Record, actions: Floats) -> Floats:
        """Compare the guess with the truth."""
        worth: Floats = -((actions[:, 1] - self.hidden["octave"]) ** 2) / self.steps
        return worth
