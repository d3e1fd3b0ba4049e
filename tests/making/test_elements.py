"""Finite elements of two programs against the closed form, and against each other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.hardware.test_flexure import EXAMPLE, LIU, LIU_ARM, LIU_MODULUS_PA, MODULUS_PA
from torsio_hardware import design, elements
from torsio_hardware.flexure import REFERENCE, SHAPES, Flexure, closed_form

TWISTS_RAD = (1e-3, 0.015, 0.04)
SLENDER = replace(EXAMPLE, thickness_m=0.3e-3)


@pytest.mark.parametrize("shape", [EXAMPLE, SLENDER, SHAPES["spiral"], REFERENCE])
def test_two_programs_agree_with_each_other_and_with_the_closed_form(shape: Flexure) -> None:
    one, other = (
        program(shape, MODULUS_PA, TWISTS_RAD)
        for program in (elements.scikit_fem, elements.calculix)
    )
    assert one == pytest.approx(other, rel=0.01)
    if shape.family == "spoke":
        exact = closed_form(shape, MODULUS_PA).stiffness_nm_per_rad
        assert (one[0], other[0]) == pytest.approx((exact, exact), rel=0.02)


@pytest.mark.parametrize("program", [elements.scikit_fem, elements.calculix])
def test_finer_elements_change_less_and_less(program: Any) -> None:
    found = [
        program(REFERENCE, MODULUS_PA, TWISTS_RAD, along=n, across=c)[-1]
        for n, c in ((20, 1), (40, 2), (80, 4))
    ]
    first, second = np.abs(np.diff(found)) / found[-1]
    assert second < first / 1.5
    assert second < 0.005


@pytest.mark.parametrize("family", list(SHAPES))
def test_plates_are_stiffer_by_what_the_design_adds(family: str) -> None:
    petg = design.material("petg")
    shape = design.examine(SHAPES[family], petg, 2.873).flexure
    flat, plate = (
        elements.calculix(shape, petg.modulus_pa.value, TWISTS_RAD[:1], thin=thin)[0]
        for thin in (True, False)
    )
    assert plate / flat == pytest.approx(design.PLATES[family], rel=0.02)


def test_spiral_of_the_literature_is_as_stiff_as_published() -> None:
    for program in (elements.scikit_fem, elements.calculix):
        found = program(LIU, LIU_MODULUS_PA, TWISTS_RAD[:1])[0]
        assert found / LIU.arms == pytest.approx(LIU_ARM, rel=0.015)


def test_error_in_the_output_is_seen_though_the_program_ends_well() -> None:
    with pytest.raises(RuntimeError, match="ERROR"):
        elements.calculix(replace(REFERENCE, thickness_m=3e-3, waves=3), MODULUS_PA, TWISTS_RAD[:1])
