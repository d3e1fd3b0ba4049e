"""Every test that is left out on Windows exists."""

from __future__ import annotations

import re
from pathlib import Path

from tests import windows_plugin

TREE = Path(__file__).parent.parent


def test_what_is_left_out_on_windows_is_a_test() -> None:
    files = {file.name: file.read_text("utf-8") for file in (TREE / "tests/python").glob("*.py")}
    assert set(windows_plugin.FILES) <= set(files)
    named = set(re.findall(r"^def (test_\w+)", "\n".join(files.values()), re.MULTILINE))
    assert set(windows_plugin.TESTS) <= named
    assert {name.partition("[")[0] for name in windows_plugin.PARAMETERS} <= named
