"""The tasks of `torsio.tasks` as environments of Gymnasium; needs the extra ``gym``.

>>> from torsio.gym import KnobVectorEnv, RenderWall
>>> env = KnobVectorEnv(RenderWall(), num_envs=256)
>>> observations, _ = env.reset(seed=1)
>>> observations.shape
(256, 6)
"""

from __future__ import annotations

from copy import copy, deepcopy
from functools import partial
from typing import Any, ClassVar

try:
    import gymnasium
except ModuleNotFoundError as _error:
    if _error.name != "gymnasium":
        raise
    from torsio.common.extras import how_to_install

    raise ModuleNotFoundError(
        f"torsio.gym needs the Python package gymnasium: {how_to_install('gym')}", name=_error.name
    ) from None
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from torsio.batch import MOST_AT_ONCE, Knobs
from torsio.common import checks, picture
from torsio.errors import InvalidArgument
from torsio.tasks import FindDetent, IdentifyShaft, RenderWall, Task

__all__ = ["FindDetent", "IdentifyShaft", "KnobEnv", "KnobVectorEnv", "RenderWall", "Task"]

Observations = npt.NDArray[np.float32]
_LARGEST = 1e3
"""Beyond what any knob does; observations are clipped to it."""
_FRAMES_PER_S = 50
"""Pictures a second of a video, one for each step: slower than the knob."""
_REMEMBERED = ("task", "_knobs", "_steps", "_np_random", "_np_random_seed")


def _spaces(task: Task) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
    observation = gymnasium.spaces.Box(
        -_LARGEST, _LARGEST, (len(task.observation_names),), np.float32
    )
    return observation, gymnasium.spaces.Box(-1.0, 1.0, (len(task.action_names),), np.float32)


def _seen(task: Task, knobs: Knobs) -> Observations:
    seen: Observations = np.clip(task.observe(knobs.states), -_LARGEST, _LARGEST).astype(np.float32)
    return seen


class KnobVectorEnv(VectorEnv[Observations, Observations, Any]):
    """A task on many knobs, stepped together in C++.

    An episode has a fixed number of steps, and ends by truncation. The step after that begins the
    next one, ignores its actions and rewards nothing: `AutoresetMode.NEXT_STEP`.

    Parameters
    ----------
    task
        The environment keeps a copy, which draws its knobs.
    threads
        As in `torsio.batch.Knobs`.
    redraw
        Draw other knobs for each new episode, as slow as some hundred steps, and not only in
        `reset`.
    render_mode
        ``"rgb_array"`` for `render`, or None.
    """

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]
        "autoreset_mode": AutoresetMode.NEXT_STEP,
        "render_modes": ["rgb_array"],
        "render_fps": _FRAMES_PER_S,
    }

    def __init__(
        self,
        task: Task,
        num_envs: int,
        *,
        threads: int | None = None,
        redraw: bool = False,
        render_mode: str | None = None,
    ) -> None:
        """Draw the knobs when `reset` is called."""
        checks.kind("task", task, Task, "a Task")
        # A copy: the task keeps hidden values of this environment's knobs.
        self.task: Task = copy(task)
        self.num_envs: int = checks.whole("num_envs", num_envs, 1, MOST_AT_ONCE)
        seen, acts = _spaces(task)
        self.single_observation_space: gymnasium.spaces.Box = seen
        self.single_action_space: gymnasium.spaces.Box = acts
        self.observation_space: gymnasium.spaces.Space[Any] = batch_space(seen, self.num_envs)
        self.action_space: gymnasium.spaces.Space[Any] = batch_space(acts, self.num_envs)
        self._threads = checks.threads(threads)
        self._redraw = redraw
        if render_mode not in (None, "rgb_array"):
            raise InvalidArgument(
                f"render_mode is {checks.show(render_mode)}, allowed are None and 'rgb_array'"
            )
        self.render_mode = render_mode
        self._knobs: Knobs | None = None
        self._steps = np.zeros(self.num_envs, dtype=int)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Draw the knobs and begin. The same seed gives the same knobs, bit for bit.

        Parameters
        ----------
        seed
            One number for all, for the knobs are drawn together. A list has one for each
            environment; the first counts.
        options
            ``reset_mask``, of shape (num_envs,): those that begin anew, on the knobs that they had.

        Raises
        ------
        InvalidArgument
            If a list or the mask has another length, or an option is given that is unknown.
        """
        if isinstance(seed, list):
            if len(seed) != self.num_envs:
                raise InvalidArgument(
                    f"{len(seed)} seeds for {self.num_envs} environments: give one for all, or one "
                    "for each (the first counts)"
                )
            seed = seed[0]
        options = checks.table("options", options or {})
        mask = options.pop("reset_mask", None)
        if options:
            raise InvalidArgument(
                f"unknown option {', '.join(map(str, options))}; there is reset_mask, which says "
                "which environments begin anew"
            )
        self._require_open()
        super().reset(seed=seed)
        if mask is None or self._knobs is None:
            return self._begin(), {}
        self._begin_again(np.asarray(mask, dtype=bool))
        return _seen(self.task, self._knobs), {}

    def step(
        self, actions: Observations
    ) -> tuple[
        Observations,
        npt.NDArray[np.float64],
        npt.NDArray[np.bool_],
        npt.NDArray[np.bool_],
        dict[str, Any],
    ]:
        """Let a step of the task pass; actions beyond -1 to 1 are clipped.

        Raises
        ------
        InvalidArgument
            If there is not one row of actions for each environment, or one is no number.
        """
        self._require_open()
        if self._knobs is None:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        no = np.zeros(self.num_envs, dtype=bool)
        over = self._steps == self.task.steps
        if over.all() and self._redraw:
            return self._begin(), np.zeros(self.num_envs), no, no, {}
        reward = np.zeros(self.num_envs)
        if not over.all():
            clipped = self._clipped(actions)
            self.task.act(clipped, self._knobs)
            self._knobs.step(self.task.ticks_per_step)
            self._steps += 1
            reward = np.where(over, 0.0, self.task.reward(self._knobs.states, clipped))
        if over.any():
            self._begin_again(over)
        return _seen(self.task, self._knobs), reward, no, self._steps == self.task.steps, {}

    def state(self) -> dict[str, Any]:
        """Give where the environment is now, for `set_state`; it can be pickled."""
        return deepcopy({name: self.__dict__.get(name) for name in _REMEMBERED})

    def set_state(self, state: dict[str, Any]) -> None:
        """Go on from where `state` was given: the same actions give the same bits.

        Raises
        ------
        InvalidArgument
            If it is of another task, or of another number of environments.
        """
        checks.kind("state", state, dict, "what state() gave")
        alike = set(state) == set(_REMEMBERED) and len(state["_steps"]) == self.num_envs
        if not alike or type(state["task"]) is not type(self.task):
            raise InvalidArgument(
                f"the state is not of {self.num_envs} environments of {type(self.task).__name__}"
            )
        self._require_open()
        self.__dict__.update(deepcopy(state))

    def render(self) -> tuple[picture.Image, ...] | None:
        """Draw each knob now, RGB of shape (300, 240, 3); None without a render mode."""
        if self.render_mode is None:
            return None
        self._require_open()
        if self._knobs is None:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        return tuple(picture.draw(state) for state in self._knobs.states)

    def close_extras(self, **_: Any) -> None:
        """Give the knobs' memory back."""
        self._knobs = None

    def _require_open(self) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError(
                "this environment was closed; make another"
            )

    def _clipped(self, actions: npt.ArrayLike) -> npt.NDArray[np.float64]:
        try:
            given = np.asarray(actions, dtype=float)
        except (TypeError, ValueError):
            raise InvalidArgument("actions must be an array of numbers") from None
        if given.shape != self.action_space.shape:
            raise InvalidArgument(
                f"actions have the shape {given.shape}, wanted is {self.action_space.shape}: a row "
                f"for each environment, of {', '.join(self.task.action_names)}"
            )
        if np.isnan(given).any():
            raise InvalidArgument("actions are not all numbers: there is a NaN")
        return np.clip(given, -1.0, 1.0)

    def _begin(self) -> Observations:
        self._knobs = self.task.knobs(self.num_envs, self.np_random, threads=self._threads)
        self._steps[:] = 0
        return _seen(self.task, self._knobs)

    def _begin_again(self, which: npt.NDArray[np.bool_]) -> None:
        assert self._knobs is not None
        first = int(self.np_random.integers(2**63))
        seeds = [first + place for place in range(int(which.sum()))]
        self._knobs.reset(which, seeds=seeds)
        self._steps[which] = 0


class KnobEnv(gymnasium.Env[Observations, Observations]):
    """The same task on one knob, for what knows no vectors. Every episode draws another knob."""

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]
        "render_modes": ["rgb_array"],
        "render_fps": _FRAMES_PER_S,
    }

    def __init__(self, task: Task, *, render_mode: str | None = None) -> None:
        """Draw the knob when `reset` is called."""
        self._many = KnobVectorEnv(task, 1, threads=1, render_mode=render_mode)
        self.render_mode = render_mode
        seen, acts = _spaces(task)
        self.observation_space: gymnasium.spaces.Space[Observations] = seen  # type: ignore[assignment]
        self.action_space: gymnasium.spaces.Space[Observations] = acts  # type: ignore[assignment]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Draw a knob and begin."""
        super().reset(seed=seed)
        seen, info = self._many.reset(seed=int(self.np_random.integers(2**31)), options=options)
        return seen[0], info

    def step(self, action: Observations) -> tuple[Observations, float, bool, bool, dict[str, Any]]:
        """Let a step of the task pass."""
        seen, reward, _, ended, info = self._many.step(np.asarray(action)[np.newaxis])
        return seen[0], float(reward[0]), False, bool(ended[0]), info

    def render(self) -> picture.Image | None:
        """Draw the knob now: dial and torques; None without a render mode."""
        drawn = self._many.render()
        return None if drawn is None else drawn[0]

    def state(self) -> dict[str, Any]:
        """Give where the environment is now, for `set_state`; it can be pickled."""
        return {"many": self._many.state(), "rng": deepcopy(self.np_random)}

    def set_state(self, state: dict[str, Any]) -> None:
        """Go on from where `state` was given: the same actions give the same bits."""
        checks.kind("state", state, dict, "what state() gave")
        rng = state.get("rng")
        self._many.set_state(state.get("many", {}) if isinstance(rng, np.random.Generator) else {})
        self.np_random = deepcopy(rng)  # type: ignore[assignment]

    def close(self) -> None:
        """Give the knob's memory back."""
        self._many.close()


def _one(task: type[Task], *, render_mode: str | None = None, **options: Any) -> KnobEnv:
    return KnobEnv(task(**options), render_mode=render_mode)


def _many(
    task: type[Task], num_envs: int, *, render_mode: str | None = None, **options: Any
) -> KnobVectorEnv:
    return KnobVectorEnv(task(**options), num_envs, render_mode=render_mode)


# For gymnasium.make("torsio.gym:torsio/RenderWall-v0"), and make_vec.
for _task in (FindDetent, IdentifyShaft, RenderWall):
    gymnasium.register(
        id=f"torsio/{_task.__name__}-v0",
        entry_point=partial(_one, _task),
        vector_entry_point=partial(_many, _task),
    )
