"""The lists of mutants fit the sources; how a change of a line is made and judged."""

from __future__ import annotations

import pytest

from tests.mutation import lists, mutate
from tests.mutation.lists import BadList, Mutant, Place, Replacement


def test_every_list_fits_its_sources() -> None:
    of_file: dict[str, list[tuple[Place, list[int]]]] = {}
    for place in lists.read_lists():
        of_file.setdefault(place.file, []).append((place, [1] * len(place.replacements)))
    for file, places in of_file.items():
        lists.mutate_source((mutate.TREE / file).read_text(encoding="utf-8"), places)


SOURCE = "int held(int torque, int cap) {\n  if (torque > cap) return cap;\n  return torque;\n}\n"


def place(context: str, *replacements: str) -> Place:
    return Place("x.cpp", context, "list:1", [Replacement(text, "list:2") for text in replacements])


def test_expression_becomes_a_choice() -> None:
    text = lists.mutate_source(SOURCE, [(place("torque > cap", "false"), [7])])
    assert "if ((torsio_mutant_is(7) ? (false) : (torque > cap))) return cap;" in text


def test_statement_becomes_a_branch_and_has_several_mutants() -> None:
    text = lists.mutate_source(SOURCE, [(place("return torque;", "return 0;", ";"), [1, 2])])
    assert (
        "if (torsio_mutant_is(1)) { return 0; } else "
        "{ if (torsio_mutant_is(2)) { ; } else { return torque; } }" in text
    )


@pytest.mark.parametrize(
    ("context", "message"),
    [
        ("torque < cap", r"^list:1: 'torque < cap' is not in x.cpp; write what stands there now"),
        ("torque", r"^list:1: 'torque' stands 3 times in x.cpp"),
    ],
)
def test_place_that_is_not_there_once_is_an_error(context: str, message: str) -> None:
    with pytest.raises(BadList, match=message):
        lists.mutate_source(SOURCE, [(place(context, "false"), [1])])


def test_equivalent_mutant_that_dies_is_told() -> None:
    lives, dies = (Mutant(n, "x.cpp", f"a{n}", "b", "list:1", "for a reason") for n in (1, 2))
    must_die = Mutant(3, "x.cpp", "a3", "b", "list:3")
    assert mutate.verdict([lives, dies], [lives]) == [
        f"died, though list:1 calls it equivalent: {dies}"
    ]
    assert mutate.verdict([must_die], [must_die]) == [f"lives: {must_die}"]
