"""The lists of mutants fit the sources; how a change of a line is made and judged."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.mutation import anywhere, hunt, lists, mutate
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


@pytest.mark.parametrize(
    ("line", "suffix", "become"),
    [
        ("  if (depth <= 0.5F) return 0;", ".cpp", ["< 0.5F", "<= 1.0F", "return 1", "(!(depth"]),
        ("  row->speed = 1'000;  // < this", ".cpp", ["  ;"]),
        ("        self.note(kind, a is None)", ".py", ["is not None", "        pass"]),
        ("    if kind and not found:", ".py", ["kind or not", "and found", "not (kind and not"]),
        ('    print("a < b")', ".py", ["pass"]),
        ("    socket.close();", ".ts", ["    ;"]),
    ],
)
def test_line_may_become_something_else_but_for_its_words(
    line: str, suffix: str, become: list[str]
) -> None:
    changes = list(anywhere.changes_of(line, anywhere.masked(line, suffix), suffix))
    assert len(changes) == len(become), changes
    assert [text for text in become if not any(text in change for change in changes)] == []


def test_seed_draws_the_same_changes_again_and_of_every_language() -> None:
    first, again = (list(itertools.islice(anywhere.drawn(7), 200)) for _ in range(2))
    assert first == again
    assert {Path(change.file).suffix for change in first} == {".cpp", ".hpp", ".py", ".ts"}
    assert all(change.before != change.after for change in first)


def test_summary_names_what_lives_and_counts_what_was_built() -> None:
    results = ["dead", "dead", "dead", "alive", "unbuilt"]
    told = hunt.summary(
        [{"key": str(n), "change": f"c{n}", "result": r} for n, r in enumerate(results)]
    )
    assert told[0] == "lives 3 c3"
    assert told[1].startswith("4 mutants: 3 dead, 0 explained, 1 live: 75.0%")


@pytest.mark.parametrize(
    ("before", "after", "piece", "becomes"),
    [
        ("  return a < b ? 1 : 0;", "  return a <= b ? 1 : 0;", "a < b", "a <= b"),
        ("  const int n = f(x, 2 * y);", "  const int n = f(x, 3 * y);", "2 * y", "3 * y"),
        ("  if (a && !b) return;", "  if (!(a && !b)) return;", "a && !b", "!(a && !b)"),
        ("  queue.push(1);  // one", "  ;", "queue.push(1);", ";"),
        ("  n += m;", "  n -= m;", "n += m;", "n -= m;"),
    ],
)
def test_line_of_cpp_has_a_piece_that_may_be_a_choice(
    before: str, after: str, piece: str, becomes: str
) -> None:
    text = f"void f() {{\n{before}\n}}\n"
    choice = anywhere.choice_of(anywhere.Change("x.cpp", 2, before, after), text)
    assert choice is not None
    begin, end, new = choice
    assert (text[begin:end], new) == (piece, becomes)


@pytest.mark.parametrize("before", ["  constexpr int n = 2;", "  case 2:", "  enum A { a = 2 };"])
def test_what_the_compiler_computes_is_no_choice(before: str) -> None:
    change = anywhere.Change("x.cpp", 2, before, before.replace("2", "3"))
    assert anywhere.choice_of(change, f"void f() {{\n{before}\n}}\n") is None


def test_test_that_fails_anyway_hides_no_other_and_is_no_killer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def run(command: Sequence[str], *, number: int, **_: object) -> tuple[bool, list[hunt.Tried]]:
        told = []
        for test in command[command.index("-x") + 1 :]:
            failed = test == "a::sick" or (test == "c::kills" and number == 7)
            told.append(hunt.Tried(test, failed, 0.1, (), ()))
            if failed:
                break
        return not told[-1].failed, told

    monkeypatch.setattr(hunt, "run", run)
    tests = [hunt.Tried(name, False, 0.1, (7,), ()) for name in ("a::sick", "b", "c::kills")]
    tried = hunt.Hunt([], set(), mutate.Campaign(Path()), None, tests)  # type: ignore[arg-type]
    assert tried._red(tests, 7) == "c::kills"
    assert tried._red(tests, 8) == ""
