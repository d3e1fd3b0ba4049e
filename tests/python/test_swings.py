"""`play` and `stream_local_model` warn of every scene that will swing.

The test tries what really swings: the knob is pushed once, let go, and looked at long after.
"""

from __future__ import annotations

import json
import math
import random
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import torsio
from tests.bench import bench_swings
from tests.bench.bench_swings import Case
from torsio.perception import VIBRATION_NM
from torsio.printed.config import Law
from torsio.printed.scenes import Effect
from torsio.stability import boundary

SWING: dict[str, list[Effect]] = {
    "detents": [torsio.Detents(per_turn=200, torque_nm=0.08)],
    "damper": [torsio.Damper(damping_nm_s_per_rad=0.15)],
    "inertia": [torsio.Inertia(inertia_kg_m2=5e-4)],
    "friction": [torsio.Friction(torque_nm=0.08, stiffness_nm_per_rad=100.0)],
    "four springs": [torsio.Spring(stiffness_nm_per_rad=1.9)] * 4,
    "spring": [torsio.Spring(stiffness_nm_per_rad=8.0)],
    "curve": [torsio.Curve(torque_nm=[0.08, -0.08], angle_rad=-0.01, span_rad=0.02)],
    "two walls": [
        torsio.EndStops(lower_rad=0.0, upper_rad=0.0, stiffness_nm_per_rad=10.0),
        torsio.Constant(torque_nm=0.01),
    ],
    "texture": [torsio.Texture(grains_per_turn=120, torque_nm=0.08, grain="sine")],
}
REST: dict[str, list[Effect]] = {
    "nothing": [],
    "detents": [torsio.Detents(per_turn=24, torque_nm=0.03)],
    "damper": [torsio.Damper(damping_nm_s_per_rad=0.04)],
    "inertia": [torsio.Inertia(inertia_kg_m2=5e-5)],
    "friction": [torsio.Friction(torque_nm=0.02)],
    "steep and weak friction": [torsio.Friction(torque_nm=0.004, stiffness_nm_per_rad=100.0)],
    "spring": [torsio.Spring(stiffness_nm_per_rad=1.9)],
    "walls that never are at one place": [
        torsio.Wall(angle_rad=0.5, stiffness_nm_per_rad=3.0),
        torsio.Wall(angle_rad=-0.5, stiffness_nm_per_rad=3.0, side="below"),
    ],
    "steep and weak spring": [torsio.Spring(stiffness_nm_per_rad=50.0, torque_limit_nm=0.004)],
    "wave": [torsio.Constant(torque_nm=0.005)],
}
LOCAL = {"stiffness_nm_per_rad": 50.0}
DAMPED = torsio.Wall(stiffness_nm_per_rad=0.1, damping_nm_s_per_rad=0.09)


def warned(do: Callable[[], object]) -> list[str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        do()
    return [str(each.message) for each in caught if each.category is torsio.StiffnessWarning]


def opened() -> torsio.Knob:
    return torsio.open("emulated", emulator=torsio.EmulatorOptions(log_truth=True))


def speed_after_push(knob: torsio.Knob, scene: list[Effect], local: dict[str, float]) -> float:
    """Push it once, at four strengths, and look 1.5 s later how it goes to and fro, rad/s RMS."""
    fastest = 0.0
    for push_nm in (0.07, 0.03, 0.12, 0.25):
        knob.play(scene)
        knob.arm()
        knob.emulator.set_hand(
            torsio.TorqueHand(torque_nm=[(0, push_nm), (0.02, push_nm), (0.02, 0)])
        )
        for _ in range(150):
            if local:
                knob.stream_local_model(**local)
            knob.sleep(0.01)
        knob.emulator.truth()
        for _ in range(50):
            if local:
                knob.stream_local_model(**local)
            knob.sleep(0.01)
        speed = knob.emulator.truth()["speed_rad_s"]
        fastest = max(fastest, math.sqrt(np.mean(speed**2)) - abs(np.mean(speed)))
        knob.disarm()
    return fastest


@pytest.mark.parametrize("name", SWING)
@pytest.mark.filterwarnings("ignore::torsio.StiffnessWarning")
def test_knob_swings_in_what_is_warned_of(name: str) -> None:
    with opened() as knob:
        assert len(warned(lambda: knob.play(SWING[name]))) == 1
        assert speed_after_push(knob, SWING[name], {}) > 0.3


@pytest.mark.parametrize("name", REST)
def test_knob_rests_in_what_is_not_warned_of(name: str) -> None:
    with opened() as knob:
        assert speed_after_push(knob, REST[name], {}) < 0.05


@pytest.mark.filterwarnings("ignore::torsio.StiffnessWarning")
@pytest.mark.parametrize("law", ["paper", "calibrated"])
def test_local_model_is_warned_of_whatever_the_law_and_rests_if_it_is_bound(law: Law) -> None:
    with opened() as knob:
        knob.update(law=law)
        knob.arm()
        assert warned(lambda: knob.stream_local_model(stiffness_nm_per_rad=0.5)) == []
        (text,) = warned(lambda: knob.stream_local_model(**LOCAL))
        assert "no law bounds" in text
        # Once, until it is more, or another scene plays.
        assert warned(lambda: knob.stream_local_model(**LOCAL)) == []
        assert len(warned(lambda: knob.stream_local_model(stiffness_nm_per_rad=60.0))) == 1
        knob.disarm()
        swings = speed_after_push(knob, [], LOCAL) > 0.3
        assert swings == (law == "paper")


def test_stiff_wall_that_the_host_moves_is_warned_of_once() -> None:
    with opened() as knob:
        knob.update(law="calibrated")
        knob.arm()

        def moved(stiffness: float, moves: int) -> list[int]:
            walls = [
                torsio.Wall(angle_rad=0.01 * n, stiffness_nm_per_rad=stiffness)
                for n in range(moves)
            ]
            return [len(warned(partial(knob.play, wall))) for wall in walls]

        assert moved(1.0, 7) == [0] * 7
        knob.play(())
        assert moved(300.0, 7) == [0, 0, 0, 0, 1, 0, 0]
        knob.play(())
        assert moved(300.0, 4) == [0] * 4
        knob.play(())
        assert sum(moved(1.0, 6) + moved(300.0, 6)) == 1
        knob.disarm()
        knob.update(law="motor_only")
        assert moved(300.0, 9) == [1] * 9


def test_local_model_adds_to_the_scene() -> None:
    half = {"stiffness_nm_per_rad": 3.0}
    with torsio.open("emulated") as knob:
        knob.arm()
        assert warned(lambda: knob.stream_local_model(**half)) == []
        knob.play(torsio.Spring(stiffness_nm_per_rad=3.0))
        assert len(warned(lambda: knob.stream_local_model(**half))) == 1
        knob.stop()
        knob.arm()
        assert warned(lambda: knob.stream_local_model(**half)) == []


@pytest.mark.parametrize("name", SWING)
@pytest.mark.filterwarnings("ignore::torsio.StiffnessWarning")
def test_calibrated_law_bounds_scenes_which_then_rest(name: str) -> None:
    with opened() as knob:
        knob.update(law="calibrated")
        assert speed_after_push(knob, SWING[name], {}) < 0.05


@pytest.mark.filterwarnings("ignore::torsio.StiffnessWarning")
@pytest.mark.parametrize(("rate_hz", "share"), [(1e3, 0.4), (5e3, 0.7), (1e4, 0.85), (2e4, 0.9)])
def test_damper_is_bounded_by_the_law_calibrated_and_by_no_other(
    rate_hz: float, share: float
) -> None:
    smooth = replace(torsio.ActuatorConfig(), knob_coulomb_nm=0.0, knob_viscous_nm_s_per_rad=0.0)
    damping_nm_s_per_rad, _ = boundary(smooth, torsio.ControlConfig(law="motor_only"), rate_hz)
    stable = damping_nm_s_per_rad[-1]  # without a spring
    turning = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (60.0, 60.0)])
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(control_rate_hz=rate_hz)) as knob:
        knob.emulator.set_hand(turning)
        given = []
        for law in ("calibrated", "motor_only"):
            knob.update(law=law)
            knob.play(torsio.Damper(damping_nm_s_per_rad=0.2))
            knob.arm()
            knob.sleep(1.0)
            given.append(-knob.record(duration_s=0.2)["desired_torque_nm"].mean())
            knob.disarm()
    assert share * stable < given[0] < stable
    assert given[1] == pytest.approx(0.2, rel=0.02)


DAMPER = torsio.Damper(damping_nm_s_per_rad=0.06)


@pytest.mark.parametrize(
    ("beside", "told", "holds"),
    [
        # The device gives of these what it can.
        ([replace(DAMPER, damping_nm_s_per_rad=0.5)], 0, True),
        ([DAMPER] * 15, 0, True),
        ([torsio.Inertia(inertia_kg_m2=2e-3)], 1, True),
        ([torsio.Inertia(inertia_kg_m2=2e-4)], 0, True),
        # A wall's damping it gives as it is asked.
        ([DAMPED], 0, True),
        ([DAMPED, DAMPER], 1, True),
        ([replace(DAMPED, damping_nm_s_per_rad=0.5)], 1, False),
    ],
)
@pytest.mark.filterwarnings("ignore::torsio.StiffnessWarning")
def test_wall_holds_a_weight_beside_all_but_a_wall_with_much_damping(
    beside: list[Effect], told: int, *, holds: bool
) -> None:
    plant = torsio.PlantParams(counts_per_rev=2048)
    options = torsio.EmulatorOptions(plant=plant, control_rate_hz=2e4, log_truth=True)
    with torsio.open("emulated", emulator=options) as knob:
        knob.update(law="calibrated")
        scene = [torsio.Wall(angle_rad=0.05, stiffness_nm_per_rad=0.35), *beside]
        assert len(warned(lambda: knob.play(scene))) == told
        knob.arm()
        knob.emulator.set_hand(torsio.TorqueHand(torque_nm=[(0.0, 0.0), (0.1, 0.065)]))
        knob.sleep(2.0)
        knob.emulator.truth()
        knob.sleep(0.3)
        assert (np.ptp(knob.emulator.truth()["angle_rad"]) < 1e-2) == holds


def test_place_does_not_matter_but_what_is_there() -> None:
    far = 2.0 * math.pi * 1e6 + 1.0
    spring = torsio.Spring(stiffness_nm_per_rad=3.0, angle_rad=far)
    with torsio.open("emulated") as knob:
        assert warned(lambda: knob.play(spring)) == []
        assert len(warned(lambda: knob.play([spring, spring]))) == 1
        # They overlap nowhere.
        other = torsio.Wall(stiffness_nm_per_rad=3.0, side="below", angle_rad=far - 1.0)
        wall = torsio.Wall(stiffness_nm_per_rad=3.0, angle_rad=far)
        assert warned(lambda: knob.play([wall, other])) == []
        assert len(warned(lambda: knob.play([wall, wall]))) == 1


@pytest.mark.parametrize("rate_hz", [1e3, 4e3, 1e4, 2e4])
@pytest.mark.parametrize(("share", "swings"), [(0.85, False), (1.2, True)])
def test_single_spring_is_warned_of_near_its_limit(
    rate_hz: float, share: float, swings: bool
) -> None:
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(control_rate_hz=rate_hz)) as knob:
        limit = knob.stable_stiffness().stiffness_nm_per_rad
        spring = torsio.Spring(stiffness_nm_per_rad=share * limit)
        texts = warned(lambda: knob.play(spring))
        assert any("may swing" in text for text in texts) == swings


@pytest.mark.parametrize("law", ["paper", "motor_only", "compensated"])
@pytest.mark.parametrize(("share", "hums"), [(0.9, False), (1.8, True)])
def test_count_that_switches_more_than_friction_hums_and_is_warned_of(
    law: Law, share: float, hums: bool
) -> None:
    plant = torsio.PlantParams(counts_per_rev=8192, motor_time_constant_s=4.4e-5)
    stiffness = 2.0 * share * plant.knob_coulomb_nm * 8192 / (2.0 * math.pi)
    case = Case([torsio.Spring(stiffness_nm_per_rad=stiffness)], plant, law, 2e4)
    _, loud_nm = bench_swings.motion_of(case, [(0.5, 1e-3 * weight) for weight in range(9, 18)])
    assert (loud_nm > VIBRATION_NM) == hums
    assert ("may hum" in bench_swings.warning_of(case)) == hums


def test_configuration_that_has_changed_is_asked_for_anew() -> None:
    stiff = torsio.Wall(stiffness_nm_per_rad=100.0, angle_rad=1.0)
    with torsio.open("emulated") as knob:
        (text,) = warned(lambda: knob.play([torsio.Constant(torque_nm=0.01), stiff]))
        assert "at 1000 Hz" in text
        assert "law 'calibrated'" in text
        knob.update(law="calibrated")
        assert warned(lambda: knob.play(stiff)) == []
        knob.update(law="paper")
        assert len(warned(lambda: knob.play(stiff))) == 1


def test_few_random_scenes_are_judged_wrongly(capsys: pytest.CaptureFixture[str]) -> None:
    bench_swings.main(["60"])
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert told["swing"] >= 10
    assert told["unwarned"] <= 1
    assert told["hum_unwarned"] <= 1
    assert told["warned"] <= 0.25 * told["rest"]


def drawn_knob(r: random.Random) -> Case:
    """Draw a knob, and springs of up to twice what it can render."""

    def times(value: float, factor: float) -> float:
        share: float = factor ** r.uniform(-1.0, 1.0)
        return value * share

    usual = torsio.PlantParams()
    plant = torsio.PlantParams(
        counts_per_rev=r.choice([400, 1024, 4096, 8192, 131072]),
        motor_time_constant_s=times(3e-4, 20.0),
        knob_inertia_kg_m2=times(usual.knob_inertia_kg_m2, 10.0),
        knob_viscous_nm_s_per_rad=times(usual.knob_viscous_nm_s_per_rad, 10.0),
        knob_coulomb_nm=times(usual.knob_coulomb_nm, 10.0),
        shaft_stiffness_nm_per_rad=times(usual.shaft_stiffness_nm_per_rad, 10.0),
    )
    stiffness = times(1.0, 30.0)
    scene: list[Effect] = [
        r.choice([
            torsio.Spring(stiffness_nm_per_rad=stiffness, torque_limit_nm=times(0.1, 30.0)),
            torsio.Wall(stiffness_nm_per_rad=stiffness, angle_rad=r.uniform(0.0, 0.3)),
            torsio.EndStops(lower_rad=-0.1, upper_rad=0.1, stiffness_nm_per_rad=stiffness),
        ])
        for _ in range(r.choice([1, 1, 2]))
    ]  # fmt: skip
    law: Law = r.choice(["paper", "motor_only", "compensated"])
    return Case(scene, plant, law, r.choice([1e3, 4e3, 2e4]))


def test_springs_that_are_judged_quickly_are_judged_as_by_the_whole_search() -> None:
    judged = set()
    for seed in range(300):
        case = drawn_knob(random.Random(seed))
        # A damper of nothing has the whole search made.
        whole = replace(case, scene=[*case.scene, torsio.Damper(damping_nm_s_per_rad=0.0)])
        found = bench_swings.warning_of(whole)
        assert bench_swings.warning_of(case) == found, f"seed {seed}"
        judged.add(bool(found))
    assert judged == {False, True}


def test_place_that_is_far_from_the_others_is_looked_at() -> None:
    steep = torsio.Curve(torque_nm=[0.08, -0.08], angle_rad=5.0, span_rad=0.02)
    with opened() as knob:
        assert warned(lambda: knob.play(steep))
