"""Builds what tests need before they run, in the order in which it can be built."""

from __future__ import annotations

import functools
import os
from collections.abc import Collection
from concurrent.futures import Future
from typing import Any

from tools.dev import building, environment
from tools.dev.environment import PYTHON
from tools.dev.plans import Plan
from tools.dev.running import later, succeeds

# System packages that a step of the build of the tests needs, and those who use what it builds.
_PACKAGES = {
    "firmware": ("firmware",),
    "kernels": ("machines",),
    "page": ("studio", "browser"),
    "languages": ("languages",),
    "documents": ("documents",),
    "making": ("making",),
    "windows games": ("windows", "players"),
}


def build_tests(plan: Plan) -> None:
    """Build it, as much at once as can be."""
    needs = plan.needs
    sources = building.FirmwareSources()
    beside: list[Future[Any]] = []
    beside += [building.begin_fetching_kernels()] if "kernels" in needs else []
    wanted = [name for need, names in _PACKAGES.items() if need in needs for name in names]
    coming = environment.begin("tests", "game", *wanted)
    sources.require()
    if "release" in needs:
        building.build_preset("release", sources.tinyusb)
    coming.finish()
    beside += _begin_beside(needs, sources.tinyusb)
    _build_packages(needs, sources.tinyusb)
    # Once for all workers and guests, which otherwise compile every test each. Errors show later.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    collect = ("--collect-only", "-q", "-p", "no:xdist", *plan.arguments)
    beside += [later(lambda: succeeds(PYTHON, "-m", "pytest", *collect))]
    _build_firmware(plan, sources.sdk)
    for step in beside:
        step.result()
    if "windows games" in needs:
        environment.make_players()
        building.build_windows_games()


def _begin_beside(needs: Collection[str], tinyusb: str) -> list[Future[Any]]:
    """Begin what may run beside the rest: downloads, sanitizers, and the page, by Zig."""
    beside: list[Future[Any]] = []
    beside += [building.begin_npm("tests/board")] if "firmware" in needs else []
    beside += [building.begin_studio()] if "page" in needs else []
    for preset in ("asan-ubsan", "tsan"):
        if preset in needs:
            beside.append(later(functools.partial(building.build_preset, preset, tinyusb)))
    return beside


def _build_firmware(plan: Plan, sdk: str) -> None:
    if "firmware" in plan.needs:
        building.build_firmware(sdk, plan.boards)
        building.build_emulated(plan.boards)
    if "unguarded" in plan.needs:
        building.build_unguarded(sdk)


def _build_packages(needs: Collection[str], tinyusb: str) -> None:
    building.build_python(building.TORSIO, tinyusb)
    if "studies" in needs:
        building.build_python(building.STUDIES, tinyusb)
    if "hardware" in needs:
        building.build_python(building.HARDWARE, tinyusb)
    if "making" in needs:
        environment.make_hardware()
