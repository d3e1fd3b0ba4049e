"""Counter-examples that were found against the law `calibrated`: all but two rest.

Each has beliefs, a brake, a scene or an encoder with which a knob once swung or buzzed for ever.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.studies.found import FOUND, ROLLS, found
from torsio import (
    BoardConfig,
    ControlConfig,
    Curve,
    EndStops,
    ImpedanceHand,
    Inertia,
    NoHand,
    PlantParams,
    ShaftConfig,
    Spring,
    TorqueHand,
    Wall,
)
from torsio.closed_loop import ClosedLoop, InitialState, LoopOptions
from torsio.perception import TORQUE_JND_NM
from torsio.printed.hands import Hand, PrescribedMotion
from torsio.printed.plant import BrakeHysteresis, Electrics, ShaftHardening
from torsio.printed.scenes import Effect
from torsio_studies.falsify.search import (
    LASTING_RAD,
    Motion,
    breaks,
    confirm,
    measure,
)

COUNTS = 32_768
PLANT = PlantParams(counts_per_rev=COUNTS)
AT_RAD = 0.05
WEIGHT_NM = 40e-3
RAMPS_S = (0.02, 0.1, 0.3, 0.5)
QUIET_NM = 1e-3


def loop(
    scene: Effect,
    hand: Hand,
    *,
    plant: PlantParams = PLANT,
    told: dict[str, float] | None = None,
    straight: bool = False,
) -> LoopOptions:
    """`told` are factors on the true values; `straight` tells it no knees."""
    right = plant.matching_config()
    wrong = {name: factor * getattr(right, name) for name, factor in (told or {}).items()}
    return LoopOptions(
        scene=scene,
        hand=hand,
        plant=plant,
        actuator=replace(right, **wrong),
        shaft=ShaftConfig() if straight else None,
        control=ControlConfig(law="calibrated"),
        control_period_ns=50_000,
    )


def weight(torque_nm: float, ramp_s: float) -> TorqueHand:
    return TorqueHand(torque_nm=[(0.0, 0.0), (ramp_s, torque_nm)])


def soft_hand(ramp_s: float) -> ImpedanceHand:
    return ImpedanceHand(
        stiffness_nm_per_rad=0.7,
        damping_nm_s_per_rad=5e-3,
        inertia_kg_m2=1e-5,
        intended_angle_rad=[(0.0, 0.0), (ramp_s, AT_RAD + WEIGHT_NM / 0.7)],
    )


def late_rad(options: list[LoopOptions]) -> float:
    """Give the widest swing after 2 s or 6 s."""
    return max(max(one.before_rad, one.swing_rad) for one in measure(options, after_s=6.0))


def widest_visit_rad(
    *,
    plant: PlantParams = PLANT,
    told: dict[str, float] | None = None,
    straight: bool = False,
    soft: bool = False,
) -> float:
    """Visit soft walls with a weight or in a soft hand."""
    return late_rad(
        [
            loop(
                Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=stiffness),
                soft_hand(ramp_s) if soft else weight(WEIGHT_NM, ramp_s),
                plant=plant,
                told=told,
                straight=straight,
            )
            for stiffness, ramp_s in itertools.product((1.0, 1.5, 2.0, 2.5, 3.0), RAMPS_S)
        ]
    )


def widest_rad(motions: list[Motion]) -> float:
    return max(motion.swing_rad for motion in motions)


SOFTENING = replace(PLANT, shaft_hardening=ShaftHardening(knee_rad=5e-3, stiffness_factor=0.5))


@pytest.mark.parametrize("factor", [1.05, 1.1, 1.2, 1.3])
def test_shaft_that_is_told_too_stiff_makes_no_soft_wall_swing(factor: float) -> None:
    told = {"spring_stiffness_nm_per_rad": factor}
    assert widest_visit_rad(told=told) < LASTING_RAD
    assert widest_visit_rad(told=told, soft=True) < LASTING_RAD


@pytest.mark.parametrize("factor", [0.5, 0.7, 1.3, 2.0])
@pytest.mark.parametrize(
    "name",
    ["brake_inertia_kg_m2", "brake_drag_nm", "brake_time_constant_s", "knob_coulomb_nm"],
)
def test_brake_that_is_told_wrong_makes_no_soft_wall_swing(name: str, factor: float) -> None:
    assert widest_visit_rad(told={name: factor}) < LASTING_RAD


@pytest.mark.parametrize("gives", [1.1, 1.3])
def test_brake_that_gives_more_than_it_is_told_makes_no_soft_wall_swing(gives: float) -> None:
    coil = Electrics()
    board = replace(
        BoardConfig(),
        motor_current_continuous_a=BoardConfig().motor_current_max_a,
        brake_torque_constant_nm_per_a=coil.coil_torque_constant_nm_per_a / gives,
    )
    walls = [
        loop(
            Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=stiffness),
            weight(WEIGHT_NM, 0.1),
            plant=replace(PLANT, electrics=coil),
        )
        for stiffness in (1.0, 2.0, 3.0)
    ]
    assert widest_rad(measure([replace(wall, board=board) for wall in walls])) < LASTING_RAD


def test_shaft_that_softens_and_is_told_straight_makes_no_soft_wall_swing() -> None:
    assert widest_visit_rad(plant=SOFTENING, straight=True) < LASTING_RAD


@pytest.mark.parametrize("loop_nm", [5.5e-3, 11e-3])
def test_hysteresis_that_is_told_as_it_is_makes_no_soft_wall_swing(loop_nm: float) -> None:
    plant = replace(PLANT, brake_hysteresis=BrakeHysteresis(half_width_nm=loop_nm))
    assert widest_visit_rad(plant=plant) < LASTING_RAD


@pytest.mark.parametrize("share", [0.6, 0.75, 0.85])
def test_weight_on_a_spring_with_a_limit_comes_to_rest(share: float) -> None:
    springs = itertools.product((10.0, 100.0, 1000.0), (40e-3, 80e-3, 120e-3), RAMPS_S)
    swing_rad = late_rad(
        [
            loop(
                Spring(angle_rad=0.02, stiffness_nm_per_rad=stiffness, torque_limit_nm=limit_nm),
                weight(share * min(limit_nm, PLANT.motor_limit_nm), ramp_s),
            )
            for stiffness, limit_nm, ramp_s in springs
        ]
    )
    assert swing_rad < LASTING_RAD


@pytest.mark.parametrize("counts", [2048, 8192, 32_768, 131_072])
def test_knob_that_rests_in_a_stiff_wall_is_silent(counts: int) -> None:
    plant = replace(PLANT, counts_per_rev=counts)
    held = [
        loop(
            Wall(angle_rad=AT_RAD + place * 2.0 * math.pi / counts, stiffness_nm_per_rad=stiffness),
            hand,
            plant=plant,
        )
        for stiffness, torque_nm, place in itertools.product(
            (30.0, 100.0, 300.0, 1000.0), (20e-3, 40e-3, 60e-3, 75e-3), (0.0, 0.5)
        )
        for hand in (
            weight(torque_nm, 0.3),
            ImpedanceHand(
                stiffness_nm_per_rad=10.0,
                damping_nm_s_per_rad=0.02,
                inertia_kg_m2=5e-6,
                intended_angle_rad=[(0.0, 0.0), (0.3, AT_RAD + torque_nm / 10.0)],
            ),
        )
    ]
    assert max(motion.loud_nm for motion in measure(held)) < QUIET_NM


@pytest.mark.parametrize("counts", [2048, 8192, 131_072])
def test_noisy_encoder_makes_no_motor_hum(counts: int) -> None:
    """Each count that it flips is another torque of scene and sensor."""
    noisy = [
        loop(
            Spring(angle_rad=AT_RAD, stiffness_nm_per_rad=stiffness),
            weight(torque_nm, 0.1),
            plant=replace(PLANT, counts_per_rev=counts, encoder_noise_counts=noise_counts),
        )
        for stiffness, torque_nm, noise_counts in itertools.product(
            (3.0, 30.0, 300.0), (5e-3, 40e-3), (0.05, 0.3)
        )
    ]
    assert max(motion.loud_nm for motion in measure(noisy)) < QUIET_NM


def test_hand_that_shakes_the_knob_in_a_wall_loses_half_a_jnd_at_most() -> None:
    """Its turns are as quick as swings of the sensor's, so they cost the trust."""
    times_s = np.arange(0.0, 2.0, 2e-3)
    angles_rad = 0.015 - 0.03 * np.cos(2.0 * math.pi * 5.0 * times_s)
    wall = Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=1.7)
    hand = PrescribedMotion(angle_rad=np.column_stack([times_s, AT_RAD + angles_rad]))
    rows = ClosedLoop(loop(wall, hand)).run(duration_s=1.9)
    missed_nm = rows["motor_torque_nm"] + rows["spring_torque_nm"] - rows["desired_torque_nm"]
    period = 4000
    first_nm, last_nm = (
        np.sqrt(np.mean(of**2)) for of in (missed_nm[:period], missed_nm[-period:])
    )
    assert first_nm < last_nm < 0.5 * TORQUE_JND_NM


def test_hand_that_trembles_leaves_a_wall_as_stiff_as_it_was() -> None:
    """It moves the knob to and fro within the play of a held count, and beyond."""
    stiffness, hand_nm_per_rad, lean_nm = 50.0, 2.0, 40e-3
    there_rad = AT_RAD + lean_nm / hand_nm_per_rad + lean_nm / stiffness
    times_s = np.arange(0.5, 8.0, 1e-3)
    trembles = there_rad + 3e-3 * np.sin(2.0 * np.pi * 10.0 * times_s)
    trembling = zip(times_s.tolist(), trembles.tolist(), strict=True)
    path = [(0.0, 0.0), (0.4, there_rad), *trembling, (8.0, there_rad)]
    hand = ImpedanceHand(
        stiffness_nm_per_rad=hand_nm_per_rad,
        damping_nm_s_per_rad=2e-2,
        inertia_kg_m2=3e-6,
        intended_angle_rad=path,
    )
    wall = Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=stiffness)
    plant = replace(PLANT, counts_per_rev=131_072)
    rows = ClosedLoop(loop(wall, hand, plant=plant)).run(duration_s=10.0, record_every=10)
    time_s, deep_rad = rows["time_s"], rows["angle_rad"] - AT_RAD
    before_rad = np.mean(deep_rad[(time_s > 0.42) & (time_s < 0.5)])
    after_rad = np.mean(deep_rad[time_s > 9.0])
    assert stiffness * abs(after_rad - before_rad) < TORQUE_JND_NM


@pytest.mark.parametrize(("counts", "inertia_kg_m2"), [(2048, 2e-5), (8192, 5e-5), (4096, 5e-5)])
def test_inertia_alone_does_not_turn_a_knob(counts: int, inertia_kg_m2: float) -> None:
    plant = replace(PLANT, counts_per_rev=counts, knob_coulomb_nm=3e-3, brake_drag_nm=4e-3)
    thrown = loop(
        Inertia(inertia_kg_m2=inertia_kg_m2), NoHand(), plant=plant, told={"brake_drag_nm": 2.0}
    )
    thrown = replace(thrown, initial=InitialState(speed_rad_s=3.0))
    assert measure([thrown], after_s=6.0)[0].swing_rad == 0.0


@pytest.mark.parametrize("factor", [1.25, 1.3])
def test_help_in_free_air_turns_no_knob_for_ever(factor: float) -> None:
    plant = replace(PLANT, knob_viscous_nm_s_per_rad=1.3e-5, brake_drag_nm=1e-3)
    thrown = loop(
        Wall(angle_rad=AT_RAD, stiffness_nm_per_rad=10.0),
        NoHand(),
        plant=plant,
        told={"knob_coulomb_nm": factor, "brake_drag_nm": 2.0},
    )
    most = replace(thrown.control, free_assist_nm=20e-3)
    thrown = replace(thrown, control=most, initial=InitialState(speed_rad_s=10.0))
    assert measure([thrown], after_s=20.0)[0].swing_rad == 0.0


@pytest.mark.parametrize(("gap_rad", "drag_nm"), [(0.4, 1.35e-3), (2.6, 0.72e-3)])
def test_help_between_stops_drives_no_knob_to_and_fro(gap_rad: float, drag_nm: float) -> None:
    plant = replace(
        PLANT,
        knob_inertia_kg_m2=4.7e-5,
        knob_viscous_nm_s_per_rad=1.55e-5,
        knob_coulomb_nm=9e-3,
        brake_drag_nm=drag_nm,
    )
    thrown = loop(
        EndStops(lower_rad=0.0, upper_rad=gap_rad, stiffness_nm_per_rad=50.0),
        NoHand(),
        plant=plant,
        told={"knob_coulomb_nm": 1.3, "brake_drag_nm": 2.0},
    )
    most = replace(thrown.control, free_assist_nm=20e-3)
    at = InitialState(angle_rad=0.5 * gap_rad, speed_rad_s=2.1)
    assert measure([replace(thrown, control=most, initial=at)], after_s=60.0)[0].swing_rad == 0.0


@pytest.mark.parametrize(("number", "values"), FOUND)
def test_what_the_search_found_comes_to_rest(number: int, values: tuple[float, ...]) -> None:
    """Swings that hide turns, are wide and narrow by turns, or nearly as slow as a hand.

    And motors that answer their own sensor, an encoder's noise in a soft hand, or a brake's drag
    that they cancel on one side of an edge or from a flung knob. And weights that rolled over
    detents.
    """
    case, options = found(number, values)
    assert not breaks(case, confirm(case, options))


def test_weight_of_two_thirds_of_a_detent_rolls_over_it_only_if_beliefs_are_wrong() -> None:
    """It swings by what the sensor is told wrong, and so comes over the next detent."""
    case, options = found(*ROLLS)
    right = replace(options, actuator=None)
    without_sensor = replace(options, control=replace(options.control, law="motor_only"))
    motions = measure([options, right, without_sensor])
    assert [breaks(case, motion) for motion in motions] == [True, False, False]


def test_spring_below_the_limits_of_the_search_swings_if_drag_is_told_double() -> None:
    plant = replace(PLANT, knob_coulomb_nm=1e-3)
    spring = Spring(angle_rad=AT_RAD, stiffness_nm_per_rad=30.0, torque_limit_nm=5e-3)
    visits = [
        loop(spring, weight(4.25e-3, 0.1), plant=plant, told={"brake_drag_nm": factor})
        for factor in (1.0, 1.5, 2.0)
    ]
    swings = [motion.swing_rad > LASTING_RAD for motion in measure(visits, after_s=6.0)]
    assert swings == [False, False, True]


def test_some_that_the_search_found_last_under_the_law_compensated() -> None:
    """It has neither bound nor trust, so what is found can tell laws apart."""
    lasting = 0
    for number, values in FOUND[:4]:
        case, options = found(number, values)
        compensated = replace(options, control=replace(options.control, law="compensated"))
        lasting += breaks(case, measure([compensated])[0])
    assert lasting > 0


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        *(("brake_drag_nm", factor) for factor in (0.5, 0.7, 1.0, 1.2)),
        ("brake_inertia_kg_m2", 0.77),
        ("spring_stiffness_nm_per_rad", 1.3),
    ],
)
def test_knob_rests_under_a_constant_torque_below_its_friction(name: str, factor: float) -> None:
    right = PLANT.matching_config()
    actuator = replace(right, **{name: factor * getattr(right, name)})
    thrown = [
        LoopOptions(
            scene=Curve(angle_rad=500.0, span_rad=0.3, torque_nm=[torque_nm, torque_nm, 0.0, 0.0]),
            initial=InitialState(speed_rad_s=8.0),
            plant=PLANT,
            actuator=actuator,
            control=ControlConfig(law="calibrated"),
            control_period_ns=50_000,
        )
        for torque_nm in (2e-3, 4e-3, 5.5e-3)
    ]
    motions = measure(thrown)
    assert widest_rad(motions) < LASTING_RAD
    assert max(motion.loud_nm for motion in motions) < QUIET_NM
