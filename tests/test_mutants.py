"""The device's tests kill a share of the mutants; ``./dev mutate`` makes and kills all of them."""

from __future__ import annotations

from tests.mutation import mutate, short


def test_share_of_the_mutants_dies_by_the_device_s_own_tests() -> None:
    program = short.build(mutate.TREE / "build/logs/mutation-short.log")
    count, living = short.attack(program)
    assert [str(mutant) for mutant in living] == []
    assert count >= 30
