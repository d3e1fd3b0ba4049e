"""Faults of a board's parts: how a test makes them, and the board's reaction."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tests.board.pico import MS, EmulatedPico, confirm
from tests.board.unguarded import start_without, take_away

FAULTS = (
    *("emergency_stop", "over_speed", "encoder", "actuator", "overrun", "numeric"),
    *("current_sensor", "winding", "temperature", "supply"),
)
STACK_ENDS_AT = {"pico": 0x20041000, "pico2": 0x20081000}
FINE_MS, COARSE_MS = 0.05, 0.25


@dataclass(frozen=True)
class Danger:
    """One of them.

    Attributes
    ----------
    name
        What has happened, for a table.
    happen
        Makes it so, on a board that pushes with all its motor may, or rests.
    guard
        What stands against it, by its name in ``unguarded.GUARDS``.
    tells
        The fault that is latched, or the cause of the restart.
    within_ms
        So soon everything must be off; None: as soon as the board's watchdog has it.
    mend
        Makes it good again.
    restarts
        It takes a restart to be so.
    rests
        It happens to a board that is armed and asks for nothing.
    behind
        The guard behind it, which must be away as well to see what is left.
    mended_after_ms
        When the board believes that it is mended.
    """

    name: str
    happen: Callable[[EmulatedPico], object]
    guard: str
    tells: str
    within_ms: float | None
    mend: Callable[[EmulatedPico], object] = lambda board: board.do("motor")
    restarts: bool = False
    rests: bool = False
    behind: str = ""
    mended_after_ms: float = 1.0

    def __str__(self) -> str:
        return self.name

    def limit_ms(self, board: EmulatedPico) -> float:
        """How soon everything must be off; the watchdog may be fed once more before it waits."""
        return board.model.watchdog_ms + 0.5 if self.within_ms is None else self.within_ms


SENSOR_STEPS_PER_A = 0.2 / 3.3 * 4096


def _motor(**changes: float) -> Callable[[EmulatedPico], object]:
    return lambda board: board.do("motor", **changes)


def _pin(pin: int, high: bool) -> Callable[[EmulatedPico], object]:
    return lambda board: board.do("pin", pin=pin, high=high)


def _end_stack(board: EmulatedPico) -> None:
    board.do("poke", address=STACK_ENDS_AT[board.model.name], word=0)


DANGERS = (
    Danger("emergency stop pressed, or its wire cut", _pin(11, high=True),
           "emergency stop", "emergency_stop", 0.3, _pin(11, high=False)),
    Danger("bridge reports a fault", _pin(12, high=False),
           "bridge's word", "actuator", 0.3, _pin(12, high=True)),
    Danger("3.2 A flow, the limit being 2", _motor(sensor_amperes=3.2),
           "over-current", "actuator", 0.6, behind="winding"),
    Danger("current sensor dead: 0 V", _motor(sensor_amperes=-100.0),
           "over-current", "actuator", 0.6, behind="winding"),
    Danger("current sensor saturated: 3.3 V", _motor(sensor_amperes=100.0),
           "over-current", "actuator", 0.6, behind="winding"),
    Danger("current sensor stuck at its zero", _motor(sensor_amperes=0.0),
           "winding", "winding", 10),
    Danger("current sensor stuck at 1 A", _motor(sensor_amperes=1.0),
           "winding", "winding", 10),
    Danger("current sensor stuck at -0.5 A", _motor(sensor_amperes=-0.5),
           "winding", "winding", 10),
    Danger("current sensor's zero moves by 0.25 A", lambda board: shift_zero(board, 0.25),
           "winding", "winding", 80, rests=True),
    Danger("current sensor's zero moves by 0.8 A", lambda board: shift_zero(board, 0.8),
           "winding", "winding", 20, rests=True),
    Danger("current sensor shows half", _motor(voltsPerAmpere=0.1),
           "winding", "winding", 125, _motor(voltsPerAmpere=0.2)),
    Danger("current sensor shows twice", _motor(voltsPerAmpere=0.4),
           "winding", "winding", 125, _motor(voltsPerAmpere=0.2)),
    Danger("supply missing", _motor(supply=0), "winding", "winding", 10, _motor(supply=12)),
    Danger("supply of a quarter", _motor(supply=3), "winding", "winding", 10, _motor(supply=12)),
    Danger("supply of half", _motor(supply=6), "winding", "winding", 125, _motor(supply=12)),
    Danger("supply of twice", _motor(supply=24), "winding", "winding", 125, _motor(supply=12)),
    Danger("encoder jumps, 10 counts in a microsecond",
           lambda board: board.turn(1200, period_us=0.1), "jumps", "encoder", 0.3),
    Danger("encoder: both channels change at once, 4 times",
           lambda board: board.slip(4, period_us=200), "loose plug", "encoder", 0.3),
    Danger("program hangs, interrupts on", lambda board: board.do("hang", masked=False),
           "watchdog", "watchdog", None, restarts=True),
    Danger("program hangs, interrupts off", lambda board: board.do("hang", masked=True),
           "watchdog", "watchdog", None, restarts=True),
    Danger("control interrupt hangs, anywhere in its tick",
           lambda board: board.do("hang", inside_us=2),
           "watchdog", "watchdog", None, restarts=True),
    Danger("control interrupt stops", lambda board: board.do("stop_ticks"),
           "ticks counted", "watchdog", None, restarts=True),
    Danger("hard fault of the processor", lambda board: board.do("hard_fault"),
           "power cut", "hard_fault", 0.1, restarts=True),
    Danger("stack used up", _end_stack, "stack's mark", "stack", 0.3, restarts=True),
)  # fmt: skip


SUPPLY_RETURNS_MS = 55.0
# The board has a divider at its supply, which acts before the winding's guard.
SUPPLY_DANGERS = tuple(
    Danger(f"{name}, with the divider", _motor(supply=supply_v), "supply", "supply", 2.5,
           _motor(supply=12), behind="winding",
           mended_after_ms=SUPPLY_RETURNS_MS)
    for name, supply_v in (
        ("supply missing", 0), ("supply of a quarter", 3), ("supply of half", 6),
        ("supply of twice", 24),
    )
)  # fmt: skip
DIVIDER: dict[str, Any] = {"supply_sense_pin": 27}


def shift_zero(board: EmulatedPico, amperes: float) -> None:
    """Have the current sensor show so much more from now on."""
    board.do("motor", zero=round(2048 + SENSOR_STEPS_PER_A * amperes))


def push(board: EmulatedPico, depth_counts: int = 300) -> None:
    """Arm, and go so deep into a wall that the motor gives all it may."""
    assert board.set("control_config", passive_ramp_s=0.005)["status"] == 0
    board.arm_at_wall()
    board.turn(depth_counts)
    board.run(8)
    assert board.motor() is not None


def time_until_off_ms(board: EmulatedPico, within_ms: float) -> float:
    """How long motor and brake stay on from now."""
    passed_ms = 0.0
    # All pins at once: a look may fall between the enable pin's going low and the last bridge's.
    while any(board.do("high_share", pins=[6, 7, 8, 9, 10])):
        assert passed_ms < within_ms, "the outputs stay on"
        step_ms = FINE_MS if passed_ms < 1 else COARSE_MS
        board.run(step_ms)
        passed_ms += step_ms
    return passed_ms


def settle(board: EmulatedPico, danger: Danger) -> None:
    """Mend it, so that the board is as it was, disarmed."""
    danger.mend(board)
    if board.get("health")["state"] == "armed":
        assert board.command("disarm") == "ok"
    board.turn(-board.get("clock")["position_counts"], period_us=2)
    board.run(danger.mended_after_ms)
    if board.get("health")["state"] == "fault":
        assert board.command("clear_fault") == "ok"
    assert board.get("health")["state"] == "disarmed"


def react(board: EmulatedPico, danger: Danger, pushed_ms: float = 0.0) -> tuple[float, str]:
    """Have it happen to a board that pushes; tell after how many ms it is off, and what it says.

    It happens when the board has pushed for so long. It is mended then, so that the board is as it
    was.
    """
    push(board, 0 if danger.rests else 300)
    board.run(pushed_ms)
    danger.happen(board)
    passed_ms = time_until_off_ms(board, danger.limit_ms(board) + 5)
    if danger.restarts:
        board.run(board.model.watchdog_ms + 2)
        board.enumerate()
        confirm(board)
        return passed_ms, str(board.get("health")["reset_cause"])
    health = board.get("health")
    assert health["state"] == "fault"
    settle(board, danger)
    return passed_ms, named(health["faults"])


def named(faults: int) -> str:
    """Give the faults of a health report by name."""
    return ", ".join(name for n, name in enumerate(FAULTS) if faults >> n & 1)


# Parts rated for so little current that they get warm within the test.
RATED_A, PUSHED_A = {"motor": 0.2, "coil": 6e-3}, {"motor": 1.7, "coil": 0.25}
TIME_CONSTANT_S = {"motor": 10.0, "coil": 100.0}
LITTLE: dict[str, dict[str, Any]] = {
    "motor": {"motor_current_continuous_a": 0.2},
    "coil": {"brake_continuous_percent": 2},
}
PLENTY: dict[str, Any] = {"motor_current_continuous_a": 2.0, "brake_continuous_percent": 100}


@dataclass(frozen=True)
class Warm:
    """The heat of a motor and a coil.

    Attributes
    ----------
    amperes
        Of each, every 5 ms until it was off.
    off_ms
        When it was off; None: not at all.
    """

    amperes: dict[str, list[float]]
    off_ms: float | None


def hold_warm(board: EmulatedPico, time_ms: float) -> Warm:
    """Push for so long with a host that is alive."""
    push(board)
    found: dict[str, list[float]] = {"motor": [], "coil": []}
    for n in range(round(time_ms / 5)):
        if n % 10 == 0:
            board.post("command", op="keep_alive")
        board.run(5)
        share = board.brake()
        if share is None:
            return Warm(found, 5.0 * (n + 1))
        found["motor"].append(abs(board.do("amperes")))
        found["coil"].append(share * 12 / 40)
    return Warm(found, None)


def foreseen(part: str, time_ms: float) -> tuple[list[float], float]:
    """Give what a part that warms up should get, every 5 ms, and when it would be at 145 degrees.

    The latter is without being held down. Copper that has so much above 25 degrees makes 0.393 %
    more heat a degree of what a current makes; its rated current makes 100 degrees.
    """
    rated_a, pushed_a, time_constant_s = RATED_A[part], PUSHED_A[part], TIME_CONSTANT_S[part]
    rise_k, found = 0.0, []
    hot_ms, hottest_k = 0.0, 0.0
    for n in range(round(time_ms / 0.1)):
        over = min(max((rise_k - 75) / 25, 0.0), 1.0)
        amperes = pushed_a if over == 0 else min(pushed_a, _most_a(part, over))
        if n % 50 == 49:
            found.append(amperes)
        rise_k += 1e-4 / time_constant_s * _warming(rise_k, amperes / rated_a)
        if hottest_k <= 120:
            hottest_k += 1e-4 / time_constant_s * _warming(hottest_k, pushed_a / rated_a)
            hot_ms += 0.1
    return found, hot_ms


def _most_a(part: str, over: float) -> float:
    peak_a = {"motor": 2.0, "coil": 0.3}[part]
    return peak_a + (RATED_A[part] - peak_a) * over


def _warming(rise_k: float, ratio: float) -> float:
    return 100 / 1.393 * ratio**2 * (1 + 3.93e-3 * rise_k) - rise_k


def keep_busy(board: EmulatedPico, walls: int) -> float:
    """Play so many walls, with a host that asks and writes on and on.

    Returns
    -------
    float
        For how many milliseconds at most nobody fed the watchdog.
    """
    wall = {"stiffness_nm_per_rad": 1.0, "damping_nm_s_per_rad": 1e-3}
    board.arm_at_wall(walls, **wall)
    board.turn(100, period_us=50)
    board.do("watch_feeding")
    for _ in range(6):
        board.post("command", op="keep_alive")
        for name in ("health", "ledger", "game_monitor", "clock", "board_config"):
            board.get(name)
        board.play_walls(walls, **wall)
    left_ns = float(board.status()["watchdog_least_left_ns"])
    return board.model.watchdog_ms - left_ns / MS


def start_with_other_layout(board: EmulatedPico) -> None:
    """Save, and start with that being of firmware with other reports: its mark differs."""
    board.do("erase_time", ns=MS)
    for _ in range(2):
        assert board.command("save") == "ok"
    for slot in (0, 1):
        at = board.model.slots_at + 4096 * slot
        saved = bytearray.fromhex(board.do("flash", address=at, size=512))
        saved[4] ^= 1
        saved[508:] = struct.pack("<I", zlib.crc32(saved[:508]))
        board.do("write_flash", address=at, data=saved.hex())
    board.power_cycle()
    board.enumerate()


def arm_while_bridge_wakes(board: EmulatedPico, waking_ms: float) -> int:
    """Arm, and have the bridge say for so long from then on that it does not work.

    Returns the faults that are latched a moment later.
    """
    board.post("command", op="arm")
    for _ in range(100):
        board.run(FINE_MS)
        if board.motor() is not None:
            break
    board.do("pin", pin=12, high=False)
    board.run(waking_ms)
    board.do("pin", pin=12, high=True)
    board.run(0.5)
    board.acknowledgement()
    return int(board.get("health")["faults"])


@dataclass(frozen=True)
class Left:
    """The outputs of a board without a guard, long after the guard would have acted."""

    motor_share: float
    """A share of the supply's voltage."""
    amperes: float


def endure(board: EmulatedPico, danger: Danger) -> Left | None:
    """Have it happen to a board of ``unguarded.py`` without the guard, for longer than it may take.

    It is mended and has its guard then. Returns None if everything was off, so that the guard was
    not what it takes.
    """
    guards = [name for name in (danger.guard, danger.behind) if name]
    if danger.restarts:
        start_without(board, *guards)
    take_away(board, *guards)
    push(board, 0 if danger.rests else 300)
    danger.happen(board)
    board.run(1.2 * danger.limit_ms(board) + 1)
    share = board.motor()
    left = None if share is None else Left(share, abs(board.do("amperes")))
    take_away(board)
    if danger.restarts:
        start_without(board)
    else:
        settle(board, danger)
    return left
