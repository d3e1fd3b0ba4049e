"""Gymnasium's environments: its own checks, and that the tasks can be done."""

from __future__ import annotations

import copy
import pickle
import re
import runpy
import subprocess
import sys
import warnings
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import torsio
from tests.python.test_extras import run
from tools.dev import environment
from torsio.common import picture
from torsio.gym import FindDetent, IdentifyShaft, KnobEnv, KnobVectorEnv, RenderWall, Task
from torsio.telemetry import LOOP_DTYPE

TREE = Path(__file__).parents[2]
TASKS: list[type[Task]] = [FindDetent, IdentifyShaft, RenderWall]


@pytest.mark.parametrize("task", TASKS)
def test_gymnasiums_own_check_passes(task: type[Task]) -> None:
    with warnings.catch_warnings():
        # It asks for a spec, which only registered environments have.
        warnings.filterwarnings("ignore", message=".*spec")
        check_env(KnobEnv(task(), render_mode="rgb_array"))


@pytest.mark.parametrize("task", TASKS)
def test_same_seed_gives_the_same_episodes_for_any_threads(task: type[Task]) -> None:
    def life(seed: int, threads: int) -> bytes:
        env = KnobVectorEnv(task(plant={"knob_coulomb_nm": (4e-3, 8e-3)}), 7, threads=threads)
        seen, _ = env.reset(seed=seed)
        rng = np.random.default_rng(5)
        told = seen.tobytes()
        for _ in range(env.task.steps + 5):
            actions = rng.uniform(-1, 1, env.action_space.shape).astype(np.float32)
            seen, reward, *_ = env.step(actions)
            assert env.observation_space.contains(seen)
            told += seen.tobytes() + reward.tobytes()
        return told

    assert life(1, 1) == life(1, 3) != life(2, 1)


def test_episodes_end_by_truncation_and_begin_with_the_next_step() -> None:
    env = KnobVectorEnv(IdentifyShaft(), 3)
    assert env.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    first, _ = env.reset(seed=3)
    nothing = np.zeros((3, 2), np.float32)
    for _ in range(env.task.steps - 1):
        _, _, terminations, truncations, _ = env.step(nothing)
        assert not terminations.any()
        assert not truncations.any()
    seen, reward, terminations, truncations, _ = env.step(nothing)
    assert truncations.all()
    assert not terminations.any()
    seen, reward, terminations, truncations, _ = env.step(nothing + 1)
    assert np.array_equal(seen, first)
    assert not reward.any()
    assert not truncations.any()


@pytest.mark.parametrize("redraw", [False, True])
def test_next_episode_has_other_knobs_only_if_they_are_redrawn(redraw: bool) -> None:
    def kept(env: KnobVectorEnv) -> list[bytes]:
        """Give what the knobs of three episodes are, and the whole course of each."""
        seen, _ = env.reset(seed=4)
        told = []
        for _ in range(3):
            told.append(env.task.hidden["octave"].tobytes() + seen.tobytes())
            for _ in range(env.task.steps):
                seen, *_ = env.step(np.full((5, 2), 0.7, np.float32))
                told[-1] += seen.tobytes()
            seen, *_ = env.step(np.zeros((5, 2), np.float32))
        return told

    first, again = (kept(KnobVectorEnv(IdentifyShaft(), 5, redraw=redraw)) for _ in range(2))
    assert first == again
    assert len(set(first)) == (3 if redraw else 1)


def test_step_before_reset_says_so() -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        KnobVectorEnv(RenderWall(), 2).step(np.zeros((2, 2), np.float32))


def episode(env: KnobVectorEnv, policy: Any, seed: int = 0) -> np.ndarray[Any, Any]:
    seen, _ = env.reset(seed=seed)
    total = np.zeros(env.num_envs)
    for _ in range(env.task.steps):
        seen, reward, *_ = env.step(policy(seen))
        total += reward
    return total


def test_wall_is_rendered_by_the_law_written_down_here_as_well_as_by_the_devices() -> None:
    def compensated(seen: Any) -> Any:
        wanted, spring = seen[:, 0], seen[:, 1]
        brake = np.where(wanted * spring >= 0, 0.5 * np.abs(wanted) * 0.085 / 0.11, 0.0)
        return np.column_stack([wanted - spring, brake])

    task = RenderWall()
    mine = episode(KnobVectorEnv(task, 64), compensated)
    laws = RenderWall().law(64, np.random.default_rng(0), "compensated")
    nothing = episode(KnobVectorEnv(task, 64), lambda seen: np.zeros((64, 2)))
    assert nothing.mean() < -5.0
    assert laws.mean() > -1.0
    assert mine.mean() == pytest.approx(laws.mean(), abs=0.2)


def test_detent_is_found_by_who_sweeps_until_something_pulls() -> None:
    found = np.zeros(32, dtype=bool)

    def sweep(seen: Any) -> Any:
        speed_rad_s, felt = 10.0 * seen[:, 1], seen[:, 2]
        found[:] |= felt > 0.2
        push = np.where(found, -0.3 * speed_rad_s, 0.3 + 0.6 * (0.6 - speed_rad_s))
        return push[:, np.newaxis]

    env = KnobVectorEnv(FindDetent(), 32)
    swept = episode(env, sweep)
    idle = episode(env, lambda seen: np.zeros((32, 1)))
    assert found.mean() > 0.5  # this simple sweep runs over some
    assert swept.mean() > 0.0 > idle.mean()


def test_shaft_is_identified_by_how_far_it_gives() -> None:
    def press(seen: Any) -> Any:
        turned = np.maximum(seen[:, 0] * 0.05, 1e-4)
        stiffness = (0.08 * 0.7 - 0.006) / turned  # less the knob's friction
        guess = np.log2(stiffness / torsio.PlantParams().shaft_stiffness_nm_per_rad)
        return np.column_stack([np.full(len(seen), 0.7), guess])

    env = KnobVectorEnv(IdentifyShaft(), 32)
    pressed = episode(env, press)
    silent = episode(env, lambda seen: np.zeros((32, 2)))
    assert pressed.mean() > 0.5 * silent.mean()
    assert pressed.mean() > -0.15


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"plant": {"mass": (1.0, 2.0)}}, "no number of PlantParams is called 'mass'; there are"),
        ({"plant": {"knob_coulomb_nm": (2.0, 1.0)}}, "is from 2 to 1, upside down"),
        ({"kinds": 0}, "kinds is 0, allowed are 1"),
        ({"plant": {"knob_coulomb_nm": (0.0, 1.0, 2.0)}}, "must be a range .*, has 3 numbers"),
        ({"stiffness_nm_per_rad": (3.0, 1.0)}, "is from 3 to 1, upside down"),
        ({"stiffness_nm_per_rad": (0.0, 1.0)}, "stiffness_nm_per_rad must be finite and > 0"),
        ({"stiffness_nm_per_rad": (1.0, np.nan)}, "stiffness_nm_per_rad must be finite, is nan"),
    ],
)
def test_bad_ranges_are_told(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(torsio.InvalidArgument, match=message):
        RenderWall(**arguments)


def test_without_gymnasium_the_line_says_how_to_install_it() -> None:
    result = run("import torsio.tasks, torsio.gym", without=("gymnasium",))
    assert result.returncode == 1
    assert "torsio.gym needs the Python package gymnasium: pip install" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"seed": [1, 2, 3]}, "3 seeds for 4 environments"),
        ({"seed": []}, "0 seeds for 4 environments"),
        ({"options": {"mask": np.ones(4, bool)}}, "unknown option mask"),
        ({"options": {"reset_mask": np.ones(3, bool)}}, r"which is a mask of shape \(3,\)"),
    ],
)
def test_reset_refuses_what_it_cannot_do(arguments: dict[str, Any], words: str) -> None:
    env = KnobVectorEnv(RenderWall(), 4)
    first, _ = env.reset(seed=[7, 0, 0, 0])
    with pytest.raises(torsio.InvalidArgument, match=words):
        env.reset(**arguments)
    again, _ = env.reset(seed=7)
    assert again.tobytes() == first.tobytes()


def test_mask_begins_some_anew_and_leaves_the_others_as_they_were() -> None:
    alone, masked = KnobVectorEnv(RenderWall(), 3), KnobVectorEnv(RenderWall(), 3)
    steps, at = RenderWall.steps, 10
    ends = []
    for env in (alone, masked):
        first, _ = env.reset(seed=3)
    push = np.ones((3, len(RenderWall.action_names)), np.float32)
    for step in range(steps + 2):
        if step == at:
            seen, _ = masked.reset(options={"reset_mask": [False, True, False]})
            assert seen[1].tobytes() == first[1].tobytes()
        one, two = alone.step(push), masked.step(push)
        assert two[0][[0, 2]].tobytes() == one[0][[0, 2]].tobytes()
        ends.append(two[3])
    assert np.array_equal(ends[steps - 1], [True, False, True])
    assert not ends[steps].any()
    for _ in range(at - 2):
        truncated = masked.step(push)[3]
    assert np.array_equal(truncated, [False, True, False])


def test_gymnasium_makes_them_by_name() -> None:
    env = gymnasium.make("torsio.gym:torsio/FindDetent-v0", kinds=1)
    assert isinstance(env.unwrapped, KnobEnv)
    many = gymnasium.make_vec("torsio/RenderWall-v0", num_envs=2)
    assert many.reset(seed=1)[0].shape == (2, len(RenderWall.observation_names))


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        (np.zeros((4, 3)), r"shape \(4, 3\), wanted is \(4, 2\)"),
        (np.zeros((1, 2)), r"shape \(1, 2\), wanted is \(4, 2\)"),
        (np.zeros(2), r"shape \(2,\), wanted is \(4, 2\): a row .* of motor, brake"),
        (np.full((4, 2), np.nan), "there is a NaN"),
        ("push", "must be an array of numbers"),
    ],
)
def test_actions_of_another_shape_are_told_and_change_nothing(actions: Any, words: str) -> None:
    env, twin = KnobVectorEnv(RenderWall(), 4), KnobVectorEnv(RenderWall(), 4)
    env.reset(seed=1)
    twin.reset(seed=1)
    with pytest.raises(torsio.InvalidArgument, match=words):
        env.step(actions)
    good = np.full((4, 2), 0.3, dtype=np.float32)
    assert env.step(good)[0].tobytes() == twin.step(good)[0].tobytes()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_used_environment_is_copied_and_goes_on_alike(copied: Any) -> None:
    noisy = {"encoder_noise_counts": (0.2, 0.4)}
    env = gymnasium.make_vec("torsio.gym:torsio/RenderWall-v0", num_envs=3, plant=noisy)
    env.reset(seed=1)

    def told(of: Any) -> list[bytes]:
        rng = np.random.default_rng(2)
        steps = (of.step(rng.uniform(-1, 1, (3, 2)).astype(np.float32)) for _ in range(600))
        return [seen.tobytes() + reward.tobytes() for seen, reward, *_ in steps]

    told(env)  # into the second episode
    twin, state = copied(env), env.state()  # type: ignore[attr-defined]
    first = told(env)
    assert told(twin) == first != told(env)
    env.set_state(state)  # type: ignore[attr-defined]
    assert told(env) == first
    with pytest.raises(torsio.InvalidArgument, match="not of 2 environments of FindDetent"):
        KnobVectorEnv(FindDetent(), 2).set_state(state)


def test_state_of_one_environment_has_its_draws_too() -> None:
    env = KnobEnv(IdentifyShaft())
    env.reset(seed=4)
    state = env.state()
    first, _ = env.reset()
    env.set_state(state)
    assert np.array_equal(env.reset()[0], first)
    for part in ({}, {"many": state["many"]}):
        with pytest.raises(torsio.InvalidArgument, match="not of 1 environments of IdentifyShaft"):
            env.set_state(part)


@pytest.mark.parametrize("angle_rad", [0.5, 4.0])
def test_picture_shows_angle_and_torques(angle_rad: float) -> None:
    state = np.zeros(1, LOOP_DTYPE)
    state["angle_rad"], state["motor_torque_nm"], state["hand_torque_nm"] = angle_rad, -0.05, 0.2
    image = picture.draw(state[0]).astype(int)
    orange, blue = picture.BARS["hand_torque_nm"], picture.BARS["motor_torque_nm"]
    rows, columns = np.nonzero((image[:240] == orange).all(axis=2))
    shown = np.arctan2(columns.mean() - 119.5, 119.5 - rows.mean())
    assert shown % (2 * np.pi) == pytest.approx(angle_rad, abs=0.02)
    assert set(np.nonzero((image == blue).all(axis=2))[1]) == set(range(60, 119))
    assert set(np.nonzero((image[250:] == orange).all(axis=2))[1]) == set(range(121, 240))


def test_video_of_an_episode_is_recorded_by_gymnasiums_own_wrapper() -> None:
    env = gymnasium.make("torsio.gym:torsio/IdentifyShaft-v0", render_mode="rgb_array")
    wrapped = gymnasium.wrappers.RenderCollection(env)
    wrapped.reset(seed=1)
    for _ in range(3):
        wrapped.step(np.ones(2, np.float32))
    frames = wrapped.render()
    assert len(frames) == 4
    assert not np.array_equal(frames[0], frames[-1])
    with pytest.raises(torsio.InvalidArgument, match="allowed are None and 'rgb_array'"):
        KnobVectorEnv(RenderWall(), 2, render_mode="human")
    assert KnobVectorEnv(RenderWall(), 2).render() is None


class _VecEnv:
    """Stands for the base class of Stable-Baselines3, whose package brings PyTorch."""

    def __init__(self, num_envs: int, observation_space: Any, action_space: Any) -> None:
        self.num_envs, self._seeds = num_envs, [7] * num_envs
        self.render_mode = self.get_attr("render_mode")[0]  # type: ignore[attr-defined]

    def _reset_seeds(self) -> None:
        self._seeds = [None] * self.num_envs  # type: ignore[list-item]

    def _get_indices(self, indices: Any) -> Any:
        return range(self.num_envs) if indices is None else indices


def test_knobs_for_stable_baselines_begin_anew_in_the_step_that_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ("stable_baselines3", "stable_baselines3.common"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    stand_in = SimpleNamespace(VecEnv=_VecEnv)
    monkeypatch.setitem(sys.modules, "stable_baselines3.common.vec_env", stand_in)
    adapter = runpy.run_path(str(TREE / "examples/learning/learn_with_sb3.py"))["SB3Knobs"]
    knobs = adapter(KnobVectorEnv(FindDetent(), 3, render_mode="rgb_array"))
    twin = KnobVectorEnv(FindDetent(), 3)
    first, _ = twin.reset(seed=7)
    assert np.array_equal(knobs.reset(), first)
    push = np.full((3, 1), 0.4, np.float32)
    for step in range(twin.task.steps):
        knobs.step_async(push)
        seen, reward, over, infos = knobs.step_wait()
        last, earned, *_ = twin.step(push)
        assert reward == pytest.approx(earned)
        assert over.all() == over.any() == (step == twin.task.steps - 1)
    assert np.array_equal(seen, first)
    assert np.array_equal([info["terminal_observation"] for info in infos], last)
    assert infos[0]["TimeLimit.truncated"]
    assert [image.shape for image in knobs.get_images()] == 3 * [(300, 240, 3)]
    assert knobs.env_is_wrapped(object, [0]) == [False]


@pytest.mark.slow
def test_stable_baselines_itself_learns_with_the_adapter() -> None:
    python, example = environment.make_learning(), TREE / "examples/learning/learn_with_sb3.py"
    told = subprocess.run(
        [python, example, "38400"], capture_output=True, text=True, check=True
    ).stdout
    assert re.search(r"total_timesteps +\| 38400 ", told)
    rewards = re.findall(r"ep_rew_mean +\| (-[\d.]+)", told)
    assert len(rewards) == 2
