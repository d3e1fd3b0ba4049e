"""Keeps what runs inside the guests apart from what runs on the host, and starts them first."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.vm.guests import GUEST_VARIABLE

collect_ignore = [] if GUEST_VARIABLE in os.environ else ["guest"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    # The first worker starts all guests and waits. Its file comes first, so that the other workers
    # go on meanwhile.
    file = Path(__file__).with_name("test_guest.py")
    items.sort(key=lambda item: item.path != file)
