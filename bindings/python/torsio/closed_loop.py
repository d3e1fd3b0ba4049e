"""The device's controller in closed loop with the plant, for studies of many runs.

The device's control code runs against the plant, encoder and hand of the emulated device. There is
no protocol, no USB frame, no arming and no watchdog. One run of two seconds takes about a
millisecond.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from torsio import _torsio
from torsio.common import checks
from torsio.errors import InvalidArgument
from torsio.printed.beginnings import InitialState, SpinUp
from torsio.printed.config import (
    CONFIGS,
    EMULATED_CONTROL_PERIOD_NS,
    ActuatorConfig,
    BoardConfig,
    ControlConfig,
    ShaftConfig,
)
from torsio.printed.hands import Hand, NoHand
from torsio.printed.plant import PlantParams
from torsio.printed.scenes import MAX_TORQUE_NM, Scene
from torsio.telemetry import LOOP_DTYPE, Record

__all__ = [
    "LOOP_DTYPE",
    "REPLAY_DTYPE",
    "ClosedLoop",
    "InitialState",
    "LoopOptions",
    "SpinUp",
    "replay",
    "reports",
    "simulate",
    "simulate_many",
]

_MOST_ROWS: Final = 50_000_000

REPLAY_DTYPE = _torsio.emulator.REPLAY_DTYPE
"""The controller's decisions from a count: ``position_counts``, ``speed_rad_s``,
``desired_torque_nm``, ``motor_command_nm``, ``brake_command_nm``, ``spring_torque_nm``
(sensed), ``numeric_error``.
"""


@dataclass(frozen=True, repr=False)
class LoopOptions(checks.ByName):
    """Everything that a run depends on.

    Attributes
    ----------
    scene
        One effect or several, which play from the first tick on; None is free space.
    actuator, shaft
        The device's beliefs about actuator and shaft; None means as `plant` truly is.
    board
        The board's beliefs about a plant's electrics; None means as they truly are.
    control_period_ns
        1,000 to 1e9.
    delay_ticks
        The commands act so many control periods late.
    first_tick
        Start of the controller's own count of ticks; the effects began at 0.
    seed
        Seed of the noise of encoder and current sensor.
    step_ns, stepper
        As in `torsio.emulator.Plant`; a step is at most a control period long,
        and at most 1 ms if `step_ns` is None.
    """

    _: KW_ONLY
    scene: Scene | None = None
    hand: Hand = field(default_factory=NoHand)
    plant: PlantParams = field(default_factory=PlantParams)
    actuator: ActuatorConfig | None = None
    shaft: ShaftConfig | None = None
    control: ControlConfig = field(default_factory=ControlConfig)
    board: BoardConfig | None = None
    control_period_ns: int = EMULATED_CONTROL_PERIOD_NS
    delay_ticks: int = 0
    first_tick: int = 0
    spin_up: SpinUp | None = None
    initial: InitialState | None = None
    seed: int = 0
    step_ns: int | None = None
    stepper: object | None = None


class ClosedLoop:
    """A closed loop that can be run on and interfered with.

    Raises
    ------
    ValueError
        If an option is out of its range; the message names it.
    RuntimeError
        If the spin-up does not reach its speed.
    """

    def __init__(self, options: LoopOptions) -> None:
        """Set it up, and do the spin-up if there is one."""
        checked_options(options)
        self.options = options
        self._loop = _torsio.emulator.ClosedLoop(options)

    def run(self, *, duration_s: float, record_every: int = 1) -> Record:
        """Go on; give LOOP_DTYPE rows of every ``record_every``-th tick, shape (n,).

        Raises
        ------
        InvalidArgument
            If that makes more than 50 million rows, 7 GB; record less often, or run on in parts.
        """
        (ticks,) = _ticks([self.options], duration_s, record_every)
        return self._loop.run(ticks, record_every)

    def hold_command(self, *, motor_command_nm: float = 0.0, brake_command_nm: float = 0.0) -> None:
        """Give the actuators this from now on; the law only senses, without a scene.

        Raises
        ------
        InvalidArgument
            Unless the motor's torque is -100 to 100 N m, and the brake's 0 to 100.
        """
        self._loop.hold_command(
            checks.number("motor_command_nm", motor_command_nm, -MAX_TORQUE_NM, MAX_TORQUE_NM),
            checks.number("brake_command_nm", brake_command_nm, 0.0, MAX_TORQUE_NM),
        )

    def release_command(self) -> None:
        """Let the law act again."""
        self._loop.release_command()

    def set_scene(self, scene: Scene | None) -> None:
        """Play another scene from the next tick on, as `Knob.play` changes it.

        An effect with the same place and values goes on; any other starts anew.

        Raises
        ------
        InvalidArgument
            Names effect, field, value and range; the old scene goes on.
        """
        options = replace(self.options, scene=scene)
        self._loop.set_scene(options)
        self.options = options

    def stream_local_model(
        self,
        *,
        torque_nm: float = 0.0,
        angle_rad: float = 0.0,
        stiffness_nm_per_rad: float = 0.0,
        damping_nm_s_per_rad: float = 0.0,
    ) -> None:
        """Add what a host streams, from the next tick on, as `Knob.stream_local_model`.

        No deadline ends it, only another one.

        Raises
        ------
        InvalidArgument
            Names field, value and range; the old one goes on.
        """
        self._loop.stream_local_model(
            checks.number("torque_nm", torque_nm),
            checks.number("angle_rad", angle_rad),
            checks.number("stiffness_nm_per_rad", stiffness_nm_per_rad),
            checks.number("damping_nm_s_per_rad", damping_nm_s_per_rad),
        )

    def set_hand(self, hand: Hand) -> None:
        """Let another hand take over; times of its profiles are the rows' times."""
        self._loop.set_hand(hand)


def simulate(options: LoopOptions, *, duration_s: float, record_every: int = 1) -> Record:
    """Run a closed loop from its beginning; give LOOP_DTYPE rows, as `ClosedLoop.run` does."""
    return ClosedLoop(options).run(duration_s=duration_s, record_every=record_every)


def simulate_many(
    options: Sequence[LoopOptions],
    *,
    duration_s: float,
    record_every: int = 1,
    threads: int | None = None,
    on_progress: Callable[[int], None] | None = None,
) -> list[Record]:
    """Run many closed loops, several at a time, with the same results as `simulate`.

    Parameters
    ----------
    threads
        How many run at once; None is as many as this process may use.
    on_progress
        Called now and then with the number of runs that are done.

    Returns
    -------
    list
        For each of the options LOOP_DTYPE rows, shape (n,).

    Raises
    ------
    InvalidArgument
        If all of them together make more than 50 million rows, 7 GB; record less often, or hand
        over fewer at once.
    """
    threads = checks.threads(threads)
    options = list(checks.each("options", options, "several LoopOptions"))
    for one in options:
        checked_options(one)
    ticks = _ticks(options, duration_s, record_every)

    def run(one: LoopOptions, count: int) -> Record:
        return _torsio.emulator.ClosedLoop(one).run(count, record_every)

    pool = ThreadPoolExecutor(threads)
    try:
        runs = [pool.submit(run, *each) for each in zip(options, ticks, strict=True)]
        waiting = set(runs)
        while waiting:
            # The runs have the interpreter's lock only to begin and to end.
            done, waiting = wait(waiting, timeout=0.05, return_when=FIRST_EXCEPTION)
            for finished in done:
                finished.result()
            if on_progress is not None:
                on_progress(len(runs) - len(waiting))
        return [finished.result() for finished in runs]
    finally:
        pool.shutdown(cancel_futures=True)


def replay(options: LoopOptions, counts: npt.ArrayLike) -> Record:
    """Run the controller alone over recorded counts of its encoder, one tick each.

    Parameters
    ----------
    options
        Plant, encoder, hand and delay are not looked at, except that `plant` gives the actuator.
    counts
        Unsigned 32-bit numbers, shape (n,).

    Returns
    -------
    ndarray
        REPLAY_DTYPE rows, shape (n,).
    """
    checked_options(options)
    return _torsio.emulator.replay(options, np.ascontiguousarray(counts, dtype=np.uint32))


def reports(options: LoopOptions) -> list[bytes]:
    """Give the configuration and the scene of a loop as the reports that a device would be sent."""
    checked_options(options)
    return _torsio.emulator.loop_reports(options)


def _ticks(options: Sequence[LoopOptions], duration_s: float, record_every: int) -> list[int]:
    # Longer than a thousand years is a slip of the keyboard.
    duration_s = checks.number("duration_s", duration_s, 0.0, 3.2e10)
    every = checks.whole("record_every", record_every, 1, 2**32 - 1)
    ticks = [round(duration_s * 1e9 / one.control_period_ns) for one in options]
    rows = sum(-(-count // every) for count in ticks)
    if rows > _MOST_ROWS:
        raise InvalidArgument(
            f"duration_s is {duration_s:g} with record_every {every}, which makes {rows:,} rows of "
            f"{LOOP_DTYPE.itemsize} bytes; allowed are {_MOST_ROWS:,} at once. Set record_every to "
            f"{math.ceil(sum(ticks) / _MOST_ROWS):,} or more, or run shorter parts in turn "
            "(ClosedLoop.run goes on where it stopped)"
        )
    return ticks


def checked_options(options: LoopOptions) -> None:
    """Ask for the right kinds; what is out of its range is refused further down."""
    checks.kind("options", options, LoopOptions, "LoopOptions")
    checks.kind("plant", options.plant, PlantParams, "PlantParams")
    checks.kind("control", options.control, ControlConfig, "a ControlConfig")
    for name, wanted in {**CONFIGS, "spin_up": SpinUp, "initial": InitialState}.items():
        value = getattr(options, name, None)
        if value is not None:
            checks.kind(name, value, wanted, f"{wanted.__name__} or None")
    checks.whole("control_period_ns", options.control_period_ns, 1_000, 1_000_000_000)
