"""The knob: open it, arm it, play scenes on it, record what happens."""

from __future__ import annotations

import atexit
import platform
import warnings
import weakref
from collections.abc import Callable, Iterable, Iterator, Sized
from dataclasses import asdict, fields, replace
from difflib import get_close_matches
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Any, Final, TypeAlias

from torsio import _torsio, checks
from torsio.config import ActuatorConfig, BoardConfig, ControlConfig, GameConfig
from torsio.emulated_knob import Emulator, EmulatorOptions
from torsio.errors import (
    Closed,
    DisarmedWarning,
    Error,
    HeldLowWarning,
    StiffnessWarning,
    Timeout,
)
from torsio.events import tell
from torsio.protocol import fingerprint
from torsio.recording import RecordingFile
from torsio.records import (
    Clock,
    DeviceInfo,
    Disarm,
    Event,
    GameEffect,
    GameStatus,
    Health,
    Limits,
    LinkStatistics,
    ListedDevice,
    StableStiffness,
    State,
)
from torsio.scenes import Effect, Excitation, Scene
from torsio.stability import LIMITS, steepness_nm_per_rad
from torsio.steps import Steps
from torsio.telemetry import Record

__all__ = ["Config", "Knob", "list_devices", "open"]

Config: TypeAlias = ActuatorConfig | BoardConfig | ControlConfig | GameConfig

_CONFIGS: Final[dict[type[Config], str]] = {
    ActuatorConfig: "actuator",
    ControlConfig: "control",
    BoardConfig: "board",
    GameConfig: "game",
}
_CONFIG_OF: Final = {field.name: config for config in _CONFIGS for field in fields(config)}
assert len(_CONFIG_OF) == sum(len(fields(config)) for config in _CONFIGS), "a name has two meanings"

# Telemetry for a quarter of an hour at 20 kHz; more is a slip of the pen.
_MAX_SAMPLES = 2**24
_MAX_EFFECTS = 16
_RECORDED_SLICE_S = 1.0
# Softer than what a knob of plausible parts swings in: not worth asking the device for its limit.
_STABLE_ON_ANY_NM_PER_RAD = 1.0

# Thirty years. A timeout of nothing would end before anything can have come.
_LONGEST_S, _SHORTEST_TIMEOUT_S = 1e9, 1e-3


class Knob:
    """An open knob, made by `torsio.open`. Use it in a ``with`` statement.

    Every method may be called from any thread, and every method that waits lets other threads run
    and can be interrupted with Ctrl-C. Besides what is named, methods raise `Disconnected` once the
    device is unplugged, `Closed` after `close`, and `Timeout` when the device does not answer.

    Durations count in the device's time: the wall clock, or the virtual clock of an emulated device
    that is not paced.
    """

    def __init__(self, knob: _torsio.Knob, *, logs_inputs: bool = False) -> None:
        self._knob = knob
        self._logs_inputs = logs_inputs
        self._path: str = knob.info()["path"]
        self._recording: RecordingFile | None = None
        self._stable: tuple[StableStiffness, bool] | None = None  # what `play` has asked for
        self._report_tap: _torsio.ReportTap | None = None
        self._told: Callable[[dict[str, Any]], object] | None = None
        _open_knobs.add(self)

    def __enter__(self) -> Knob:
        """Give the knob itself. Raises `Closed` if it is none any more."""
        if not self.is_open:
            raise Closed("the knob was closed; open it again")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the knob."""
        self.close()

    def __repr__(self) -> str:
        """Say which device it is and what state it is in."""
        state = self.state if self.is_open else "closed"
        return f"<torsio.Knob {self._path!r} {state}>"

    def close(self) -> None:
        """Disarm, unless told to be autonomous, and let go. Closing twice is fine."""
        if self._recording is not None:
            self._recording.close()
        self._knob.close()
        self._told = None

    @property
    def is_open(self) -> bool:
        """False once closed."""
        return self._knob.is_open

    # What it is -----------------------------------------------------------------------------

    @property
    def info(self) -> DeviceInfo:
        """Who the device is."""
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
            raise Error("this knob is real hardware: it has no emulated world")
        return Emulator(self._knob)

    def health(self) -> Health:
        """Ask the device for its state, faults and counters."""
        return Health(**self._knob.health())

    def limits(self) -> Limits:
        """Tell the most that the device gives, and whether it is held low until confirmed."""
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

    # What it does ---------------------------------------------------------------------------

    def arm(self) -> None:
        """Torque on. Raises `Refused` while a fault is latched.

        Warns with `HeldLowWarning` if this is a board whose parts nobody has confirmed, which gives
        little; `limits` tells how much.
        """
        self._note("arm")
        self._knob.arm()
        if self._is_held_low():
            limits = self.limits()
            warnings.warn(
                f"nobody has confirmed the parts of this board, so it gives "
                f"{1e3 * limits.motor_torque_nm:.3g} mN m and {limits.speed_rad_s:g} rad/s at "
                "most: set what motor, brake and encoder it has (docs/hardware.md, first power), "
                "calibrate, then knob.update(confirmed=True) and knob.save()",
                HeldLowWarning,
                stacklevel=2,
            )

    def _is_held_low(self) -> bool:
        return self.info.board != "emulated" and self.limits().held_low

    def disarm(self) -> None:
        """Torque off; the scene stays."""
        self._note("disarm")
        self._knob.disarm()

    def stop(self) -> None:
        """Torque off, and the scene is emptied."""
        self._note("stop")
        self._knob.stop()

    def zero(self) -> None:
        """Make this position angle 0. Raises `Refused` unless disarmed."""
        self._note("zero")
        self._knob.zero()

    def relax(self) -> None:
        """Tell the sensor that the shaft is relaxed now. Raises `Refused` unless disarmed."""
        self._knob.relax()

    def clear_fault(self) -> None:
        """Forget latched faults. Raises `Refused` while their cause is there."""
        self._note("clear_fault")
        self._knob.clear_fault()

    def play(self, scene: Scene) -> None:
        """Play a scene in place of the one before, all of it from the same tick on.

        Parameters
        ----------
        scene
            One effect, or an iterable of up to 16. The place in the list is an effect's identity:
            one that stands at the same place with the same values as before goes on playing, any
            other starts anew. The knob must be armed to be felt.

        Raises
        ------
        InvalidArgument
            Names effect, field, value and range; nothing was sent and the old scene goes on.
        Refused
            The device said no; the old scene goes on.

        Warns
        -----
        StiffnessWarning
            It plays, and the knob may swing for ever in an effect that is stiffer than
            `stable_stiffness`; not with the law ``"calibrated"``, which renders it more softly.
        """
        if isinstance(scene, Iterable) and not isinstance(scene, Sized):
            # It may have no end: one effect too many is enough to refuse it.
            scene = list(islice(scene, _MAX_EFFECTS + 1))
        effects = list(scene) if isinstance(scene, Iterable) else [scene]
        self._note("play", scene=effects)
        self._knob.play(scene)
        self._warn_if_too_stiff(effects)

    def _warn_if_too_stiff(self, effects: list[Effect]) -> None:
        steepest = max(map(steepness_nm_per_rad, effects), default=0.0)
        if steepest <= _STABLE_ON_ANY_NM_PER_RAD:
            return
        if self._stable is None:
            self._stable = (self.stable_stiffness(), self.control_config().law == "calibrated")
        stable, is_bounded = self._stable
        if steepest > stable.stiffness_nm_per_rad and not is_bounded:
            warnings.warn(
                f"a stiffness of {steepest:g} N m/rad is more than the "
                f"{stable.stiffness_nm_per_rad:.3g} that this knob can render without swinging "
                f"({LIMITS[stable.limited_by]}); make it softer, or set the law 'calibrated', "
                "which never swings",
                StiffnessWarning,
                stacklevel=3,
            )

    def stable_stiffness(self) -> StableStiffness:
        """Ask how stiff a spring the knob's parts can render, by its configuration.

        Beyond that the knob may swing for ever in a spring or wall, at the motor's full torque,
        unless the law is ``"calibrated"``. `torsio.stability` has the map over damping.
        """
        return StableStiffness(**self._knob.stable_stiffness())

    def stream_local_model(
        self,
        *,
        torque_nm: float = 0.0,
        angle_rad: float = 0.0,
        stiffness_nm_per_rad: float = 0.0,
        damping_nm_s_per_rad: float = 0.0,
        deadline_s: float = 0.02,
    ) -> None:
        """Send a torque, a spring and a damper for the device to render at its own rate.

        They act on top of the scene until the next ones come. Does not wait for the device; past
        the deadline the device fails passive. A deadline of 0 ends the stream in good order.

        Raises
        ------
        Refused
            If the knob is known not to be armed. What the device refuses later only counts in
            :meth:`statistics`.
        """
        self._knob.stream_local_model(
            checks.number("torque_nm", torque_nm),
            checks.number("angle_rad", angle_rad),
            checks.number("stiffness_nm_per_rad", stiffness_nm_per_rad),
            checks.number("damping_nm_s_per_rad", damping_nm_s_per_rad),
            checks.number("deadline_s", deadline_s),
        )

    def excite(self, excitation: Excitation) -> None:
        """Play a bounded experiment in place of scene and law: commands of motor and brake.

        The next one goes on from where this one is; whatever leaves its bounds, or comes to its
        end, disarms. For calibration.

        Raises
        ------
        InvalidArgument
            Names field, value and range.
        Refused
            Unless armed by this library.
        """
        checks.kind("excitation", excitation, Excitation, "a torsio.Excitation")
        self._knob.excite(excitation)

    # Events ---------------------------------------------------------------------------------

    def events(self, timeout_s: float = 0.0) -> list[Event]:
        """Take what the device has told of itself and nobody has taken yet, oldest first.

        Changes of state and owner, faults, silence, missed deadlines, the end of the connection.
        1,024 are kept; what is older counts as lost in `statistics`.

        Parameters
        ----------
        timeout_s
            How long to wait for one if there is none.
        """
        taken = self._knob.events(checks.number("timeout_s", timeout_s))
        return [Event(**event) for event in taken]

    def on_event(self, callback: Callable[[Event], object] | None) -> None:
        """Call back with every event from now on; None ends it.

        One after the other: from a thread of the knob, or, in virtual time, from the thread that
        lets time pass. The callback may use the knob. What it raises goes to
        `sys.unraisablehook`, and the next event is told all the same.
        """
        told = tell(callback)
        self._told = told
        if told is None:
            self._knob.on_event(None)
            return
        # Mostly the callback has the knob. The extension must not have it then, because the garbage
        # collector does not see what the extension has.
        this = weakref.ref(self)

        def hear(event: dict[str, Any]) -> None:
            knob = this()
            if knob is not None and knob._told is not None:
                knob._told(event)

        self._knob.on_event(hear)

    # Configuration --------------------------------------------------------------------------

    def actuator_config(self) -> ActuatorConfig:
        """Ask the device for the actuator as it knows it."""
        return ActuatorConfig(**self._knob.actuator_config())

    def control_config(self) -> ControlConfig:
        """Ask the device how it controls."""
        return ControlConfig(**self._knob.control_config())

    def board_config(self) -> BoardConfig:
        """Ask the device what is wired to its board."""
        return BoardConfig(**self._knob.board_config())

    def game_config(self) -> GameConfig:
        """Ask the device what games may do."""
        return GameConfig(**self._knob.game_config())

    def configure(self, config: Config) -> None:
        """Set a whole configuration while disarmed.

        Fields that were left at their defaults take these, whatever the device had; to change some
        and keep the rest there is `update`. Another encoder's resolution also empties the scene. A
        board's wiring takes effect when the device starts the next time, if it was saved.

        Raises
        ------
        InvalidArgument
            Names field, value and range.
        Refused
            Unless disarmed.
        """
        if type(config) not in _CONFIGS:
            raise TypeError(f"not a configuration: {config!r}")
        self._note("configure", config=config)
        self._stable = None
        getattr(self._knob, f"configure_{_CONFIGS[type(config)]}")(config)

    def update(self, **changes: Any) -> None:
        """Change fields of a configuration while disarmed, and keep the rest.

        Parameters
        ----------
        changes
            Fields of one of `ActuatorConfig`, `ControlConfig`, `BoardConfig` and `GameConfig`, as
            in ``knob.update(law="compensated", speed_limit_rad_s=40.0)``.

        Raises
        ------
        TypeError
            If no configuration has such a field, or not all are of the same one.
        InvalidArgument, Refused
            As in `configure`; nothing was changed.
        """
        configs = {_config_of(name): name for name in changes}
        if not configs:
            raise TypeError("update() needs a field to change, such as law='compensated'")
        if len(configs) > 1:
            places = " and ".join(f"{name} of {kind.__name__}" for kind, name in configs.items())
            raise TypeError(f"update() changes one configuration at a time, not {places}")
        config = next(iter(configs))
        current = config(**getattr(self._knob, f"{_CONFIGS[config]}_config")())
        self.configure(replace(current, **changes))

    def save(self) -> None:
        """Keep the configuration over power-off. Returns when it is safe."""
        self._knob.save()

    def load_defaults(self) -> None:
        """Take the configuration of a new device. Raises `Refused` unless disarmed."""
        self._stable = None
        self._knob.load_defaults()

    # Telemetry ------------------------------------------------------------------------------

    def start_telemetry(self, rate_hz: float | None = None, *, prompt: bool = False) -> float:
        """Start telemetry, or change its rate, and forget what was not read.

        Parameters
        ----------
        rate_hz
            Highest rate wanted, up to the control rate and 4,000 Hz. None takes the highest up to
            3,600 Hz, which leaves the cable room for answers; above that samples are lost if
            commands are sent all the time.
        prompt
            Have the device report in every frame, a millisecond, the newest samples that are there,
            at most 4, instead of full reports: for loops that use `latest`. Without a rate this is
            1,000 Hz.

        Returns
        -------
        float
            The true rate: the device sends every n-th control tick.

        Raises
        ------
        InvalidArgument
            Says which rates this knob has.
        """
        return self._knob.start_telemetry(_rate(rate_hz), checks.flag("prompt", prompt))

    def stop_telemetry(self) -> None:
        """Stop telemetry; a `record` in another thread keeps it until that is done."""
        self._knob.stop_telemetry()

    def latest(self) -> Record:
        """Give the newest sample that has arrived; it can still be read.

        Waits only for the very first. Raises `Error` if no telemetry runs.

        Returns
        -------
        Record
            Of `torsio.telemetry.TELEMETRY_DTYPE`, shape ().
        """
        return self._knob.latest().reshape(())

    def read(self, *, max_samples: int = 4096, timeout_s: float = 1.0) -> Record:
        """Take samples, oldest first; wait until there is one or the time is over.

        Returns
        -------
        Record
            Of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,), 0 <= n <= max_samples.
        """
        return self._recorded(
            self._knob.read(
                checks.whole("max_samples", max_samples, 0, _MAX_SAMPLES),
                checks.number("timeout_s", timeout_s),
            )
        )

    def record(
        self,
        duration_s: float,
        *,
        rate_hz: float | None = None,
        must_stay_armed: bool = False,
    ) -> Record:
        """Let time pass and give every sample of that span.

        Starts telemetry if it does not run, or if a rate is given. Threads may record at the same
        time. If it ends early the samples that came can still be read, and the exception, also
        KeyboardInterrupt, has all of them as its attribute `samples`.

        Parameters
        ----------
        must_stay_armed
            Raise `Disarmed` when the torque goes meanwhile, instead of `DisarmedWarning` at the
            end.

        Returns
        -------
        Record
            Of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,).
        """
        duration_s = checks.number("duration_s", duration_s)
        rate_hz = _rate(rate_hz)
        kept: list[Any] = []
        try:
            self._knob.record(
                duration_s, rate_hz, checks.flag("must_stay_armed", must_stay_armed), kept
            )
        except BaseException as error:
            if kept:
                self._recorded(kept[0])
                error.samples = kept[0]  # type: ignore[attr-defined]
            raise
        samples: Record
        samples, disarm = kept
        if disarm is not None:
            warnings.warn(
                f"the torque went during the recording, at tick {disarm['tick']} "
                f"({', '.join((disarm['reason'], *disarm['faults']))}); "
                "must_stay_armed raises an error instead",
                DisarmedWarning,
                stacklevel=2,
            )
        return self._recorded(samples)

    def telemetry(
        self,
        duration_s: float | None = None,
        *,
        rate_hz: float | None = None,
        max_samples: int = 4096,
        timeout_s: float = 1.0,
    ) -> Iterator[Record]:
        """Iterate over telemetry as it comes, in arrays of one sample or more.

        Parameters
        ----------
        duration_s
            None goes on for ever.
        rate_hz
            As in `start_telemetry`, which the first step calls.
        max_samples
            Longest array.
        timeout_s
            `Timeout` is raised when nothing has come for so long, 1 ms or more.
        """
        # Here and not in the generator, which would complain only when it is first asked.
        if duration_s is not None:
            duration_s = checks.number("duration_s", duration_s, 0.0, _LONGEST_S)
        rate_hz = _rate(rate_hz)
        max_samples = checks.whole("max_samples", max_samples, 1, _MAX_SAMPLES)
        timeout_s = checks.number("timeout_s", timeout_s, _SHORTEST_TIMEOUT_S, _LONGEST_S)
        return self._telemetry(duration_s, rate_hz, max_samples, timeout_s)

    def _telemetry(
        self, duration_s: float | None, rate_hz: float | None, max_samples: int, timeout_s: float
    ) -> Iterator[Record]:
        rate_hz = self.start_telemetry(rate_hz)
        left = None if duration_s is None else round(duration_s * rate_hz)
        while left is None or left > 0:
            size = max_samples if left is None else min(max_samples, left)
            samples = self._recorded(self._knob.read(size, timeout_s))
            if len(samples) == 0:
                raise Timeout(f"no telemetry for {timeout_s} s")
            if left is not None:
                left -= len(samples)
            yield samples

    # Recording ------------------------------------------------------------------------------

    def record_to(self, path: str | Path) -> RecordingFile:
        """Write all that happens from now on to a file, until the recording or the knob is closed.

        Telemetry is started if it does not run. The program goes on as before: what it reads is
        written as it is read, and what it does not read when it sleeps or the recording ends; such
        samples are then not to be read any more. Everything asked of the knob is written too.

        Parameters
        ----------
        path
            A file to be made or overwritten; its name ends in ``.mcap`` by custom.

        Returns
        -------
        RecordingFile
            For a ``with`` statement, and for notes of one's own. `torsio.load` reads the file.

        Raises
        ------
        Error
            If one is under way already, or the package mcap is missing.
        OSError
            If the file cannot be written.
        """
        if self._recording is not None:
            raise Error("this knob is being recorded already: close that recording first")
        configs = (
            self.actuator_config(), self.control_config(), self.board_config(), self.game_config()
        )  # fmt: skip
        metadata = {
            "info": asdict(self.info),
            "configuration": {type(config).__name__: asdict(config) for config in configs},
            # Last: what has it has all of them.
            "versions": {
                "torsio": version("torsio"),
                "protocol": self.info.protocol_version,
                "fingerprint": fingerprint(),
                "firmware": self.info.firmware_version,
                "python": platform.python_version(),
                "system": f"{platform.system()} {platform.machine()}",
            },
        }
        # What is told from here on is in it.
        tap = self._knob.tap(with_telemetry=False)
        self._recording = RecordingFile(path, metadata, self._end_recording)
        self._report_tap = tap
        try:
            self.start_telemetry()
        except BaseException:
            self._recording.close()
            raise
        return self._recording

    def _end_recording(self) -> None:
        try:
            self._drain()
        except Error as error:
            self._note("lost", why=str(error))
            self._keep_reports()
        self._recording = self._report_tap = None

    def _note(self, kind: str, **values: Any) -> None:
        if self._recording is not None:
            self._recording.note(kind, **values)

    def _recorded(self, samples: Record) -> Record:
        """Keep samples in the recording, if there is one, and give them on."""
        if self._recording is not None:
            self._recording.write(samples, self.statistics().samples_lost)
            self._keep_reports()
        return samples

    def _keep_reports(self) -> None:
        if self._recording is not None:
            self._recording.write_reports(self._report_tap.take() if self._report_tap else [])
            if self._logs_inputs:
                self._recording.write_inputs(self.emulator.inputs())

    def _drain(self) -> None:
        while self._recording is not None and len(self._recorded(self._knob.read(65536, 0.0))):
            pass

    # Waiting --------------------------------------------------------------------------------

    def sleep(self, duration_s: float) -> None:
        """Let time pass."""
        duration_s = checks.number("duration_s", duration_s)
        # In slices that the ring of samples holds, so that a recording has them all.
        while self._recording is not None and duration_s > _RECORDED_SLICE_S:
            self._knob.sleep(_RECORDED_SLICE_S)
            self._drain()
            duration_s -= _RECORDED_SLICE_S
        self._knob.sleep(duration_s)
        self._drain()

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


_open_knobs: weakref.WeakSet[Knob] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    """Disarm and let go of what is still open when the interpreter ends, whoever waits on it."""
    for knob in list(_open_knobs):
        knob.close()


def _rate(rate_hz: float | None) -> float | None:
    return None if rate_hz is None else checks.number("rate_hz", rate_hz)


def _config_of(name: str) -> type[Config]:
    """Give the configuration that has a field of this name."""
    if name in _CONFIG_OF:
        return _CONFIG_OF[name]
    candidates = get_close_matches(name, _CONFIG_OF) or sorted(_CONFIG_OF)
    raise TypeError(
        f"no configuration has a field {name!r}; there are "
        + ", ".join(f"{field} ({_CONFIG_OF[field].__name__})" for field in candidates)
    )


def open(
    selector: str = "",
    *,
    emulator: EmulatorOptions | None = None,
    command_timeout_s: float = 1.0,
    ring_samples: int = 65536,
) -> Knob:
    """Open a knob. It is as it was left: look at its `state` to see whether it is armed.

    Parameters
    ----------
    selector
        Path, serial number, "emulated", "emulated:NAME", or empty for the only real device.
        "emulated" gives a new knob each time. "emulated:NAME" is one device: it keeps its saved
        configuration while the process lives, and a second open of it raises `DeviceBusy`.
    emulator
        What an emulated knob is like; an error with a selector that means a real one.
    command_timeout_s
        Longest wait for an answer of the device.
    ring_samples
        Telemetry kept until it is read; the oldest goes first.

    Raises
    ------
    DeviceNotFound, PermissionDenied, DeviceBusy, ProtocolMismatch, InvalidArgument
    """
    checks.kind(
        "emulator", emulator, (EmulatorOptions, type(None)), "a torsio.EmulatorOptions or None"
    )
    return Knob(
        _torsio.open_knob(
            checks.text("selector", selector),
            emulator=emulator,
            command_timeout_s=checks.number("command_timeout_s", command_timeout_s),
            ring_samples=checks.whole("ring_samples", ring_samples, 1, _MAX_SAMPLES),
        ),
        logs_inputs=emulator is not None and emulator.log_inputs,
    )


def list_devices() -> list[ListedDevice]:
    """List all knobs that are plugged in, and the emulated one, which is always last."""
    return [ListedDevice(**device) for device in _torsio.list_devices()]
