"""The files that users copy to a board: what `torsio firmware` reads in them."""

from __future__ import annotations

from tests.board import pico as bench
from tests.python import wire
from tools import uf2
from torsio import firmware


def test_file_says_for_which_board_and_protocol_it_is() -> None:
    model = bench.chosen
    found = firmware.read(model.image)
    assert (found.board, found.chip) == (model.name, model.chip)
    assert found.fingerprint == wire.fingerprint()
    pages = uf2.check(model.image.read_bytes(), model.chip)
    assert found.size == 256 * len(pages)
    # Its last page is far from where the configuration is kept.
    assert max(pages) + 256 - bench.FLASH_BASE <= model.slots_at
    project = (bench.TREE / "CMakeLists.txt").read_text(encoding="utf-8")
    assert f"project(torsio VERSION {found.version} " in project.replace("\n", " ")
