"""The file that ships does, tick by tick, what the same sources do on this machine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.board.pico import EmulatedPico, confirm
from tests.board.tracing import Trace, again, traced
from tests.python import wire

SAMPLES_PER_REPORT = 4
TURN = 1 << 32
LIFE = {"attack_s": 0.01, "attack_level": 0.25, "duration_s": 0.05, "fade_s": 0.02}
# Each law with every kind of effect, all within the turn below.
SCENES: dict[str, dict[str, dict[str, Any]]] = {
    "paper": {
        "wall": {"stiffness_nm_per_rad": 2.0, "damping_nm_s_per_rad": 1e-3},
        "damper": {"damping_nm_s_per_rad": 2e-3, "torque_limit_nm": 0.05},
        "inertia": {"inertia_kg_m2": 2e-5, "torque_limit_nm": 0.05},
    },
    "compensated": {
        "spring": {"stiffness_nm_per_rad": 0.7, "deadband_rad": 0.01, "torque_limit_nm": 0.06},
        "friction": {"torque_nm": 0.02, "stiffness_nm_per_rad": 1.5},
        "constant": {"torque_nm": 0.01, "timing": LIFE},
    },
    "parallel": {
        "detents": {"per_turn_q32": 24 * TURN, "torque_nm": 0.03, "width": 0.5},
        "ramp": {"start_torque_nm": -0.02, "end_torque_nm": 0.04, "timing": LIFE},
    },
    "motor_only": {
        "texture": {"grains_per_turn": 200, "torque_nm": 0.02, "grain": "noise", "seed": 42},
        "end_stops": {"upper_turns_q32": TURN // 8, "stiffness_nm_per_rad": 1.0},
        "curve": {"span_turns_q32": TURN // 2, "ends": "repeat", "points": 8},
    },
    "calibrated": {
        "wall": {"side": "above", "stiffness_nm_per_rad": 9.0},
        "periodic": {
            **{"waveform": "sine", "amplitude_nm": 0.02, "frequency_hz": 60.0, "timing": LIFE}
        },
        "impact": {
            **{"strength_nm_s_per_rad": 2e-3, "frequency_hz": 300.0, "decay_s": 5e-3},
            **{"pulse_nm_s_per_rad": 1e-3, "pulse_s": 5e-3, "torque_limit_nm": 0.05},
        },
    },
}


def _values(report: str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return all fields of a report: those that are not told are zero."""
    _, values = wire.decode(bytes([wire.REPORTS[report].id]).ljust(wire.REPORT_SIZE, b"\0"))
    for name, change in changes.items():
        values[name] = values[name] | change if isinstance(change, dict) else change
    return {name: value for name, value in values.items() if name not in ("target", "sequence")}


def _turn(pico: EmulatedPico, random: np.random.Generator, edges: int) -> None:
    """Turn the knob to and fro, as slowly and as quickly as hands do."""
    while edges > 0:
        step = int(random.integers(1, 120))
        pico.turn(int(random.choice([-1, 1])) * step, float(random.uniform(15, 120)))
        edges -= step
        pico.listen(12, within_ms=0.3)  # telemetry that nobody fetches is dropped, sooner or later


def _play(pico: EmulatedPico, law: str, effects: dict[str, dict[str, Any]]) -> None:
    control = {"law": law, "watchdog_s": 5.0, "free_assist_nm": 3e-3}
    assert pico.set("control_config", **control)["status"] == 0
    assert pico.send("curve_points", points=8, torque_nm=[*np.arange(8) * 2e-3 - 7e-3, *5 * [0.0]],
                     first_point=0)["status"] == 0  # fmt: skip
    for slot, (kind, changes) in enumerate(effects.items()):
        assert pico.send(kind, slot=slot, **_values(kind, changes))["status"] == 0
    assert pico.command("zero") == "ok"
    assert pico.command("arm") == "ok"
    assert pico.send("commit", active=(1 << len(effects)) - 1)["status"] == 0


def _live(pico: EmulatedPico) -> None:
    """Render, feel, lose the host, stop in an emergency, and go on."""
    random = np.random.default_rng(3)
    brake = {"brake_hysteresis_nm": 1e-3, "brake_inertia_kg_m2": 5e-6}
    assert pico.set("actuator_config", **brake)["status"] == 0
    confirm(pico)
    assert pico.send("stream", decimation=5, prompt="off")["status"] == 0
    for law, effects in SCENES.items():
        _play(pico, law, effects)
        _turn(pico, random, 500)
        if law == "compensated":
            pico.emergency_stop(True)
            _turn(pico, random, 20)
            pico.emergency_stop(False)
            assert pico.command("clear_fault") == "ok"
        elif law == "motor_only":
            # From the host's own loop, which falls silent.
            values = {"torque_nm": 0.01, "stiffness_nm_per_rad": 0.4, "deadline_s": 5e-3}
            pico.post("local_model", **_values("local_model", values))
            _turn(pico, random, 100)
        if law != "compensated":
            assert pico.command("disarm") == "ok"


@pytest.fixture(scope="module")
def lives(_model: None) -> tuple[Trace, Trace]:
    """Return what a board's file did, and what this machine makes of the same."""
    with EmulatedPico() as pico:
        pico.boot()
        with traced(pico) as trace:
            pico.enumerate()
            _live(pico)
        return trace, again(pico, trace)


def test_scenes_have_every_kind_of_effect() -> None:
    played = {kind for effects in SCENES.values() for kind in effects}
    kinds = {name for name, report in wire.REPORTS.items() if "target.slot" in report.paths}
    assert played == kinds


def test_every_tick_puts_out_the_same_bits(lives: tuple[Trace, Trace]) -> None:
    board, own = lives
    assert len(board.outputs) > 1000
    assert len(set(board.outputs)) > len(board.outputs) / 4, "most of it is at rest"
    pairs = zip(board.outputs, own.outputs, strict=True)
    different = [tick for tick, (there, here) in enumerate(pairs) if there != here]
    assert not different, f"{len(different)} of {len(board.outputs)} ticks, first {different[0]}"


def _reports(life: Trace, kind: str) -> list[bytes]:
    reports = [bytes.fromhex(report) for report in life.reports]
    return [report for report in reports if report[0] == wire.REPORTS[kind].id]


@pytest.mark.parametrize("kind", ["acknowledgement", "event"])
def test_every_answer_and_event_has_the_same_bytes(lives: tuple[Trace, Trace], kind: str) -> None:
    # A tick may come while the main loop looks for the next report, so kinds may change places.
    board, own = lives
    assert _reports(board, kind)
    assert _reports(board, kind) == _reports(own, kind)


def test_every_sample_has_the_same_values(lives: tuple[Trace, Trace]) -> None:
    def samples(life: Trace) -> list[Any]:
        found = []
        for report in _reports(life, "telemetry"):
            _, values = wire.decode(report)
            for n in range(values["axis_samples"] >> 4):
                sample = values["sample"][n]
                counts = values["base_counts"] + sample.pop("offset_counts")
                found.append((values["tick"] + n * values["decimation"], counts, sample))
        return found

    board, own = lives
    there, here = samples(board), samples(own)
    assert len(there) > len(board.outputs) / 10
    # A tick may come while the last report is put together: the other side has it in the next one.
    together = min(len(there), len(here))
    assert there[:together] == here[:together]
    assert max(len(there), len(here)) - together <= SAMPLES_PER_REPORT
