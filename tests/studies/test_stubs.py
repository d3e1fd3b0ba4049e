"""The hand-written stubs of the extension module say what the module has."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).parents[2]
STUBS = TREE / "bindings" / "python" / "torsio" / "_torsio"
STUDIES_STUB = TREE / "studies" / "python" / "torsio_studies" / "_studies.pyi"


@pytest.mark.slow  # ten seconds of processor; mypy finds what tests use, in every run
def test_stubs_and_module_have_the_same_names() -> None:
    result = subprocess.run(
        [
            *(sys.executable, "-m", "mypy.stubtest"),
            *("torsio._torsio", "torsio_studies._studies"),
            *("--allowlist", "tests/python/stubtest_allowlist.txt", "--concise"),
            *("--mypy-config-file", "pyproject.toml"),
        ],
        cwd=TREE,
        env={**os.environ, "MYPYPATH": f"{STUBS.parents[1]}{os.pathsep}{STUDIES_STUB.parents[1]}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
