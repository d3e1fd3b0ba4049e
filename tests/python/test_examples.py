"""Every Python example runs on the emulated knob and says what it promises."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

TREE = Path(__file__).parents[2]
EXAMPLES = sorted((TREE / "examples" / "python").glob("*.py"))
PROMISED = {
    "detents": "notch 5:",
    "feel_a_wall": "pushed back with 4",  # 50 mN m less friction
    "learn_a_wall": "the law calibrated: -0.",
    "stream_local_model": "0 models refused",
    "stream_to_lsl": " samples of angle_rad, desired_torque_nm",
}
# Shorter than by itself.
ARGUMENTS = {"learn_a_wall": ["1"], "stream_to_lsl": ["emulated", "0.1"]}


@pytest.fixture(autouse=True)
def quiet_lsl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the Lab Streaming Layer stay on this machine and say nothing of how it does."""
    config = tmp_path / "lsl_api.cfg"
    config.write_text(
        "[lab]\nKnownPeers = {127.0.0.1}\n[multicast]\nResolveScope = machine\n[log]\nlevel = -3\n"
    )
    monkeypatch.setenv("LSLAPICFG", str(config))


def test_every_example_is_known() -> None:
    assert {example.stem for example in EXAMPLES} == set(PROMISED)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(example: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-W", "error", str(example), *ARGUMENTS.get(example.stem, [])],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert PROMISED[example.stem] in result.stdout
    assert result.stderr == ""


def test_detents_tells_milliseconds_that_come_to_its_recording() -> None:
    example = TREE / "examples/python/detents.py"
    output = subprocess.run([sys.executable, str(example)], capture_output=True, text=True).stdout
    stays_ms = [int(stay) for stay in re.findall(r"^notch -?\d+: (\d+) ms,", output, re.MULTILINE)]
    assert len(stays_ms) >= 6
    # It records 3.2 s; each line is rounded to a millisecond.
    assert sum(stays_ms) == pytest.approx(3200, abs=len(stays_ms) + 5)


def _learn(*arguments: str) -> dict[str, float]:
    """Return what `learn_a_wall` says that each earns."""
    example = TREE / "examples/python/learn_a_wall.py"
    output = subprocess.run(
        [sys.executable, str(example), *arguments], capture_output=True, text=True, check=True
    ).stdout
    told = re.findall(r"^(.+): (-[\d.]+), an error of [\d.]+ mN m RMS$", output, re.MULTILINE)
    return {name: float(earned) for name, earned in told}


@pytest.mark.parametrize("generations", ["x", "-1", "0", "1.5"])
def test_learning_for_no_number_of_generations_is_refused(generations: str) -> None:
    example = TREE / "examples/python/learn_a_wall.py"
    result = subprocess.run(
        [sys.executable, str(example), "--", generations], capture_output=True, text=True
    )
    assert result.returncode == 2
    assert f"{generations} is no whole number from 1 to 1000" in result.stderr


@pytest.mark.slow
def test_wall_is_learned_better_than_laws_render_it_that_know_less_of_the_brake() -> None:
    """From nothing, by seed, and from more generations more."""
    laws = {f"the law {name}" for name in ("paper", "compensated", "calibrated")}
    learned = _learn()
    assert learned.keys() == {"nothing", "learned"} | laws
    assert learned["nothing"] < -100.0  # pressed by 40 mN m and more into walls that are not there
    assert learned["learned"] > max(learned[law] for law in laws - {"the law calibrated"})
    # It knows all of the brake that the learner had to find out.
    assert learned["the law calibrated"] == pytest.approx(learned["learned"], rel=0.2)
    begun = _learn("2")
    assert begun == _learn("2")
    assert learned["nothing"] < begun["learned"] < learned["learned"]


LISTENER = """
import json, pylsl
(info,) = pylsl.resolve_byprop("name", "torsio", timeout=60.0)
inlet = pylsl.StreamInlet(info)
inlet.open_stream(timeout=60.0)
print("listening", flush=True)
rows, stamps = [], []
while len(rows) < 500:
    new, times = inlet.pull_chunk(timeout=1.0)
    rows += new
    stamps += times
channel = inlet.info(timeout=10.0).desc().child("channels").first_child()
labels = []
while not channel.empty():
    labels.append((channel.child_value("label"), channel.child_value("unit")))
    channel = channel.next_sibling()
print(json.dumps([labels, rows, stamps]))
"""


def test_stream_has_the_wall_and_the_distances_of_the_device() -> None:
    """Seen by another program through LSL's own library."""
    example = TREE / "examples/python/stream_to_lsl.py"
    begin = [sys.executable, "-W", "error"]
    sender = [*begin, str(example), "emulated", "60"]
    with subprocess.Popen(sender, stdout=subprocess.DEVNULL) as sending:
        try:
            told = subprocess.run(
                [*begin, "-c", LISTENER], stdout=subprocess.PIPE, text=True, timeout=120, check=True
            ).stdout
        finally:
            sending.kill()
    labels, rows, stamps = json.loads(told.splitlines()[-1])
    assert labels[:2] == [["angle_rad", "rad"], ["desired_torque_nm", "N m"]]
    log = np.array(rows)
    assert np.diff(stamps) == pytest.approx(1e-3, abs=1e-9)
    # A wall of 1 N m/rad at 0.1 rad, by its definition.
    # Telemetry tells torques in steps of some 10 uN m.
    wall_nm = -np.maximum(log[:, 0] - 0.1, 0.0)
    inside = log[:, 0] > 0.1
    assert log[inside, 1] == pytest.approx(wall_nm[inside], abs=1.5e-5)
    assert np.all(log[log[:, 0] < 0.1, 1] == 0.0)
