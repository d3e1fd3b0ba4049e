"""pytest's fixtures for programs that use a knob; docs/how-to/testing.md tells how to use them.

`torsio_pytest` imports it with the first fixture. Nothing else does: the package needs no pytest.
"""

from __future__ import annotations

import random
import time
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import torsio
from torsio import testing
from torsio._torsio import all_of
from torsio.common import checks
from torsio.telemetry import TELEMETRY_DTYPE, Record

_HIGHEST_SEED = 2**64 - 1
_MOST_KEPT_SAMPLES = 2**22


def _options(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Give what the test's marks say, the nearest one's last."""
    options: dict[str, Any] = {}
    known = {field.name for field in fields(torsio.EmulatorOptions)}
    for mark in reversed(list(request.node.iter_markers("torsio"))):
        if mark.args or not known >= mark.kwargs.keys():
            raise pytest.UsageError(
                f"{request.node.nodeid}: pytest.mark.torsio takes fields of torsio.EmulatorOptions "
                f"by name ({', '.join(sorted(known))}), not {mark.args or sorted(mark.kwargs)}"
            )
        options |= mark.kwargs
    return options


def _name(item: pytest.Item) -> str:
    """Give a test's name as pytest is called with; xdist writes a test's group behind it."""
    return f"{item.parent.nodeid}::{item.name}" if item.parent else item.nodeid


def seed(request: pytest.FixtureRequest) -> int:
    """Give the seed of everything random in the test's knob, printed if the test fails."""
    if "seed" in (options := _options(request)):
        return checks.whole("seed", options["seed"], 0, _HIGHEST_SEED)
    given = request.config.getoption("--torsio-seed")
    if given == "random":
        return random.SystemRandom().getrandbits(32)
    return int(given) if given else zlib.crc32(_name(request.node).encode())


def knob(request: pytest.FixtureRequest, torsio_seed: int) -> Iterator[torsio.Knob]:
    """Give an open emulated knob in virtual time, with the options of the mark ``torsio``."""
    options = torsio.EmulatorOptions(
        **{"log_truth": True, **_options(request), "seed": torsio_seed}
    )
    plugs = _PLUGS[_name(request.node)] = _Plugs(options)
    try:
        yield plugs.knob
    finally:
        plugs.close()


def hand(torsio_knob: torsio.Knob) -> testing.HoldingHand:
    """Give the hand that holds the test's knob; nobody does until it acts."""
    assert isinstance(torsio_knob, _KeptKnob)
    return torsio_knob.hand


def faults(request: pytest.FixtureRequest, torsio_knob: torsio.Knob) -> testing.Faults:
    """Give what makes the test's knob go wrong, and what took its place."""
    return testing.Faults(_knob_now(request, torsio_knob))


def time_of(request: pytest.FixtureRequest, torsio_knob: torsio.Knob) -> Iterator[None]:
    """Let the module `time` follow the test's knob; see `torsio.testing.virtual_time`."""
    with testing.virtual_time(_knob_now(request, torsio_knob)):
        yield


def _knob_now(
    request: pytest.FixtureRequest, torsio_knob: torsio.Knob
) -> Callable[[], torsio.Knob]:
    """Give what gives the knob that is plugged in; a fixture of the user's may be in our place."""
    plugs = _PLUGS.get(_name(request.node))
    return lambda: torsio_knob if plugs is None else plugs.knob


def open_of(
    request: pytest.FixtureRequest, torsio_knob: torsio.Knob, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., torsio.Knob]:
    """Let `torsio.open` give the test's knob, for any selector.

    Once that knob is closed or unplugged, a new one with the same options comes, as if the device
    were plugged in again.
    """
    plugs = _PLUGS.get(_name(request.node))

    def open_(*_: object, **__: object) -> torsio.Knob:
        if plugs is None:
            return torsio_knob
        if not plugs.knob.is_open or plugs.knob.state == "disconnected":
            plugs.plug_in()
        return plugs.knob

    monkeypatch.setattr(torsio, "open", open_)
    return open_


def add_to_report(item: pytest.Item, report: pytest.TestReport) -> None:
    """Say of a failed test what its knob's seed was, and keep what its knob did."""
    plugs = _PLUGS.get(_name(item))
    if report.failed and plugs is not None:
        seed = plugs.options.seed
        lines = [f"seed {seed}; again with: pytest --torsio-seed={seed} '{_name(item)}'"]
        for number, knob in enumerate(plugs.knobs):
            try:
                lines.append(f"recording {knob.keep(_recording_of(item, number))}")
            except (OSError, torsio.Error) as error:  # the failure itself must be told all the same
                lines.append(f"no recording: {error}")
        report.sections.append(("torsio", "\n".join(lines)))
    if report.when == "teardown":
        _PLUGS.pop(_name(item), None)


def _recording_of(item: pytest.Item, number: int) -> Path:
    folder = item.config.getoption("--torsio-recordings")
    if folder:
        path = Path(folder)
    elif (cache := getattr(item.config, "cache", None)) is not None:
        path = cache.mkdir("torsio")
    else:
        path = item.config.rootpath / "torsio-recordings"
    path.mkdir(parents=True, exist_ok=True)
    name = "".join(c if c.isalnum() or c in "-_." else "_" for c in _name(item))
    name = name.encode()[-120:].decode(errors="ignore")  # a file's name is some 255 bytes
    own = f"-{zlib.crc32(_name(item).encode()):08x}"  # others may be called the same now
    return path / f"{name}{own}{f'-{number + 1}' if number else ''}.npz"


class _Tap:
    """Stands before a knob's own end of the cable, and remembers the samples that come by."""

    def __init__(self, knob: Any) -> None:
        self._knob = knob
        self.samples: list[Record] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._knob, name)

    def record(
        self, duration_s: float, rate_hz: float | None, must_stay_armed: bool, kept: list[Any]
    ) -> Record:
        try:
            samples: Record = self._knob.record(duration_s, rate_hz, must_stay_armed, kept)
        finally:
            if kept:
                self._keep(kept[0])
        return samples

    def read(self, max_samples: int, timeout_s: float, kept: list[Any]) -> Record:
        samples: Record = self._knob.read(max_samples, timeout_s, kept)
        self._keep(samples)
        return samples

    def _keep(self, samples: Record) -> None:
        self.samples.append(samples)
        while len(self.samples) > 1 and sum(map(len, self.samples)) > _MOST_KEPT_SAMPLES:
            self.samples.pop(0)


class _KeptKnob(torsio.Knob):
    """A knob whose recording can be kept after it was closed."""

    def __init__(self, knob: torsio.Knob, options: torsio.EmulatorOptions) -> None:
        self._tap = _Tap(knob._knob)
        super().__init__(self._tap, time_waits=not options.paced)  # type: ignore[arg-type]
        self._options = options
        self.hand = testing.HoldingHand(self)

    @all_of
    def close(self) -> Iterable[Callable[[], object]]:
        """Take the truth while it is there."""
        # Where time is this knob's, the clock is told where it ends.
        return (self._truth, time.monotonic, super().close)

    def keep(self, path: Path) -> Path:
        """Write all that is known of this knob's life."""
        telemetry = np.concatenate([np.zeros(0, TELEMETRY_DTYPE), *self._tap.samples])
        np.savez_compressed(path, seed=self._options.seed, telemetry=telemetry, truth=self._truth())
        return path

    def _truth(self) -> Record:
        if self._options.log_truth and self.is_open:
            with suppress(torsio.Error):  # its time has stopped; earlier rows are there
                self.hand.truth()
        return self.hand.rows


class _Plugs:
    """The test's knob, and those that took its place; as often as it was plugged in."""

    def __init__(self, options: torsio.EmulatorOptions) -> None:
        self.options = options
        self.knobs: list[_KeptKnob] = []
        # Another than the one that a fixture gives instead.
        self._open = torsio.open
        self.plug_in()

    @property
    def knob(self) -> _KeptKnob:
        return self.knobs[-1]

    def plug_in(self) -> None:
        self.knobs.append(_KeptKnob(self._open("emulated", emulator=self.options), self.options))

    def close(self) -> None:
        with ExitStack() as closing:
            for knob in self.knobs:
                closing.callback(knob.close)


_PLUGS: dict[str, _Plugs] = {}
"""The knobs of the tests that run, by the tests' names."""
