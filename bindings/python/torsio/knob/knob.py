"""The knob: open it, arm it, play scenes on it, record what happens."""

from __future__ import annotations

import atexit
import concurrent.futures.thread
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Iterable
from pathlib import Path

from torsio import _torsio
from torsio.common import checks, notebook
from torsio.common.emulated import moves_parts
from torsio.errors import Closed, Error
from torsio.knob.configuration import KnobConfiguration
from torsio.knob.emulated import Emulator
from torsio.knob.events import KnobEvents
from torsio.knob.parts import of_part
from torsio.knob.recording import KnobRecording
from torsio.knob.scenes import KnobScenes
from torsio.knob.steps import Steps
from torsio.knob.telemetry import KnobTelemetry
from torsio.knob.warnings import held_low, no_speed_limit
from torsio.printed import config as configs
from torsio.printed.scenes import Scene
from torsio.printed.told import (
    Clock,
    DeviceInfo,
    Disarm,
    Energies,
    GameEffect,
    GameStatus,
    Health,
    Limits,
    LinkStatistics,
    MotorCurrent,
    State,
)
from torsio.recordings.file import RecordingFile
from torsio.recordings.writing import wait_for_all

__all__ = ["Knob", "need_knob"]

_RECORDED_SLICE_S = 0.125


class Knob:
    """An open knob, made by `torsio.open`. Use it in a ``with`` statement.

    Every method may be called from any thread. Methods that wait let other threads run, and Ctrl-C
    interrupts them. Every method raises `Disconnected` once the device is unplugged, `Closed` after
    `close`, and `Timeout` when the device does not answer.

    Durations count in the device's time: the wall clock, or a virtual one of an emulated device.
    """

    def __init__(
        self, knob: _torsio.Knob, *, logs_inputs: bool = False, time_waits: bool = False
    ) -> None:
        if isinstance(knob, Knob) or not hasattr(knob, "info"):
            named = checks.show(knob) if isinstance(knob, str) else ""
            raise TypeError(f"a knob is opened by torsio.open({named})")
        self._knob = knob
        self._path: str = knob.info()["path"]
        self._recording = KnobRecording(knob, logs_inputs=logs_inputs, time_waits=time_waits)
        self._configuration = KnobConfiguration(knob, self._recording)
        self._scenes = KnobScenes(knob, self._recording)
        self._telemetry = KnobTelemetry(knob, self._recording)
        self._events = KnobEvents(knob)
        _open_knobs[id(self._recording)] = weakref.ref(self), weakref.ref(self._recording)

    def __enter__(self) -> Knob:
        """Give the knob itself. Raises `Closed` if it is none any more."""
        if not self.is_open:
            raise Closed("the knob was closed; open it again")
        return self

    @_torsio.all_of
    def __exit__(self, *_: object) -> Iterable[Callable[[], object]]:
        """Close the knob."""
        return (self.close,)

    def __repr__(self) -> str:
        """Say which device it is and what state it is in."""
        state = self.state if self.is_open else "closed"
        return f"<torsio.Knob {self._path!r} {state}>"

    def _repr_html_(self) -> str:
        info = self._knob.info() if self.is_open else {}
        return notebook.knob(repr(self), info, self.position_rad)

    @_torsio.all_of
    def close(self) -> Iterable[Callable[[], object]]:
        """Disarm, unless told to be autonomous or not armed by the SDK, and let go.

        An error meanwhile, such as a full disk or Ctrl-C, is raised after that. If your own
        transport does not take the order, `sys.unraisablehook` gets an `Error`. Closing twice
        is fine.
        """
        return self._let_go, self._recording.wait, self._recording.tell_failure

    @_torsio.all_of
    def _let_go(self) -> Iterable[Callable[[], object]]:
        return (
            *(self._knob.disarm_to_close, self._recording.end, self._telemetry.end),
            *(self._knob.close, self._forget),
        )

    def _forget(self) -> None:
        self._events.forget()
        _open_knobs.pop(id(self._recording), None)

    @property
    def is_open(self) -> bool:
        """False once closed."""
        return self._knob.is_open

    # State -----------------------------------------------------------------------------

    @property
    def info(self) -> DeviceInfo:
        """The device's identity."""
        return DeviceInfo(**self._knob.info())

    @property
    def state(self) -> State:
        """As last heard of; costs nothing."""
        return self._knob.state

    @property
    def last_disarm(self) -> Disarm | None:
        """How the torque went the last time since the knob was opened; costs nothing."""
        disarm = self._knob.last_disarm()
        return None if disarm is None else Disarm(**disarm)

    @property
    def is_emulated(self) -> bool:
        """True if there is an `emulator`."""
        return self._knob.is_emulated

    @property
    def emulator(self) -> Emulator:
        """The world round an emulated knob. Raises `Error` on real hardware."""
        if not self._knob.is_emulated:
            raise Error("this knob is real hardware: it has no emulator")
        return Emulator(self._knob)

    def health(self) -> Health:
        """Ask the device for its state, faults and counters."""
        return Health(**self._knob.health())

    def energies(self) -> Energies:
        """Tell what motor, brake and shaft have done to the knob, if the law is ``"calibrated"``.

        And how stiff a wall is rendered now; docs/explanation/theory.md, "Bounded stiffness".
        """
        return Energies(**self._knob.energies())

    def motor_current(self) -> MotorCurrent:
        """Tell what the current sensor has shown and the bridge was told since the board started.

        Nothing is `measured` on a board without a current sensor, and on an emulated knob without
        `torsio.Electrics`.
        """
        return MotorCurrent(**self._knob.motor_current())

    def limits(self) -> Limits:
        """Tell the most that the device gives, and whether it is held low."""
        return Limits(**self._knob.limits())

    def faults(self) -> tuple[str, ...]:
        """Ask the device for the names of its latched faults: "over_speed" ..."""
        return self._knob.faults()

    def clock(self) -> Clock:
        """Ask the device for its time and position."""
        return Clock(**self._knob.clock())

    def position_rad(self) -> float:
        """Ask the device for its angle."""
        return self._knob.position_rad()

    def statistics(self) -> LinkStatistics:
        """Give the counters of this end of the cable."""
        return LinkStatistics(**self._knob.statistics())

    def game_status(self) -> GameStatus:
        """Ask what games do with the device over its game interface."""
        return GameStatus(**self._knob.game_status())

    def game_effects(self) -> tuple[GameEffect, ...]:
        """Ask for the effects that games have made, in the order of their blocks.

        Three at a time are of the same moment.
        """
        return tuple(GameEffect(**effect) for effect in self._knob.game_effects())

    # Actions ---------------------------------------------------------------------------

    def arm(self) -> None:
        """Torque on. Raises `Refused` while a fault is latched.

        Warns with `HeldLowWarning` if a board gives little torque, because its parts are not
        confirmed; `limits` tells how much. Warns with `NoSpeedLimitWarning` if a board's
        `speed_limit_rad_s` is not set.
        """
        # Before the torque: if you turn warnings into errors, the knob stays disarmed.
        if self._is_held_low():
            warnings.warn(held_low(self.limits()), stacklevel=2)
        elif moves_parts(self.info.board) and self.limits().speed_limit_rad_s == 0.0:
            warnings.warn(no_speed_limit(), stacklevel=2)
        self._arm()

    def _arm(self) -> None:
        self._recording.note("arm")  # before the torque: it may raise
        self._knob.arm()
        self._recording.armed()

    def _is_held_low(self) -> bool:
        return moves_parts(self.info.board) and self.limits().held_low

    def disarm(self) -> None:
        """Torque off; the scene stays."""
        self._knob.disarm()
        self._recording.note("disarm")

    def stop(self) -> None:
        """Torque off, and the scene is emptied."""
        self._knob.stop()
        self._recording.stopped()

    def zero(self) -> None:
        """Make this position angle 0. Raises `Refused` unless disarmed."""
        self._knob.zero()
        self._recording.note("zero")

    def relax(self) -> None:
        """Tell the sensor that the shaft is relaxed now. Raises `Refused` unless disarmed."""
        self._knob.relax()

    def clear_fault(self) -> None:
        """Forget latched faults. Raises `Refused` while their cause is there."""
        self._knob.clear_fault()
        self._recording.note("clear_fault")

    # Scenes ----------------------------------------------------------------------------

    # Written out, which is faster: a program may call it each millisecond.
    def play(self, scene: Scene) -> None:  # noqa: D102
        self._scenes.play(scene)

    play.__doc__ = KnobScenes.play.__doc__

    # `of_part` puts the part's method in the place of an empty body like these.
    @of_part("_scenes", KnobScenes.stable_stiffness)
    def stable_stiffness(self) -> None: ...

    @of_part("_scenes", KnobScenes.stream_local_model)
    def stream_local_model(self) -> None: ...

    @of_part("_scenes", KnobScenes.excite)
    def excite(self) -> None: ...

    # Configuration --------------------------------------------------------------------------

    @of_part("_configuration", KnobConfiguration.ask)
    def config(self) -> None: ...

    @of_part("_configuration", KnobConfiguration.configure)
    def configure(self) -> None: ...

    @of_part("_configuration", KnobConfiguration.update)
    def update(self) -> None: ...

    @of_part("_configuration", KnobConfiguration.save)
    def save(self) -> None: ...

    @of_part("_configuration", KnobConfiguration.load_defaults)
    def load_defaults(self) -> None: ...

    # begin: generated by ./dev generate
    def actuator_config(self) -> configs.ActuatorConfig:
        """Ask the device for its `ActuatorConfig`."""
        return self._configuration.ask(configs.ActuatorConfig)

    def control_config(self) -> configs.ControlConfig:
        """Ask the device for its `ControlConfig`."""
        return self._configuration.ask(configs.ControlConfig)

    def board_config(self) -> configs.BoardConfig:
        """Ask the device for its `BoardConfig`."""
        return self._configuration.ask(configs.BoardConfig)

    def game_config(self) -> configs.GameConfig:
        """Ask the device for its `GameConfig`."""
        return self._configuration.ask(configs.GameConfig)

    def shaft_config(self) -> configs.ShaftConfig:
        """Ask the device for its `ShaftConfig`."""
        return self._configuration.ask(configs.ShaftConfig)

    def calibration_config(self) -> configs.CalibrationConfig:
        """Ask the device for its `CalibrationConfig`."""
        return self._configuration.ask(configs.CalibrationConfig)

    # end: generated by ./dev generate

    # Telemetry ------------------------------------------------------------------------------

    @of_part("_telemetry", KnobTelemetry.start_telemetry)
    def start_telemetry(self) -> None: ...

    @of_part("_telemetry", KnobTelemetry.stop_telemetry)
    def stop_telemetry(self) -> None: ...

    @of_part("_telemetry", KnobTelemetry.latest)
    def latest(self) -> None: ...

    @of_part("_telemetry", KnobTelemetry.read)
    def read(self) -> None: ...

    @of_part("_telemetry", KnobTelemetry.record)
    def record(self) -> None: ...

    @of_part("_telemetry", KnobTelemetry.telemetry)
    def telemetry(self) -> None: ...

    # Events ---------------------------------------------------------------------------------

    @of_part("_events", KnobEvents.events)
    def events(self) -> None: ...

    @of_part("_events", KnobEvents.on_event)
    def on_event(self) -> None: ...

    # Recording ------------------------------------------------------------------------------

    def record_to(self, path: str | Path) -> RecordingFile:
        """Write all that happens from now on to a file, until the recording or the knob is closed.

        Telemetry is started if it does not run. Samples are written as the program reads them.
        When it sleeps, or the recording ends, unread samples are written too and cannot be read
        any more. The file also gets every order, and first the scene that plays, if it was played
        here. Its end gives a `DisarmedWarning` if a scene was played and never armed.

        Parameters
        ----------
        path
            A file to be made or overwritten; its name ends in ``.mcap``.

        Returns
        -------
        RecordingFile
            For a ``with`` statement, and for notes of one's own. `torsio.load` reads the file.

        Raises
        ------
        Error
            If one is under way already, or to this file, or the package mcap is missing.
        OSError
            If the file cannot be written.
        """
        path = checks.path("path", path)
        return self._recording.begin(path, self.info, self._configuration.all())

    # Waiting --------------------------------------------------------------------------------

    def sleep(self, duration_s: float) -> None:
        """Let time pass."""
        duration_s = checks.number("duration_s", duration_s)
        # In slices that the ring of samples holds, so that a recording has them all.
        while self._recording.is_under_way and duration_s > _RECORDED_SLICE_S:
            self._knob.sleep(_RECORDED_SLICE_S)
            self._recording.drain()
            duration_s -= _RECORDED_SLICE_S
        self._knob.sleep(duration_s)
        self._recording.drain()

    def every(self, period_s: float) -> Steps:
        """Iterate over steps of a program's own loop at equal distances of time, the first at once.

        >>> with torsio.open("emulated") as knob:
        ...     knob.start_telemetry(prompt=True)
        ...     for step in knob.every(0.001):
        ...         angle_rad = float(knob.latest()["angle_rad"])
        ...         if step.index == 9:
        ...             break
        1000.0

        A step that is late by a whole period or more is left out and counted, so that the loop
        never runs to catch up. `period_s` is from 0.0001 to 3600.
        """
        return Steps(self._knob.every(checks.number("period_s", period_s)))

    def wait_for(self, state: State, *, timeout_s: float = 1.0) -> bool:
        """Wait until the device is in a state. Returns False if it is not so in time."""
        checks.text("state", state)
        return self._knob.wait_for(state, checks.number("timeout_s", timeout_s))


def need_knob(knob: object) -> None:
    """Ask for a knob, open or closed."""
    checks.kind("knob", knob, Knob, "a knob, as torsio.open() gives it")


# By address, so that a new knob takes the place of a dead one. Not a WeakSet: Python drops a Ctrl-C
# that falls into the callback of its references.
_open_knobs: dict[int, tuple[weakref.ref[Knob], weakref.ref[KnobRecording]]] = {}


@atexit.register
@_torsio.all_of
def _close_all() -> Iterable[Callable[[], object]]:
    """Close all open knobs when the interpreter ends, whatever daemon threads wait."""
    known = list(_open_knobs.values())
    knobs = [knob for this, _ in known if (knob := this()) is not None]
    # A generator of telemetry may outlive its knob.
    rests = [rest for this, of in known if this() is None and (rest := of()) is not None]
    disarms = [*[knob._knob.disarm_to_close for knob in knobs], *[rest.disarm for rest in rests]]
    # Before any waits for its file:
    lets_go = [*[knob._let_go for knob in knobs], *[rest.let_go for rest in rests]]
    return [*disarms, *lets_go, *[knob.close for knob in knobs], wait_for_all]


def _close_all_early() -> None:
    """Close them before Python waits for threads, if an exception has ended the main thread."""
    if not hasattr(sys, "last_value"):  # otherwise they may still need a knob
        return
    try:
        _close_all()
    except Exception:
        sys.excepthook(*sys.exc_info())


# Private, but `concurrent.futures` needs it too, which registers earlier: the last is called first.
assert concurrent.futures.thread
if hasattr(threading, "_register_atexit"):
    threading._register_atexit(_close_all_early)
