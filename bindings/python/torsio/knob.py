"""The knob: open it, arm it, play scenes on it, record what happens."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sized
from itertools import islice
from types import TracebackType

from torsio import _torsio, checks
from torsio.config import ActuatorConfig, BoardConfig, ControlConfig, GameConfig
from torsio.plant import PlantParams
from torsio.errors import Closed, Error, Timeout
from torsio.records import (
    Clock,
    DeviceInfo,
    Health,
    LinkStatistics,
    ListedDevice,
    State,
)
from torsio.game_port import GamePort
from torsio.hands import Hand
from torsio.scenes import Scene
from torsio.telemetry import Record

__all__ = ["Emulator", "Knob", "list_devices", "open"]

# Telemetry for a quarter of an hour at 20 kHz; more is a slip of the pen.
_MAX_SAMPLES = 2**24
_MAX_EFFECTS = 16

# Thirty years. A timeout of nothing would end before anything can have come.
_LONGEST_S, _SHORTEST_TIMEOUT_S = 1e9, 1e-3


class Emulator:
    """The world round an emulated knob: who holds it, what really happens, what goes wrong."""

    def __init__(self, knob: _torsio.Knob) -> None:
        self._knob = knob

    def set_hand(self, hand: Hand) -> None:
        """Give the knob into another hand at the next control tick, time 0 of its profiles."""
        self._knob.set_hand(hand)

    @property
    def time_s(self) -> float:
        """Device time."""
        return self._knob.emulator_time_s()

    def advance(self, duration_s: float) -> None:
        """Let time pass, like `Knob.sleep`."""
        self._knob.advance(checks.number("duration_s", duration_s))

    def truth(self) -> Record:
        """Take what no sensor sees, one row a control tick since the last call.

        Returns
        -------
        Record
            Of `torsio.telemetry.TRUTH_DTYPE`; empty unless opened with ``log_truth=True``.
        """
        return self._knob.take_truth()

    @property
    def game(self) -> GamePort:
        """The game interface, as a game's driver sees it."""
        return GamePort(self._knob)

    def unplug(self) -> None:
        """Pull the plug. As with hardware the knob must be opened again."""
        self._knob.unplug()

    def set_emergency_stop(self, *, pressed: bool) -> None:
        """Press or release the emergency stop."""
        self._knob.set_emergency_stop(checks.flag("pressed", pressed))

    def set_actuator_fault(self, *, present: bool) -> None:
        """Make the power stage report an error, or stop doing so."""
        self._knob.set_actuator_fault(checks.flag("present", present))

    def freeze_encoder(self, *, frozen: bool) -> None:
        """Let the encoder's counter stand still."""
        self._knob.freeze_encoder(checks.flag("frozen", frozen))

    def jump_encoder(self, *, counts: int) -> None:
        """Make the encoder's counter wrong from now on."""
        self._knob.jump_encoder(checks.whole("counts", counts, -(2**31), 2**31 - 1))

    def skip_ticks(self, *, count: int) -> None:
        """Let the control loop come that many ticks late."""
        self._knob.skip_ticks(checks.whole("count", count, 0, 2**32 - 1))

    def set_link_faults(
        self,
        *,
        drop_output: float = 0.0,
        corrupt_output: float = 0.0,
        drop_input: float = 0.0,
        corrupt_input: float = 0.0,
    ) -> None:
        """Damage reports on the way, each with a probability. Output is from host to device."""
        self._knob.set_link_faults(
            drop_output=checks.number("drop_output", drop_output),
            corrupt_output=checks.number("corrupt_output", corrupt_output),
            drop_input=checks.number("drop_input", drop_input),
            corrupt_input=checks.number("corrupt_input", corrupt_input),
        )

    def cut_power_in_next_save(self, *, after_bytes: int) -> None:
        """Make the device vanish in the middle of its next save."""
        self._knob.cut_power_in_next_save(checks.whole("after_bytes", after_bytes, 0, 2**32 - 1))


class Knob:
    """An open knob, made by `torsio.open`. Use it in a ``with`` statement.

    Every method may be called from any thread, and every method that waits lets other threads run
    and can be interrupted with Ctrl-C. Besides what is named, methods raise `Disconnected` once the
    device is unplugged, `Closed` after `close`, and `Timeout` when the device does not answer.

    Durations count in the device's time: the wall clock, or the virtual clock of an emulated device
    that is not paced.
    """

    def __init__(self, knob: _torsio.Knob) -> None:
        self._knob = knob
        self._info = DeviceInfo(**knob.info())

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
        return f"<torsio.Knob {self._info.path!r} {state}>"

    def close(self) -> None:
        """Disarm, unless told to be autonomous, and let go. Closing twice is fine."""
        self._knob.close()

    @property
    def is_open(self) -> bool:
        """False once closed."""
        return self._knob.is_open

    # What it is -----------------------------------------------------------------------------

    @property
    def info(self) -> DeviceInfo:
        """Who the device is."""
        return self._info

    @property
    def state(self) -> State:
        """As last heard of; costs nothing."""
        return self._knob.state

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

    # What it does ---------------------------------------------------------------------------

    def arm(self) -> None:
        """Torque on. Raises `Refused` while a fault is latched."""
        self._knob.arm()

    def disarm(self) -> None:
        """Torque off; the scene stays."""
        self._knob.disarm()

    def stop(self) -> None:
        """Torque off, and the scene is emptied."""
        self._knob.stop()

    def zero(self) -> None:
        """Make this position angle 0. Raises `Refused` unless disarmed."""
        self._knob.zero()

    def relax(self) -> None:
        """Tell the sensor that the shaft is relaxed now. Raises `Refused` unless disarmed."""
        self._knob.relax()

    def clear_fault(self) -> None:
        """Forget latched faults. Raises `Refused` while their cause is there."""
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
        """
        if isinstance(scene, Iterable) and not isinstance(scene, Sized):
            # It may have no end: one effect too many is enough to refuse it.
            scene = list(islice(scene, _MAX_EFFECTS + 1))
        self._knob.play(scene)

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

    def configure(self, config: ActuatorConfig | BoardConfig | ControlConfig | GameConfig) -> None:
        """Set a configuration while disarmed. Another encoder's also empties the scene.

        A board's takes effect when the device starts the next time, if it was saved.

        Raises
        ------
        InvalidArgument
            Names field, value and range.
        Refused
            Unless disarmed.
        """
        if isinstance(config, ActuatorConfig):
            self._knob.set_actuator_config(config)
        elif isinstance(config, ControlConfig):
            self._knob.set_control_config(config)
        elif isinstance(config, BoardConfig):
            self._knob.set_board_config(config)
        elif isinstance(config, GameConfig):
            self._knob.set_game_config(config)
        else:
            raise TypeError(f"not a configuration: {config!r}")

    def save(self) -> None:
        """Keep the configuration over power-off. Returns when it is safe."""
        self._knob.save()

    def load_defaults(self) -> None:
        """Take the configuration of a new device. Raises `Refused` unless disarmed."""
        self._knob.load_defaults()

    # Telemetry ------------------------------------------------------------------------------

    def start_telemetry(self, *, rate_hz: float | None = None) -> float:
        """Start telemetry, or change its rate, and forget what was not read.

        Parameters
        ----------
        rate_hz
            Highest rate wanted, up to 4,000 Hz. None takes the highest up to 3,600 Hz, which leaves
            the cable room for answers; above that samples are lost if commands are sent all the
            time.

        Returns
        -------
        float
            The true rate: the device sends every n-th control tick.
        """
        return self._knob.start_telemetry(
            0.0 if rate_hz is None else checks.number("rate_hz", rate_hz)
        )

    def stop_telemetry(self) -> None:
        """Stop telemetry."""
        self._knob.stop_telemetry()

    def read(self, *, max_samples: int = 4096, timeout_s: float = 1.0) -> Record:
        """Take samples, oldest first; wait until there is one or the time is over.

        Returns
        -------
        Record
            Of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,), 0 <= n <= max_samples.
        """
        return self._knob.read(
            checks.whole("max_samples", max_samples, 0, _MAX_SAMPLES),
            checks.number("timeout_s", timeout_s),
        )

    def record(self, *, duration_s: float, rate_hz: float | None = None) -> Record:
        """Let time pass and give every sample of that span.

        Starts telemetry if it does not run, or if a rate is given.

        Returns
        -------
        Record
            Of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,).
        """
        duration_s = checks.number("duration_s", duration_s)
        if rate_hz is not None:
            self.start_telemetry(rate_hz=rate_hz)
        return self._knob.record(duration_s)

    def telemetry(
        self,
        *,
        duration_s: float | None = None,
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
        if rate_hz is not None:
            rate_hz = checks.number("rate_hz", rate_hz)
        max_samples = checks.whole("max_samples", max_samples, 1, _MAX_SAMPLES)
        timeout_s = checks.number("timeout_s", timeout_s, _SHORTEST_TIMEOUT_S, _LONGEST_S)
        return self._telemetry(duration_s, rate_hz, max_samples, timeout_s)

    def _telemetry(
        self, duration_s: float | None, rate_hz: float | None, max_samples: int, timeout_s: float
    ) -> Iterator[Record]:
        rate_hz = self.start_telemetry(rate_hz=rate_hz)
        left = None if duration_s is None else round(duration_s * rate_hz)
        while left is None or left > 0:
            size = max_samples if left is None else min(max_samples, left)
            samples = self._knob.read(size, timeout_s)
            if len(samples) == 0:
                raise Timeout(f"no telemetry for {timeout_s} s")
            if left is not None:
                left -= len(samples)
            yield samples

    # Waiting --------------------------------------------------------------------------------

    def sleep(self, duration_s: float) -> None:
        """Let time pass."""
        self._knob.sleep(checks.number("duration_s", duration_s))

    def wait_for(self, state: State, *, timeout_s: float = 1.0) -> bool:
        """Wait until the device is in a state. Returns False if it is not so in time."""
        checks.text("state", state)
        return self._knob.wait_for(state, checks.number("timeout_s", timeout_s))


def open(
    selector: str = "",
    *,
    seed: int = 0,
    control_rate_hz: float = 1000.0,
    plant: PlantParams | None = None,
    hand: Hand | None = None,
    serial: str = "",
    actuator: ActuatorConfig | None = None,
    control: ControlConfig | None = None,
    game: GameConfig | None = None,
    paced: bool = False,
    log_truth: bool = False,
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
    command_timeout_s
        Longest wait for an answer of the device.
    ring_samples
        Telemetry kept until it is read; the oldest goes first.
    seed
        Of everything random in an emulated device; likewise emulated only are those below.
    control_rate_hz
        1,000 to 20,000.
    plant, hand
        The simulated actuator and who holds it.
    serial
        At most 16 ASCII characters.
    actuator, control, game
        Configuration at power-up, in place of the defaults.
    paced
        False: time is virtual and passes only inside calls that wait, as fast as it can be
        computed; the same calls with the same seed give the same bytes. True: the wall clock's.
    log_truth
        Record what no sensor sees, for `Emulator.truth`.

    Raises
    ------
    DeviceNotFound, PermissionDenied, DeviceBusy, ProtocolMismatch, InvalidArgument
    """
    for name, value, wanted in (
        ("plant", plant, PlantParams),
        ("actuator", actuator, ActuatorConfig),
        ("control", control, ControlConfig),
        ("game", game, GameConfig),
    ):
        checks.kind(name, value, (wanted, type(None)), f"a torsio.{wanted.__name__} or None")
    return Knob(
        _torsio.open_knob(
            checks.text("selector", selector),
            seed=checks.whole("seed", seed, 0, 2**64 - 1),
            control_rate_hz=checks.number("control_rate_hz", control_rate_hz),
            plant=plant,
            hand=hand,
            serial=checks.text("serial", serial),
            actuator=actuator,
            control=control,
            game=game,
            paced=checks.flag("paced", paced),
            log_truth=checks.flag("log_truth", log_truth),
            command_timeout_s=checks.number("command_timeout_s", command_timeout_s),
            ring_samples=checks.whole("ring_samples", ring_samples, 1, _MAX_SAMPLES),
        )
    )


def list_devices() -> list[ListedDevice]:
    """List all knobs that are plugged in, and the emulated one, which is always last."""
    return [ListedDevice(**device) for device in _torsio.list_devices()]
