"""pytest's fixtures for programs that use a knob; docs/how-to/testing.md tells how to use them.

pytest loads this into every run, by the package's entry point. So the library, and NumPy with it,
are imported by the first fixture that a test uses.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    import torsio
    from torsio import testing

_HIGHEST_SEED = 2**64 - 1


def pytest_addoption(parser: pytest.Parser) -> None:
    """Tell pytest of the options."""
    group = parser.getgroup("torsio", "emulated knobs")
    group.addoption(
        "--torsio-seed",
        default="",
        metavar="N",
        help="seed of the emulated knobs: a number, or 'random'; by default it follows from the "
        "test's name, the same in every run",
    )
    group.addoption(
        "--torsio-recordings",
        default="",
        metavar="DIR",
        help="where recordings of failed tests go; by default into pytest's cache",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Tell pytest of the mark, and look at the seed before any test runs."""
    config.addinivalue_line(
        "markers",
        "torsio(**options): fields of torsio.EmulatorOptions for the fixture torsio_knob",
    )
    seed = config.getoption("--torsio-seed")
    if seed not in ("", "random") and not (seed.isdecimal() and int(seed) <= _HIGHEST_SEED):
        raise pytest.UsageError(
            f"--torsio-seed is {seed!r}, allowed are 0 to {_HIGHEST_SEED} and 'random'"
        )


@pytest.fixture
def torsio_seed(request: pytest.FixtureRequest) -> int:
    """Give the seed of everything random in the test's knob, printed if the test fails."""
    from torsio.apps import pytest_plugin

    return pytest_plugin.seed(request)


@pytest.fixture
def torsio_knob(request: pytest.FixtureRequest, torsio_seed: int) -> Iterator[torsio.Knob]:
    """Give an open emulated knob in virtual time, with the options of the mark ``torsio``."""
    from torsio.apps import pytest_plugin

    yield from pytest_plugin.knob(request, torsio_seed)


@pytest.fixture
def torsio_hand(torsio_knob: torsio.Knob) -> testing.HoldingHand:
    """Give the hand that holds the test's knob; nobody does until it acts."""
    from torsio.apps import pytest_plugin

    return pytest_plugin.hand(torsio_knob)


@pytest.fixture
def torsio_faults(request: pytest.FixtureRequest, torsio_knob: torsio.Knob) -> testing.Faults:
    """Give what makes the test's knob go wrong, and what took its place."""
    from torsio.apps import pytest_plugin

    return pytest_plugin.faults(request, torsio_knob)


@pytest.fixture
def torsio_time(request: pytest.FixtureRequest, torsio_knob: torsio.Knob) -> Iterator[None]:
    """Let the module `time` follow the test's knob; see `torsio.testing.virtual_time`."""
    from torsio.apps import pytest_plugin

    yield from pytest_plugin.time_of(request, torsio_knob)


@pytest.fixture
def torsio_open(
    request: pytest.FixtureRequest, torsio_knob: torsio.Knob, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., torsio.Knob]:
    """Let `torsio.open` give the test's knob, for any selector.

    Once that knob is closed or unplugged, a new one with the same options comes, as if the device
    were plugged in again.
    """
    from torsio.apps import pytest_plugin

    return pytest_plugin.open_of(request, torsio_knob, monkeypatch)


@pytest.hookimpl(hookwrapper=True)  # as pytest has always had it: this is loaded into every one
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """Say of a failed test what its knob's seed was, and keep what its knob did."""
    report = (yield).get_result()
    if (plugin := getattr(sys.modules.get("torsio.apps"), "pytest_plugin", None)) is not None:
        plugin.add_to_report(item, report)
