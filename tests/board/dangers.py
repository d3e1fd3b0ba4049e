"""What can go wrong with a board's parts: how it is brought about, and what the board does then."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tests.board.pico import EmulatedPico, confirm

FAULTS = (
    *("emergency_stop", "over_speed", "encoder", "actuator", "overrun", "numeric"),
    *("current_sensor", "winding"),
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
        Makes it so, on a board that pushes with all its motor may.
    tells
        The fault that is latched, or the cause of the restart.
    within_ms
        So soon everything must be off; None: as soon as the board's watchdog has it.
    mend
        Makes it good again.
    restarts
        It takes a restart to be so.
    """

    name: str
    happen: Callable[[EmulatedPico], object]
    tells: str
    within_ms: float | None
    mend: Callable[[EmulatedPico], object] = lambda board: board.do("motor")
    restarts: bool = False

    def __str__(self) -> str:
        return self.name

    def limit_ms(self, board: EmulatedPico) -> float:
        """How soon everything must be off; the watchdog may be fed once more before it waits."""
        return board.model.watchdog_ms + 0.5 if self.within_ms is None else self.within_ms


def _motor(**changes: float) -> Callable[[EmulatedPico], object]:
    return lambda board: board.do("motor", **changes)


def _pin(pin: int, high: bool) -> Callable[[EmulatedPico], object]:
    return lambda board: board.do("pin", pin=pin, high=high)


def _end_stack(board: EmulatedPico) -> None:
    board.do("poke", address=STACK_ENDS_AT[board.model.name], word=0)


DANGERS = (
    Danger("emergency stop pressed, or its wire cut", _pin(11, high=True), "emergency_stop", 0.3,
           _pin(11, high=False)),
    Danger("bridge reports a fault", _pin(12, high=False), "actuator", 0.3, _pin(12, high=True)),
    Danger("3.2 A flow, the limit being 2", _motor(sensor_amperes=3.2), "actuator", 0.6),
    Danger("current sensor dead", _motor(sensor_amperes=0.0), "winding", 10),
    Danger("current sensor stuck at 1 A", _motor(sensor_amperes=1.0), "winding", 10),
    Danger("current sensor stuck at -0.5 A", _motor(sensor_amperes=-0.5), "winding", 10),
    Danger("current sensor shows half", _motor(voltsPerAmpere=0.1), "winding", 125,
           _motor(voltsPerAmpere=0.2)),
    Danger("current sensor shows twice", _motor(voltsPerAmpere=0.4), "winding", 125,
           _motor(voltsPerAmpere=0.2)),
    Danger("supply missing", _motor(supply=0), "winding", 10, _motor(supply=12)),
    Danger("supply of a quarter", _motor(supply=3), "winding", 10, _motor(supply=12)),
    Danger("supply of half", _motor(supply=6), "winding", 125, _motor(supply=12)),
    Danger("supply of twice", _motor(supply=24), "winding", 125, _motor(supply=12)),
    Danger("encoder jumps, 10 counts in a microsecond",
           lambda board: board.turn(1200, period_us=0.1), "encoder", 0.3),
    Danger("program hangs, interrupts on", lambda board: board.do("hang", masked=False),
           "watchdog", None, restarts=True),
    Danger("program hangs, interrupts off", lambda board: board.do("hang", masked=True),
           "watchdog", None, restarts=True),
    Danger("control interrupt stops", lambda board: board.do("stop_ticks"), "watchdog", None,
           restarts=True),
    Danger("hard fault of the processor", lambda board: board.do("hard_fault"), "hard_fault", 0.1,
           restarts=True),
    Danger("stack used up", _end_stack, "stack", 0.3, restarts=True),
)  # fmt: skip


def push(board: EmulatedPico) -> None:
    """Arm, and go so deep into a wall that the motor gives all it may."""
    assert board.set("control_config", passive_ramp_s=0.005)["status"] == 0
    board.arm_at_wall()
    board.turn(300)
    board.run(8)
    assert board.motor() is not None


def time_until_off_ms(board: EmulatedPico, within_ms: float) -> float:
    """How long motor and brake stay on from now."""
    passed_ms = 0.0
    while board.motor() is not None or board.brake() is not None:
        assert passed_ms < within_ms, "the outputs stay on"
        step_ms = FINE_MS if passed_ms < 1 else COARSE_MS
        board.run(step_ms)
        passed_ms += step_ms
    return passed_ms


def react(board: EmulatedPico, danger: Danger) -> tuple[float, str]:
    """Have it happen to a board that pushes; tell after how many ms it is off, and what it says.

    It is mended then, so that the board is as it was.
    """
    push(board)
    danger.happen(board)
    passed_ms = time_until_off_ms(board, danger.limit_ms(board) + 5)
    if danger.restarts:
        board.run(board.model.watchdog_ms + 2)
        board.enumerate()
        confirm(board)
        return passed_ms, str(board.get("health")["reset_cause"])
    health = board.get("health")
    assert health["state"] == "fault"
    danger.mend(board)
    board.turn(-board.get("clock")["position_counts"], period_us=2)
    board.run(1)
    assert board.command("clear_fault") == "ok"
    assert board.get("health")["state"] == "disarmed"
    found = [name for n, name in enumerate(FAULTS) if health["faults"] >> n & 1]
    return passed_ms, ", ".join(found)
