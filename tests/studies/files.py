"""Each operation on a study's files fails once; ``tests/faults/files.py`` has the library's."""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.faults import files
from tests.faults.files import Wrong, old_or_new, sentence
from torsio_studies import common
from torsio_studies.design.store import Store


def results(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    file = folder / "x.json"
    rows = [1.0] * 1000
    return old_or_new(
        file,
        lambda: common.save({"study": "x", "rows": rows}, file),
        lambda: json.loads(file.read_text())["rows"] == rows,
    )


@dataclasses.dataclass(frozen=True)
class Batch:
    group: str = "x"
    index: int = 0
    designs: tuple[int, ...] = (1, 2)


def store(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    kept = Store(folder / "store", {})
    batch, rows = Batch(), [{"a": 1.0}, {"a": 2.0}]
    kept.write(Batch(index=1), rows)

    def act() -> None:
        kept.write(batch, rows)
        kept.intact([batch, Batch(index=1)])

    def wrong(raised: BaseException | None) -> str:
        if {Batch(index=1)} - kept.intact([batch, Batch(index=1)]):
            return "what was there before is gone"
        if any(".part" in path.name for path in kept.folder.iterdir()):
            return "something is left beside it"
        return sentence(raised)

    return act, wrong


if __name__ == "__main__":
    scenarios = {"study's results": results, "study's store": store}
    files.main(scenarios, int(sys.argv[1]), sys.argv[2:])
