"""The lists of mutants fit the sources."""

from __future__ import annotations

from tests.mutation import lists, mutate
from tests.mutation.lists import Place


def test_every_list_fits_its_sources() -> None:
    of_file: dict[str, list[tuple[Place, list[int]]]] = {}
    for place in lists.read_lists():
        of_file.setdefault(place.file, []).append((place, [1] * len(place.replacements)))
    for file, places in of_file.items():
        lists.mutate_source((mutate.TREE / file).read_text(encoding="utf-8"), places)
