"""Counter-examples that were found against the law `calibrated`: all but two rest.

Each has beliefs, a brake, a scene or an encoder with which a knob once swung or buzzed for ever.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from torsio import (
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
from torsio.printed.plant import BrakeHysteresis, ShaftHardening
from torsio.printed.scenes import Effect
from torsio_studies.falsify.cases import GAPS_RAD, SPACE, Case, batches, options_of
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


def visits(
    *,
    plant: PlantParams = PLANT,
    told: dict[str, float] | None = None,
    straight: bool = False,
    soft: bool = False,
) -> list[Motion]:
    """Visit soft walls with a weight or in a soft hand."""
    return measure(
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
    assert widest_rad(visits(told=told)) < LASTING_RAD
    assert widest_rad(visits(told=told, soft=True)) < LASTING_RAD


@pytest.mark.parametrize("factor", [0.5, 0.7, 1.3, 2.0])
@pytest.mark.parametrize(
    "name",
    ["brake_inertia_kg_m2", "brake_drag_nm", "brake_time_constant_s", "knob_coulomb_nm"],
)
def test_brake_that_is_told_wrong_makes_no_soft_wall_swing(name: str, factor: float) -> None:
    assert widest_rad(visits(told={name: factor})) < LASTING_RAD


def test_shaft_that_softens_and_is_told_straight_makes_no_soft_wall_swing() -> None:
    assert widest_rad(visits(plant=SOFTENING, straight=True)) < LASTING_RAD


@pytest.mark.parametrize("loop_nm", [5.5e-3, 11e-3])
def test_hysteresis_that_is_told_as_it_is_makes_no_soft_wall_swing(loop_nm: float) -> None:
    plant = replace(PLANT, brake_hysteresis=BrakeHysteresis(half_width_nm=loop_nm))
    assert widest_rad(visits(plant=plant)) < LASTING_RAD


@pytest.mark.parametrize("share", [0.6, 0.75, 0.85])
def test_weight_on_a_spring_with_a_limit_comes_to_rest(share: float) -> None:
    springs = itertools.product((10.0, 100.0, 1000.0), (40e-3, 80e-3, 120e-3), RAMPS_S)
    motions = measure(
        [
            loop(
                Spring(angle_rad=0.02, stiffness_nm_per_rad=stiffness, torque_limit_nm=limit_nm),
                weight(share * min(limit_nm, PLANT.motor_limit_nm), ramp_s),
            )
            for stiffness, limit_nm, ramp_s in springs
        ]
    )
    assert widest_rad(motions) < LASTING_RAD


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


# Numbers of searches, and where they ended: the first values of `SPACE` in their order. Some
# searches hung more than half on detents, so a weight may exceed 1.
FOUND = (
    (2, (1.28, 1.01, 0.504, 1.18, 1.51, 0.695, 0.941, 0.781, 0.841, 1.12, 0.864, 1.3, 0.812, 1.02,
         0.858, 0.644, 0.00138, 0.00421, 1.23, 0.000186, 0.48, 0.0894, 0.771, 1.54, 0.721, 13.3,
         0.103, 2.94e-06, 0.372)),
    (3, (1.8, 1.7, 1.41, 1.13, 0.531, 1.27, 1.27, 0.965, 0.875, 1.1, 0.869, 1.23, 0.806, 1.21,
         0.892, 0.541, 0.000772, 0.00431, 1.45, 0.00151, 511, 0.106, 0.73, 1.12, 0.117, 4.59, 3.27,
         9.08e-07, 0.0366)),
    (8, (1.292, 0.5586, 0.7892, 1.97, 1.639, 1.156, 0.5164, 0.8815, 0.7693, 0.8663, 1.288, 1.272,
         0.9534, 0.7695, 0.6994, 1.989, 0.005919, 0.007685, 1.201, 0.000257, 330.3, 0.07847, 0.66,
         1.237, 0.2118, 17.93, 0.3422, 1.123e-06, 0.3073)),
    (8, (0.561, 0.522, 0.819, 1.5, 1.81, 0.884, 1.96, 1.05, 1.1, 1.3, 1.3, 0.776, 0.867, 0.823,
         0.5, 1.5, 0.0001, 0.00323, 0.682, 1.52e-05, 322, 0.0473, 0.334, 1.8, 0.129, 3.8, 1.08,
         1.48e-06, 0.0406)),
    (3, (0.61767, 1.2966, 1.1075, 1.2141, 0.55376, 0.98016, 0.89902, 1.6748, 1.0157, 1.2221,
         1.0569, 1.2291, 0.94824, 0.77733, 0.80313, 1.5596, 0.00021986, 0.017419, 0.71523,
         2.6558e-05, 0.42364, 0.1249, 0.8649, 1.0088, 0.1101, 2.6578, 0.20209, 6.9222e-07,
         0.069577)),
    (13, (1.4594, 1.095, 0.50212, 1.7775, 0.65151, 0.63726, 1.1242, 1.9779, 1.165, 1.1159, 1.1273,
         0.90222, 0.91854, 1.1822, 0.5817, 1.7202, 0.0018888, 0.0041462, 1.1081, 6.6824e-05,
         2.0605, 0.1156, 0.42239, 1.1603, 0.080905, 1.1119, 0.39616, 4.3738e-06, 0.22306)),
    (31, (1.7106, 0.60586, 1.9625, 1.9286, 0.8118, 0.55295, 0.58851, 0.60772, 0.92162, 1.3,
         1.2536, 0.95556, 0.94737, 0.79098, 0.514, 1.551, 0.0044714, 0.024431, 0.50098,
         0.00080391, 0.35442, 0.02771, 0.43614, 1.3863, 0.11752, 3.2499, 0.19924, 4.2737e-06,
         0.025899)),
    (34, (0.50673, 0.82348, 1.5123, 1.9382, 0.5075, 0.50115, 1.2011, 0.54601, 1.2193, 1.3, 1.2671,
         1.075, 1.1361, 1.0133, 0.87959, 0.53144, 0.00036477, 0.0067411, 0.5098, 0.0014789,
         914.44, 0.027444, 0.33219, 1.0076, 0.440328, 1.1381, 0.14875, 1.6288e-06, 0.32039)),
    (40, (0.66468, 0.80822, 0.94856, 0.50602, 1.1078, 1.0401, 1.7534, 1.6318, 0.81685, 1.1272,
         0.86303, 0.84546, 0.83398, 1.1115, 1.2113, 1.5401, 0.009147, 0.0031987, 1.1601,
         2.9226e-05, 11.287, 0.09147, 0.61885, 1.6866, 0.11597, 7.6731, 0.23785, 7.2277e-07,
         0.084762)),
    (2, (0.8838, 0.67548, 1.5362, 1.7004, 0.9747, 0.95707, 0.51084, 1.7488, 1.2798, 1.1228,
         0.92542, 1.0977, 0.76982, 1.0659, 0.50503, 1.9197, 0.00015716, 0.0030107, 1.9823,
         0.00064256, 54.729, 0.087902, 0.77081, 1.1846, 0.63934, 6.6487, 0.23469, 2.5671e-06,
         0.21192)),
    (3, (1.8844, 0.50497, 0.89191, 1.8949, 1.0682, 1.7934, 1.993, 1.6856, 1.2145, 1.1476,
         0.92706, 1.1423, 0.8527, 0.83354, 0.75172, 1.9975, 0.00019124, 0.018582, 0.77399,
         0.00033145, 500.89, 0.19267, 0.30407, 1.4677, 0.95309, 5.9491, 0.34566, 2.0488e-06,
         0.089971)),
    (9, (1.0049, 0.53591, 0.63975, 1.588, 1.3926, 1.558, 1.624, 1.0159, 1.0631, 0.77588,
         1.2405, 0.8701, 0.96159, 0.97791, 0.71387, 0.80659, 0.00029852, 0.024237, 1.0758,
         0.0010832, 6.0945, 0.14924, 0.86265, 1.3406, 0.15721, 3.026, 1.3426, 4.1527e-06,
         1.941)),
    (15, (1.0354, 0.66541, 0.71163, 0.65951, 1.9543, 1.7998, 0.89183, 0.71097, 0.87814,
         1.2593, 0.77587, 1.0959, 1.1392, 0.7693, 0.92293, 1.1066, 0.00020163, 0.004606, 0.71209,
         0.00284, 22.494, 0.041531, 0.75704, 1.23, 0.22867, 11.238, 0.11017, 2.1301e-06,
         0.020458)),
    (88, (0.9316, 0.5009, 0.8972, 1.401, 0.5165, 1.859, 0.858, 1.362, 1.264, 1.142, 1.161,
         0.8053, 0.8969, 0.8328, 0.5126, 1.271, 0.01024, 0.04892, 0.6827, 0.00204, 0.3001,
         0.03975, 0.3405, 1.407, 0.4856, 16.57, 1.992, 1.244e-06, 0.1603)),
    (250, (0.94752, 0.73287, 1.9878, 1.138, 0.76889, 0.51759, 0.56145, 1.0385, 1.2167, 1.0067,
         0.93361, 1.2481, 0.82494, 1.0367, 0.52407, 1.36, 0.00025781, 0.015455, 0.6006,
         0.00032351, 181.94, 0.13797, 0.61088, 1.0292, 0.95814, 1.0861, 2.8604, 1.7087e-06,
         1.3399)),
    (991, (0.9864, 1.469, 0.7349, 1.522, 0.5489, 0.5056, 1.263, 1.949, 1.068, 1.114, 1.3,
         1.199, 0.8717, 1.27, 0.7034, 0.6844, 0.007296, 0.00302, 0.5034, 0.0002042, 0.352,
         0.1042, 0.3805, 1.606, 0.3177, 2.118, 0.1104, 3.923e-06, 0.268)),
    (1310, (1.17868, 0.655269, 1.99832, 1.86939, 0.647448, 0.628935, 0.66007, 1.76083,
         0.942644, 1.09929, 1.29226, 0.769305, 1.20611, 1.04945, 0.739162, 1.8991, 0.00923651,
         0.0499824, 0.694035, 1.0113e-05, 0.74018, 0.0273881, 0.331451, 1.00405, 0.649718,
         15.8714, 0.49413, 6.56476e-07, 0.110762)),
    (1393, (1.0087, 0.64798, 1.5202, 1.9296, 1.589, 1.8804, 1.6852, 0.80247, 0.98511, 1.2982,
         1.2135, 1.2688, 1.2831, 1.294, 0.81934, 1.1883, 0.0087051, 0.037939, 1.1763,
         0.0005374, 0.36602, 0.031344, 0.30565, 1.6833, 0.970312, 13.406, 1.3793, 2.562e-06,
         0.024698)),
    (183, (1.1337, 0.649644, 0.545482, 1.43547, 1.98616, 0.500159, 0.713453, 0.531958, 0.828519,
         0.71418, 0.708861, 0.915081, 1.15316, 0.744674, 1.54596, 1.79021, 0.000554354, 0.0057543,
         0.638156, 0.000459384, 18.8879, 0.197502, 0.895588, 1.39166, 0.315276, 0.917013, 4.82275,
         4.56595e-06, 0.1732, 1.1489, 0.809119, 0.297786)),
    (2162, (1.9994, 0.810866, 0.549463, 0.637464, 0.519883, 0.503236, 0.78916, 1.35102, 1.14622,
         0.930193, 1.24092, 0.702203, 0.849199, 1.27327, 1.98149, 0.65239, 0.00026918, 0.00367692,
         1.9639, 1.93514e-05, 12.4925, 0.0676234, 0.898525, 1.47864, 1.394939, 1.3731, 2.16755,
         1.43557e-06, 0.0434523, 1.07953, 1.20503, 0.054489)),
    (1880, (1.1985416, 1.6283968, 0.62395014, 1.5525735, 1.2706404, 1.5648914, 0.80649123,
         1.750168, 0.96047465, 1.2930486, 1.2725238, 0.76928659, 0.91628439, 0.82163659,
         0.6438353, 1.1421155, 0.00010042423, 0.014277276, 0.92591893, 9.5410774e-05, 64.280721,
         0.063174778, 0.6981187, 1.1567858, 0.14494761, 13.553395, 5.6855624, 3.2426555e-06,
         1.0418734)),
    (1180, (1.57925, 1.1095, 0.714595, 1.10723, 0.505419, 0.708907, 1.27387, 1.19035, 1.1828,
         1.09367, 1.18326, 1.12844, 0.972811, 1.00538, 0.897585, 1.2196, 0.000105953, 0.0468013,
         1.27441, 5.29588e-05, 4.67571, 0.0551702, 0.578161, 1.11245, 0.135931, 15.9533, 6.00501,
         1.63173e-06, 0.731702)),
    (13, (1.035240225, 1.821711874, 0.6446400864, 1.075053415, 0.5848011394, 1.225062041,
         1.273040985, 1.111430241, 1.121911969, 1.005510676, 0.8352499301, 0.853363136,
         0.7708268936, 1.151308225, 0.9604004736, 1.204082091, 0.002762987499, 0.03601044184,
         1.438607032, 0.0002357918092, 291.0147746, 0.07078727769, 0.6824145172, 1.345165797,
         0.07667213569, 0.3019569973, 1.888574173, 1.140535394e-06, 0.4737901785, 0.8093922478,
         0.7447785791, 0.08753730132, 0.1903998807)),
    (63, (1.640340238, 1.107413328, 1.007461193, 1.20938701, 0.9044240773, 1.321899844, 1.654481766,
         1.803823024, 0.9999640682, 1.038147379, 1.180235797, 0.7321282947, 0.80219309, 0.780798842,
         0.6730069465, 1.773797205, 0.01009205909, 0.007875719366, 1.62439758, 1.101982113e-05,
         873.9027406, 0.02907332489, 0.5716151992, 1.536975208, 0.05612781195, 6.261735394,
         7.330326251, 1.010079372e-06, 0.03950853587, 0.8044308883, 0.7968790543, 0.02639707214,
         0.9978081381)),
    (112, (1.598774867, 0.957545926, 0.6978796932, 0.8311535813, 1.870192839, 1.753145518,
         1.652754296, 1.570406379, 1.118694187, 0.7007705695, 1.134731667, 0.7369210781,
         1.003987048, 0.8118387249, 1.816351206, 0.6477054736, 0.0008619998513, 0.02569466117,
         1.17985897, 7.031511143e-05, 31.24260745, 0.1153418731, 0.5478143825, 1.429743452,
         0.2481587132, 2.681897819, 0.7513601776, 1.096327001e-06, 0.03865902475, 0.7493603783,
         0.9518363846, 0.09812958704, 0.01341946535)),
    (175, (1.572571072, 1.162079794, 1.00696385, 1.414509856, 0.8314954877, 0.5255007087,
         1.046868482, 1.856061138, 0.9982704025, 1.032024177, 0.7532618222, 0.8070393735,
         0.9377929204, 0.7230336523, 1.027118768, 1.284554087, 0.01067698891, 0.009943924519,
         1.248513872, 0.000329937776, 828.5966828, 0.04296911762, 0.5478077686, 1.510339963,
         0.05531277986, 6.067345857, 9.90685578, 5.111843317e-07, 0.04169661095, 1.296736705,
         0.992990013, 0.03778326311, 0.365393589)),
    (219, (1.55664661, 0.5237586277, 1.31565452, 1.003275641, 1.429403271, 0.7579508175,
         1.989651396, 1.673089024, 1.25187077, 1.261417607, 0.7109782834, 0.9401353923,
         0.8203163057, 1.133891307, 0.5310206985, 0.9151030585, 0.0001040051304, 0.01801489575,
         1.597272983, 2.313862663e-05, 44.01866189, 0.07901267652, 0.6451129583, 1.32519645,
         0.6318284359, 7.829389636, 0.1029831701, 5.148308537e-07, 0.06107777875, 0.7016760338,
         1.298020388, 0.1944000026, 0.147573046, 0.005002654497)),
    (818, (1.49954895, 0.9402665181, 0.5497673121, 0.6039973728, 1.011147703, 0.9953268623,
         1.123239477, 0.7455500587, 0.7518400527, 1.161625654, 0.9450550122, 0.7829819576,
         1.113952016, 1.299874943, 1.999877782, 0.5009778244, 0.003091613535, 0.0139158124,
         0.5000931472, 0.002546002415, 3.513438315, 0.02017200552, 0.897139496, 1.997954084,
         0.07022332533, 16.62081126, 1.871671879, 9.832196186e-07, 1.254499849, 1.289174956,
         1.244375324, 0.08721203553, 0.01029572518, 0.0398679811)),
    (285, (0.9761164315, 1.999492881, 0.5702071608, 1.860770741, 1.934335185, 0.6762396545,
         0.6244517796, 1.827727359, 0.8560511909, 1.110722307, 0.9704039476, 1.191343927,
         1.250456533, 0.7339658965, 0.9737470287, 1.17095585, 0.003290588576, 0.0100031513,
         0.5364412185, 1.378558145e-05, 136.7753678, 0.04362205022, 0.3012397687, 1.473035306,
         0.5776567987, 1.058181301, 0.200268294, 6.619764439e-07, 0.2237958941, 1.048214852,
         1.296303973, 0.05181522228, 0.9538791401, 0.01447388037)),
    (102, (0.987328927, 1.015045493, 0.6874343426, 0.871691758, 1.990672997, 0.553763697,
         0.5005090137, 0.9767048118, 1.203117596, 1.249011121, 0.982738725, 0.7009714244,
         1.264646593, 1.010863083, 1.443888289, 1.153152166, 0.001375279988, 0.007067822414,
         0.6050573465, 0.001000960137, 270.4419912, 0.113013581, 0.5791543037, 1.072508849,
         0.8384526776, 7.350480973, 2.29336835, 9.895484729e-07, 1.987073928, 1.292030966,
         0.7921227357, 0.2715924048, 0.5567888879, 0.03298396465)),
    (87, (0.9023019217, 1.521867043, 0.8475415363, 1.686168933, 0.562928053, 1.040679336,
         0.6077011224, 1.646009239, 0.7631187251, 0.7247503685, 1.128736407, 0.8362461686,
         0.9592956039, 0.7456205347, 0.8921725275, 1.47417013, 0.003563845895, 0.02428325221,
         1.499973397, 4.108328629e-05, 183.9447741, 0.05379818523, 0.3052456805, 1.281489758,
         0.5311534183, 0.9776679379, 0.2458604054, 5.067241253e-07, 0.03388249232, 1.296701804,
         0.7017425458, 0.01301883438, 0.955747816, 0.007901262015)),
    (733, (0.5361031371, 1.436844375, 0.7444209656, 1.393967448, 1.491268237, 0.5128151152,
         0.5646111732, 1.405751684, 1.082078828, 0.7629328566, 0.8190539955, 1.09380514,
         0.700207677, 1.241059487, 1.311976684, 1.307833663, 0.0001272087384, 0.02588675326,
         1.671882314, 1.018442325e-05, 301.7788447, 0.05017879593, 0.4071177792, 1.001636312,
         0.9706981319, 0.4801371988, 9.640495565, 4.21413458e-06, 0.05721156424, 1.141354425,
         1.212401933, 0.0140962289, 0.9140457219, 0.03938879539)),
    (46, (1.958707438, 0.5233066391, 0.6112807488, 1.174591693, 1.606075402, 0.7589577572,
         1.105807241, 1.723851159, 0.7000002707, 1.220669893, 1.133104481, 0.9921543622,
         0.7278325055, 1.108168587, 1.940657571, 0.6028421045, 0.007223250887, 0.008582319911,
         0.5585755827, 0.002652012744, 35.54445022, 0.02549671497, 0.4592420722, 1.611709181,
         0.4613706998, 1.836970233, 0.1022399448, 1.055093184e-06, 1.673823175, 1.277354403,
         0.9456092042, 0.04292989376, 0.1373485643, 0.03164251018)),
    (531, (0.6204108302, 0.9543856496, 1.462273725, 1.27609519, 0.6093083563, 0.503099714,
         1.039391094, 1.789297687, 1.149551742, 1.19595338, 0.7994021663, 1.151108525,
         0.8868164954, 0.9986880846, 1.005102669, 1.788038933, 0.000286894319, 0.01986758292,
         1.707846348, 0.002864656082, 79.50468502, 0.0360082523, 0.6378093443, 1.372685461,
         0.6764712504, 14.86960715, 6.397310017, 1.331769325e-06, 0.4047948535, 0.9601550129,
         0.9163452999, 0.1168259279, 0.03068078618, 0.03999493902)),
    (594, (1.121224836, 1.082934632, 0.5002509754, 0.6692029572, 0.5583475564, 0.5926581205,
         1.156210079, 1.833570021, 0.7227257416, 1.293748769, 0.9861093865, 0.7634682716,
         0.8090979836, 0.9705034147, 1.914476767, 0.5834943467, 0.01099936755, 0.007924596289,
         0.8767690209, 1.381980149e-05, 1.530685798, 0.02281044487, 0.8976306083, 1.00674462,
         0.2292954917, 0.5078683262, 0.4295441084, 1.916678356e-06, 1.337762053, 1.168042013,
         1.298310305, 0.09717857282, 0.249863267, 0.02091978317)),
    (207, (1.714072081, 1.711984905, 0.8377734516, 1.918605838, 1.696924678, 0.5664656433,
         1.046940408, 1.997722556, 0.9003539118, 1.297317513, 0.7051385497, 1.261476608,
         0.9941144123, 0.8394292929, 0.6143053338, 1.401441102, 0.0009156715164, 0.02315849568,
         1.474552036, 0.002994190151, 999.6055337, 0.02007076642, 0.5451762566, 1.00955834,
         0.6493415621, 3.719001893, 1.584269204, 9.776234827e-07, 0.03648107146, 0.9127014251,
         0.7409307796, 0.09533990711, 0.9988150896, 0.008635390532, 0.9988953113)),
    (1526, (1.965699419, 1.783837919, 0.9790266943, 1.500474906, 0.9362405695, 1.34373636,
         0.5000689282, 1.521216901, 1.179246389, 1.298920219, 0.8663638373, 1.176170832,
         1.013879049, 0.7008554228, 1.598983615, 0.657486338, 0.001457217317, 0.003066473155,
         0.7453026587, 2.417960367e-05, 43.79176397, 0.04308633583, 0.5782182859, 1.915947711,
         0.2755276157, 0.5745820474, 0.5546258314, 2.040909964e-06, 0.325177408, 0.7360999334,
         0.8394239275, 0.08294059013, 0.02455518256, 0.03921220516, 0.9331585055)),
    (1477, (0.973049934, 1.850022301, 0.5007097433, 1.999810456, 0.8569439391, 1.807833846,
         0.5005282851, 1.647892084, 0.781205505, 1.159584982, 1.287699956, 1.162194274,
         0.7461628618, 0.9628303183, 1.937537549, 1.432025077, 0.000151393897, 0.005029864197,
         0.8364098381, 0.001328930206, 999.9997159, 0.05166952153, 0.4188224928, 1.716335536,
         0.9994691413, 1.588860379, 1.300602752, 5.977799204e-07, 0.05582430397, 0.866483517,
         0.7000043389, 0.09659769362, 0.9040766607, 0.01462948516, 0.165610392)),
    (56, (1.898657586, 1.190018237, 0.5178212196, 0.9794463122, 0.6018413836, 0.5183495473,
         0.8064136621, 1.727111449, 1.238985888, 0.8210870717, 1.059642192, 0.8461496692,
         1.008440607, 0.8444414073, 0.6850409275, 1.301675206, 0.0002828060544, 0.02925179247,
         1.219738504, 7.261653212e-05, 284.1465857, 0.1049583807, 0.3020241742, 1.053200108,
         0.4160348852, 1.335306335, 1.988196551, 1.264208628e-06, 1.087777299, 1.204167321,
         0.703104775, 0.03782585477, 0.9991876681, 0.005186779809, 0.1207424238)),
    (60, (1.368799681, 1.041920905, 0.7878200372, 0.7373329395, 0.7771233796, 1.233989386,
         0.5419063872, 1.164530982, 1.099410732, 1.196011252, 0.8797873403, 0.8439475321,
         0.9693018449, 0.9912591991, 1.706678863, 0.5163363891, 0.008863709853, 0.04952047486,
         1.283928067, 4.652983961e-05, 0.3286850371, 0.03340079587, 0.8883455446, 1.990311138,
         0.8901521459, 13.80845378, 5.075234435, 1.561337355e-06, 0.04944058323, 0.7089698762,
         1.275979125, 0.0100600946, 0.5685357079, 0.02874775459, 0.8549792646)),
    (88, (1.606269504, 0.6664396489, 0.5548603513, 0.6336333625, 0.5024257886, 1.216292573,
         1.104487895, 1.976894036, 0.7001833697, 1.123516146, 0.8301660624, 1.020600625,
         0.7002919983, 1.05341631, 1.998654805, 0.6247148762, 0.009921245913, 0.008172573574,
         1.266917747, 4.536296095e-05, 1.12265126, 0.02004094924, 0.8325416454, 1.653829767,
         0.1422048834, 12.5720921, 0.391304135, 6.699768427e-07, 0.0658269347, 0.8161528078,
         0.812207426, 0.08985970049, 0.9936854864, 0.01090636108, 0.1456798187)),
    (160, (1.988755649, 1.650318863, 0.5407068029, 1.70826385, 1.998860991, 1.370332839,
         1.166157676, 0.7903622088, 1.072235681, 0.9484772669, 1.046889625, 1.189898766,
         0.799529354, 1.167504948, 1.733803642, 0.5691292053, 0.009222226271, 0.009176216211,
         0.9429741637, 0.0006491235671, 10.53413995, 0.03847619493, 0.4049846733, 1.369605327,
         0.5537847934, 15.87764547, 9.453474793, 1.687549418e-06, 0.2103626218, 0.837469053,
         0.9833192809, 0.07249967578, 0.02171894983, 0.008804943761, 0.1552989067)),
    (548, (0.7882904922, 0.883546605, 0.7920827328, 0.7257017851, 0.7895686423, 0.7278382348,
         0.5005627568, 1.531232976, 0.8583598115, 1.078172155, 0.7209292971, 1.016465627,
         1.009111958, 0.7123227615, 1.625845216, 1.96585424, 0.005971606769, 0.00713769926,
         0.9271600994, 0.002843361843, 0.3003122426, 0.1404145078, 0.6274795448, 1.641889083,
         0.1069839879, 3.703894136, 1.65620242, 7.007942954e-07, 0.2568225605, 0.7101748806,
         1.092133317, 0.1955962139, 0.9855649683, 0.005902496296, 0.9881313754)),
    (749, (0.7559279542, 0.5099680278, 0.5761264223, 1.787029219, 0.8147361527, 0.7688090241,
         0.631900689, 1.706746479, 0.7001794151, 1.017228884, 1.29895202, 0.9888285536,
         0.9633325007, 0.8237465319, 0.5297745869, 1.155918819, 0.01093596588, 0.02985423033,
         0.504170229, 0.0001778464823, 32.96196328, 0.1654363495, 0.458685228, 1.18795718,
         0.9796159298, 6.012449259, 9.780991569, 2.435569561e-06, 0.02932381213, 0.7782696619,
         1.275957397, 0.04611029088, 0.01177162858, 0.01307214264, 0.2577294572)),
    (760, (1.209388596, 0.673360196, 0.5062343416, 0.7686042144, 0.6216088283, 1.921684581,
         1.461634907, 1.9960794, 1.299891454, 1.299761607, 0.9970140652, 0.7985425477,
         0.7128516448, 1.298497246, 0.9690655778, 0.6167613821, 0.01099556294, 0.02503798486,
         1.31615951, 0.0001260577373, 1.272847044, 0.0487637662, 0.6564203073, 1.520469353,
         0.6927020227, 17.53637507, 9.921011114, 7.160119445e-07, 0.02581971081, 0.7601409507,
         1.298486334, 0.01384425553, 0.0270230926, 0.01968751109, 0.105737904)),
)  # fmt: skip


ROLLS = (
    749, (0.6560996821, 0.947263849, 1.136780867, 1.417337618, 0.977182585, 0.5237810417,
         1.18246392, 1.468529962, 1.021287098, 1.219056514, 1.286704003, 0.7276901433,
         0.8471273498, 0.9658959664, 0.7250611899, 1.985688624, 0.0074151025, 0.01375601629,
         0.5065633157, 0.0009072568962, 0.7401604853, 0.07778777317, 0.8991439707, 1.515759913,
         1.326445922, 8.563083084, 2.343344257, 4.999376197e-06, 0.4054956356, 0.8502449103,
         1.095593551, 0.03847154657, 0.2776166189, 0.01763835981),
)  # fmt: skip


def found(number: int, values: tuple[float, ...]) -> tuple[Case, LoopOptions]:
    """The first searches moved fewer values: no gains or noise, no more effects, no hand left."""
    case = list(batches(number + 1, 16, "calibrated"))[number].designs[0]
    case = replace(
        case,
        noisy=len(values) > 29 and (case.noisy or number == 13),
        extra=case.extra if len(values) > 32 else "nothing",
        leaves=case.leaves and len(values) > 33,
        helps=case.helps and len(values) > 34,
        simple=case.simple and len(values) > 34,
        gap_rad=GAPS_RAD[0],
    )
    return case, options_of(case, dict(zip(SPACE, values, strict=False)))


@pytest.mark.parametrize(("number", "values"), FOUND)
def test_what_the_search_found_comes_to_rest(number: int, values: tuple[float, ...]) -> None:
    """Swings that hide turns, are wide and narrow by turns, or nearly as slow as a hand.

    And motors that answer their own sensor, an encoder's noise in a soft hand, or a brake's drag
    that they cancel on one side of an edge or from a flung knob.
    """
    case, options = found(number, values)
    assert not breaks(case, confirm(case, options))


def test_weight_of_two_thirds_of_a_detent_rolls_over_it_only_if_beliefs_are_wrong() -> None:
    """It overshoots with the brake's side, whose swing the sensor takes for another."""
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
