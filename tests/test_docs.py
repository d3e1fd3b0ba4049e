"""Documents that are made from the code are the ones that the code makes now."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

TREE = Path(__file__).parent.parent


def test_protocol_document_is_what_the_field_lists_make() -> None:
    program = TREE / "build/release/firmware/protocol/torsio_protocol_doc"
    if not program.exists():
        pytest.fail(
            f"{program.relative_to(TREE)} is not built; run ./dev build release", pytrace=False
        )
    made = subprocess.run([program], capture_output=True, check=True).stdout
    # Not compared by assert, which would print both in full.
    if (TREE / "docs/protocol.md").read_bytes() != made:
        pytest.fail("docs/protocol.md is not what the code makes; run ./dev docs", pytrace=False)
