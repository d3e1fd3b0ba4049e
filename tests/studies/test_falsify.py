"""The search that tries to break the law, and what it has found."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import torsio
from torsio.apps.doctor.examination import UNEXPECTED_SWINGS
from torsio.closed_loop import ClosedLoop
from torsio_studies.common import StudyError
from torsio_studies.execution import execute
from torsio_studies.falsify.cases import HANDS, SCENES, SPACE, batches, options_of, values_of
from torsio_studies.falsify.search import LASTING_RAD, begin, measure, search


def test_cases_have_every_scene_in_every_hand_and_depend_on_their_number_only() -> None:
    few = [batch.designs[0] for batch in batches(28, 32, "calibrated")]
    assert {(case.scene, case.hand) for case in few} == {(s, h) for s in SCENES for h in HANDS}
    more = [batch.designs[0] for batch in batches(40, 32, "calibrated")]
    assert more[:28] == few


def test_corners_of_the_space_can_all_be_simulated() -> None:
    for corner in (0.0, 1.0):
        value = values_of(np.full(len(SPACE), corner))
        for (name, span), found in zip(SPACE.items(), value.values(), strict=True):
            assert found == pytest.approx(span[int(corner)]), name
        for batch in batches(28, 32, "calibrated"):
            options = options_of(batch.designs[0], value)
            assert measure([options], after_s=0.6)[0].swing_rad >= 0.0


def test_knob_that_is_not_watched_to_the_end_stays_where_it_is() -> None:
    random = np.random.default_rng(0)
    for batch in batches(28, 32, "calibrated"):
        options = options_of(batch.designs[0], values_of(random.uniform(size=len(SPACE))))
        found = measure([options])[0]
        loop, now_s = begin(options)
        loop.run(duration_s=1.8 - now_s, record_every=1000)
        moved = np.ptp(loop.run(duration_s=0.2)["angle_rad"])
        assert found.swing_rad == pytest.approx(moved, abs=1e-2 * LASTING_RAD)


def test_host_of_a_search_moves_its_scene_or_its_stream() -> None:
    value = values_of(np.full(len(SPACE), 0.7))
    cases = [batch.designs[0] for batch in batches(200, 32, "calibrated")]
    moved = [case for case in cases if case.frame_s and case.also != "stream"]
    for case in moved:
        options = options_of(case, value)
        loop, now_s = begin(options)
        assert now_s == pytest.approx(0.3)
        assert loop.options.scene != options.scene
        still = options_of(replace(case, frame_s=0.0), value)
        assert loop.options.scene == still.scene
    for case in cases:
        if case.also == "stream":
            options = options_of(case, value)
            loop, now_s = begin(options)
            alone = ClosedLoop(options)
            alone.run(duration_s=now_s)
            asked_nm, without_nm = (
                one.run(duration_s=0.1)["desired_torque_nm"] for one in (loop, alone)
            )
            assert np.any(asked_nm != without_nm)
    assert {case.frame_s for case in moved} == {1e-3, 4e-3, 16e-3}


def test_search_finds_that_a_law_without_a_bound_buzzes() -> None:
    """Known swings: a stiff spring, and a motor that answers late."""
    for batch in batches(28, 64, "compensated"):
        case = batch.designs[0]
        if (case.scene, case.hand) == ("spring", "thrown"):
            found = search(case, batch.tries)
            assert found["breaks"] == 1.0
            assert found["work_w"] > 0.0


@pytest.mark.filterwarnings("ignore::torsio.SceneWarning")
def test_device_that_is_told_the_truth_hardly_ever_counts_a_swing() -> None:
    """Without a look at the scene's steepness every sixth would."""
    random = np.random.default_rng(5)
    counts = []
    for batch in batches(120, 32, "calibrated"):
        case = replace(
            batch.designs[0], noisy=False, extra="nothing", leaves=False, helps=False, simple=False,
            also="nothing", frame_s=0.0,
        )  # fmt: skip
        if case.hand == "thrown":
            continue
        # Only what the first searches moved are its draws.
        point = np.append(random.uniform(size=len(SPACE) - 9), np.zeros(9))
        value = values_of(point)
        options = options_of(case, {k: 1.0 if "told." in k else v for k, v in value.items()})
        assert options.actuator is not None
        assert options.scene is not None
        emulator = torsio.EmulatorOptions(
            plant=options.plant, hand=options.hand, control_rate_hz=case.rate_hz
        )
        with torsio.open("emulated", emulator=emulator) as knob:
            knob.configure(options.actuator)
            knob.configure(options.plant.matching_shaft())
            knob.update(law="calibrated", beta=options.control.beta)
            knob.play(options.scene)
            knob.arm()
            knob.record(2.5)
            counts.append(knob.health().unexpected_swings)
    assert len(counts) == 90
    assert np.count_nonzero(counts) <= 3, counts
    assert max(counts) < UNEXPECTED_SWINGS


def test_study_goes_on_from_its_results_and_writes_the_documented_keys(tmp_path: Path) -> None:
    settings = {"cases": 2, "tries": 32, "workers": 1}
    for _ in range(2):
        results = execute("falsify", json_file=tmp_path / "f.json", out=tmp_path, settings=settings)
        assert results["tries"] == 64
        assert results["searches"] == 2
    page = (Path(__file__).parents[2] / "docs" / "results" / "falsify.md").read_text()
    written = json.loads((tmp_path / "f.json").read_text())
    assert [key for key in written["worst"][0] if f"`{key}`" not in page] == []
    with pytest.raises(StudyError, match="other settings"):
        execute("falsify", out=tmp_path, settings={**settings, "tries": 48})
