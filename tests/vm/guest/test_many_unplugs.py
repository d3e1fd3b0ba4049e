"""``./dev unplugs N --kernel K``, and a short form of it for each test run."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import torsio
from tests.endurance import unplugs
from tests.endurance.unplugs import Means
from tests.vm.guest.virtual_bus import VirtualKnob

SHARE = Path("/torsio-share")


@pytest.mark.long
@pytest.mark.whole
@pytest.mark.pulls_cable
@pytest.mark.kernel("6.1")
def test_many_unplugs_in_every_state(knob: VirtualKnob) -> None:
    @contextmanager
    def on_cable(_: bool) -> Iterator[tuple[torsio.Knob, Callable[[], object]]]:
        if not knob.is_plugged:
            knob.plug()
        with torsio.open(knob.serial) as opened:
            yield opened, lambda: knob.unplug(wait=False)
        knob.wait_unplugged()

    count = int(os.environ.get(unplugs.COUNT_VARIABLE, str(len(unplugs.STATES) - 1)))
    seed = int(os.environ.get(unplugs.SEED_VARIABLE, "1"))
    before = Means.of(knob.process.pid)

    def tell(outcome: unplugs.Outcome) -> None:
        own = f"the knob's program before: {before}, after: {Means.of(knob.process.pid)}"
        (SHARE / "unplugs").write_text(f"{outcome}; {own}\n")

    outcome = unplugs.pull(count, seed, on_cable, tell)
    tell(outcome)
    assert outcome.faults == []
    assert Means.of(knob.process.pid).faults(before, count) == []
