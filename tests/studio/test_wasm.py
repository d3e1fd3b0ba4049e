"""The emulated device in WebAssembly is the native one, bit for bit; and the page's codec."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

import torsio
from tests.python import wire
from torsio import emulator, protocol

FOLDER = Path(__file__).parent
MS = 1_000_000
PERIOD_NS = 250_000
PATH = [[0.0, 0.0], [0.2, 0.5], [0.3, 0.5], [0.5, -0.1]]
HAND = {"inertia_kg_m2": 2e-5, "stiffness_nm_per_rad": 0.8, "damping_nm_s_per_rad": 8e-3}


def _in_wasm(steps: list[list[Any]], *, period_ns: int = PERIOD_NS) -> dict[str, Any]:
    question = {"seed": 5, "controlPeriodNs": period_ns, "steps": steps}
    done = subprocess.run(
        ["node", FOLDER / "run_device.mjs"],
        input=json.dumps(question),
        capture_output=True,
        text=True,
        check=True,
    )
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def _from_now(device: emulator.EmulatedDevice, path: list[list[float]]) -> list[list[float]]:
    """Natively a path's times are the device's; in WebAssembly they begin when the hand does."""
    return [[1e-9 * device.time_ns + time_s, value] for time_s, value in path]


def _natively(steps: list[list[Any]]) -> dict[str, Any]:
    device = emulator.EmulatedDevice(seed=5, control_period_ns=PERIOD_NS, serial="BROWSER")
    out: dict[str, Any] = {"reports": [], "features": [], "truth": [], "refused": 0, "error": ""}
    for kind, *given in steps:
        if kind == "write":
            out["refused"] += not device.write(bytes.fromhex(given[0]))
        elif kind == "hold":
            path = _from_now(device, given[3])
            device.set_hand(torsio.ImpedanceHand(**HAND, intended_angle_rad=path))
        elif kind == "push":
            device.set_hand(torsio.TorqueHand(torque_nm=_from_now(device, given[0])))
        elif kind == "emergency stop":
            device.set_emergency_stop(given[0])
        elif kind == "set":
            out["features"].append(device.set_feature(bytes.fromhex(given[0]))[0] == 0)
        elif kind == "get":
            answer = device.get_feature(given[0])
            out["features"].append("" if answer is None else answer.hex())
        elif kind == "advance":
            device.advance(given[0])
            state = device.plant_state
            out["truth"].append(
                [state[name] for name in ("angle_rad", "brake_angle_rad", "speed_rad_s")]
            )
            while (report := device.read()) is not None:
                out["reports"].append(report.hex())
    out["timeNs"] = device.time_ns
    return out


def _session() -> list[list[Any]]:
    """A wall, detents and a texture, felt by a hand; then a weight, a fault and a configuration."""

    def write(name: str, **values: Any) -> list[list[Any]]:
        return [["write", protocol.encode(name, values).hex()], ["advance", MS]]

    config = protocol.encode("control_config", {"sequence": 9, "law": "compensated"})
    wall = {"target": {"slot": 0}, "angle_turns_q32": 1 << 28, "stiffness_nm_per_rad": 1.4}
    detents = {"target": {"slot": 1}, "per_turn_q32": 24 << 32, "torque_nm": 0.02}
    texture = {"target": {"slot": 2}, "grains_per_turn": 200, "torque_nm": 0.005, "grain": "noise"}
    return [
        ["get", 1],
        ["set", config.hex()],
        *write("wall", **wall),
        *write("detents", **detents),
        *write("texture", **texture),
        *write("commit", active=7),
        *write("stream", decimation=2),
        *write("command", op="arm"),
        ["hold", *HAND.values(), PATH],
        *[step for _ in range(30) for step in write("command", op="keep_alive")],
        *(5 * [*write("command", op="keep_alive"), ["advance", 99 * MS]]),
        ["push", [[0.0, 0.05], [0.1, 0.05], [0.1, -0.05]]],
        *write("command", op="keep_alive"),
        ["advance", 150 * MS],
        ["emergency stop", True],
        ["advance", 20 * MS],
        ["get", 3],
    ]  # fmt: skip


def test_device_in_webassembly_gives_the_native_bytes() -> None:
    steps = _session()
    native, wasm = _natively(steps), _in_wasm(steps)
    # That it was worth comparing: the fault is there, and telemetry of a wall that was felt.
    health = wire.decode(bytes.fromhex(native["features"][-1]))[1]
    assert health["faults"] == 1
    samples = [
        sample["desired_torque"]
        for report in map(bytes.fromhex, native["reports"])
        if report[0] == 0x40
        for sample in wire.decode(report)[1]["sample"]
    ]
    assert min(samples) < -1000
    assert wasm == native


def test_device_in_webassembly_says_in_its_own_words_what_is_wrong() -> None:
    said = _in_wasm([], period_ns=1)["error"]
    assert said == "control_period_ns must be within 50000 and 1000000, is 1"
    jump = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.5]]
    said = _in_wasm([["hold", *HAND.values(), jump], ["advance", MS]])["error"]
    assert "intended_angle_rad" in said


def test_modules_of_the_page() -> None:
    done = subprocess.run(
        ["node", "--test", "--test-reporter=tap", *sorted(FOLDER.glob("*.test.mjs"))],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "\n# fail 0\n" in done.stdout


def test_page_judges_scenes_by_the_same_rule() -> None:
    """In the page and in the library, at the same rate."""

    def judged(*scene: tuple[str, dict[str, Any]], law: str = "paper") -> list[Any]:
        reports = [
            protocol.encode(name, {"target": {"slot": n}, **values})
            for n, (name, values) in enumerate(scene)
        ]
        reports += [protocol.encode("control_config", {"law": law})]
        reports += [protocol.encode("actuator_config", {})]
        return ["swings", [report.hex() for report in reports]]

    spring = ("spring", {"stiffness_nm_per_rad": 8.0})
    damper = ("damper", {"damping_nm_s_per_rad": 0.15})
    steps = [
        judged(),
        judged(spring),
        judged(spring, spring, spring),
        judged(damper),
        judged(damper, law="calibrated"),  # which bounds it
        judged(("wall", {**spring[1], "damping_nm_s_per_rad": 0.5}), law="calibrated"),
    ]
    answers = _in_wasm(steps)["features"]
    assert [bool(answer) for answer in answers] == [False, False, True, True, False, True]
    options = torsio.EmulatorOptions(control_rate_hz=1e9 / PERIOD_NS)
    with (
        torsio.open("emulated", emulator=options) as knob,
        pytest.warns(torsio.StiffnessWarning) as told,
    ):
        knob.play([torsio.Spring(stiffness_nm_per_rad=8.0)] * 3)
    assert answers[2] == str(told[0].message)
