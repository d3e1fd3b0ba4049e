"""Leaves out what is of a board that does not take part."""

from __future__ import annotations

import pytest

from tests.mcu.mcu import CHIPS


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "board(name): is of this board alone")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    marks = {item: item.get_closest_marker("board") for item in items}
    left = [item for item, mark in marks.items() if mark and mark.args[0] not in CHIPS]
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in left]
