"""The short forms of ``./dev soak`` and ``./dev unplugs``."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from tests.endurance import unplugs

TREE = Path(__file__).parent.parent
SOAK = TREE / "build/release/tests/determinism/torsio_soak"


def test_knobs_that_have_lived_for_a_while_are_as_they_were_at_first() -> None:
    command = [str(SOAK), "--hours", "0.2", "--minutes", "0.5", "--knobs", "4"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert re.search(r"\d+ examinations; .* 0 faults$", ended.stdout)


# Where the plug goes just before a close, the close says that it could not disarm.
@pytest.mark.filterwarnings("ignore:Exception ignored in. 'torsio.Knob.close'")
def test_unplugs_in_every_state_are_told_and_leave_nothing_behind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(unplugs, "LATEST_S", 60.0)  # a busy machine is no fault of the library's
    outcome = unplugs.pull(4 * len(unplugs.STATES), seed=1)
    assert outcome.faults == []
    assert set(outcome.states) == set(unplugs.STATES)
