"""Each board's reaction when one of its parts fails, as JSON lines.

``./dev bench guards`` runs each board's real firmware in its emulated chip, has it push into a wall
with all that its motor may, and then has one of the dangers of ``tests/board/dangers.py`` happen.
A line tells after how long motor and brake were off in the worst of 16 moments, to 0.05 ms below
1 ms and to 0.25 ms above, and which fault is latched or which cause of a restart is told. It also
tells how many amperes were in the motor of the same firmware with that guard switched off
(``tests/board/unguarded.py``), when it had long been off with it.

For the encoder's wires and for wrong signs the board is coupled to the plant. A hand leans on a
wall with 50 mN m, wires of the encoder are cut, and the hand lets go; or a hand touches a knob
whose encoder or motor has the wrong sign, armed in the middle of a spring with the parts not
confirmed; or the current sensor's zero moves while nobody holds the armed knob. These lines also
tell, to 4 ms, how far and how fast the knob turned until the outputs were off, and what it reached;
and how fast without the guard, in 0.3 s.

For a supply of twice, coupled as well, the knob is pressed into the wall; these lines tell the
brake's coil's current too.

The last lines are of what keeps a board from arming or from much, and of what ends in no fault: a
current sensor's zero and range, parts that nobody has confirmed, a winding and a coil that get warm
(also when their currents are not held down, and when then nothing says that they are too hot), for
how long at most a busy main loop leaves the watchdog without food, a configuration of other
firmware, a bridge that wakes up, a supply that was too low for a moment.

A supply that is another than the configured one happens to two boards: to one that has no divider,
and to one that measures it.

Arguments are names of boards. It takes three minutes for each.
"""

from __future__ import annotations

import json
import random
import sys
from typing import Any

from tests.board import felt
from tests.board.dangers import (
    DANGERS,
    DIVIDER,
    LITTLE,
    PLENTY,
    PUSHED_A,
    RATED_A,
    SUPPLY_DANGERS,
    Danger,
    arm_while_bridge_wakes,
    endure,
    hold_warm,
    keep_busy,
    named,
    push,
    react,
    start_with_other_layout,
)
from tests.board.pico import MODELS, EmulatedPico, choose, enumerated, rewired
from tests.board.run_aways import RUN_AWAYS
from tests.board.unguarded import image, take_away, unguarded


def _tell(board: str, danger: str, **line: Any) -> None:
    print(json.dumps({"board": board, "danger": danger, **line}), flush=True)


def _react(board: str, danger: Danger, pico: EmulatedPico, bare: EmulatedPico) -> None:
    # How long it takes depends on the moment at which it happens.
    moments_ms = random.Random(danger.name)
    found = [react(pico, danger, moments_ms.uniform(0.0, 8.0)) for _ in range(16)]
    (told,) = {told for _, told in found}
    left = endure(bare, danger)
    _tell(
        board,
        danger.name,
        off_ms=round(max(passed_ms for passed_ms, _ in found), 2),
        tells=told,
        without_guard_a=None if left is None else _short(left.amperes),
    )


def _run_aways(board: str) -> None:
    for danger in RUN_AWAYS:
        with danger.bench(guarded=True) as bench:
            guarded = danger.begin(bench)
        with danger.bench(guarded=False) as bench:
            bare = danger.begin(bench)
        _tell(
            board,
            danger.name,
            off_ms=None if guarded.off_s is None else round(1e3 * guarded.off_s),
            tells=named(guarded.faults),
            moved_rad=_short(guarded.moved_rad),
            fastest_rad_s=_short(guarded.fastest_rad_s),
            without_guard_rad_s=float(f"{bare.fastest_rad_s:.3g}"),
        )


def _supplies(board: str) -> None:
    for name, supply_v, confirmed in (
        ("parts not confirmed, supply right", 12, False),
        ("parts not confirmed, supply of twice", 24, False),
        ("parts confirmed, 30 mN m of motor, supply of twice", 24, True),
    ):
        found = felt.press_with_supply(board, supply_v, confirmed=confirmed)
        _tell(
            board,
            name,
            off_ms=None if found.off_s is None else round(1e3 * found.off_s),
            tells=named(found.faults),
            coil_a=round(found.coil_a, 3),
        )


def _before_arming(board: str) -> None:
    def line(danger: str, steps: int, **changes: float) -> None:
        found = []
        for firmware, guards in ((None, ()), (image(), ("sensor's zero",))):
            with rewired(firmware, "board_config", **changes) as pico:
                pico.do("motor", zero=steps)
                pico.power_cycle()
                if guards:
                    take_away(pico, *guards)
                pico.enumerate()
                found.append((named(pico.get("health")["faults"]), pico.command("arm")))
        (tells, arming), (_, bare) = found
        _tell(board, danger, tells=tells, arming=arming, without_guard_arming=bare)

    line("current sensor's zero at 300 steps of 4096", 300)
    line("trip level beyond the current sensor's range", 2048, current_sense_v_per_a=1.0)
    with rewired(**DIVIDER) as pico:
        pico.do("motor", supply=24)
        pico.run(3)
        tells, arming = named(pico.get("health")["faults"]), pico.command("arm")
    _tell(board, "supply of twice, with the divider, disarmed", tells=tells, arming=arming)


def _not_confirmed(board: str) -> None:
    found = []
    for firmware in (None, image()):
        with enumerated(firmware) as pico:
            if firmware:
                take_away(pico, "timid")
            assert pico.set("board_config", confirmed="off")["status"] == 0
            pico.arm_at_wall(stiffness_nm_per_rad=20.0)
            pico.turn(60, period_us=500)  # slower than what stops it
            pico.run(10)
            found.append(round(abs(pico.do("amperes")), 1))
    _tell(board, "parts not confirmed", motor_a=found[0], without_guard_a=found[1])


def _busy(board: str) -> None:
    with enumerated() as pico:
        walls = 6 if pico.model.name == "pico" else 16
        starved_ms = keep_busy(pico, walls)
        state = pico.get("health")["state"]
    _tell(
        board, f"main loop busy, {walls} walls", state=state, watchdog_waits_ms=_short(starved_ms)
    )


def _short(value: float) -> float:
    return float(f"{value:.2g}")


def _warm(board: str) -> None:
    with rewired(**LITTLE["motor"] | LITTLE["coil"]) as pico:
        warm = hold_warm(pico, 250)
    for part, rated_a in RATED_A.items():
        with rewired(image(), **PLENTY | LITTLE[part]) as pico:
            take_away(pico, f"{part}'s heat")
            free = hold_warm(pico, 250)
            tells = named(pico.get("health")["faults"])
        with rewired(image(), **PLENTY | LITTLE[part]) as pico:
            take_away(pico, f"{part}'s heat", "temperature")
            bare = hold_warm(pico, 250)
        _tell(
            board,
            f"{part} gets {PUSHED_A[part]:g} A, {rated_a:g} A being allowed for ever",
            amperes_after_ms={
                ms: float(f"{warm.amperes[part][ms // 5 - 1]:.2g}")
                for ms in (50, 100, 150, 200, 250)
            },
            not_held_down_off_ms=free.off_ms,
            tells=tells,
            without_guards_a=_short(bare.amperes[part][-1]),
        )


def _no_faults(board: str) -> None:
    with enumerated() as pico:
        found = {ms: named(arm_while_bridge_wakes(pico, ms)) for ms in (0.8, 1.3)}
        _tell(board, "bridge says for so many ms of its waking that it does not work", tells=found)
        assert pico.command("clear_fault") == "ok"
        push(pico)
        pico.do("power_cycle", **({"brown_out": True} if board == "pico2" else {}))
        pico.enumerate()
        told = pico.get("health")["reset_cause"]
        _tell(board, "supply of the board too low for a moment", tells=told)
        pico.set("board_config", motor_pin=18, confirmed="on")
        start_with_other_layout(pico)
        config = pico.get("board_config")
        kept = {name: config[name] for name in ("motor_pin", "confirmed")}
        _tell(board, "configuration of other firmware", board_config=kept)


def main(boards: list[str]) -> None:
    """Print the lines of each board."""
    for board in boards or MODELS:
        choose(board)
        with enumerated() as pico, unguarded() as bare:
            for danger in DANGERS:
                _react(board, danger, pico, bare)
        with rewired(**DIVIDER) as pico, rewired(image(), **DIVIDER) as bare:
            for danger in SUPPLY_DANGERS:
                _react(board, danger, pico, bare)
        _run_aways(board)
        _supplies(board)
        _before_arming(board)
        _not_confirmed(board)
        _warm(board)
        _busy(board)
        _no_faults(board)


if __name__ == "__main__":
    main(sys.argv[1:])
