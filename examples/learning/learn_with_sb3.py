"""Learn to find a detent with Stable-Baselines3, whose PPO sees many knobs at once.

It needs ``pip install '.[gym]' stable-baselines3``. STEPS may follow its name.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from torsio.gym import FindDetent, KnobVectorEnv


class SB3Knobs(VecEnv):  # type: ignore[misc]
    """Knobs as Stable-Baselines3 wants them: the step that ends an episode begins the next one."""

    def __init__(self, env: KnobVectorEnv) -> None:
        """Take an environment over."""
        self.env = env
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> np.ndarray:
        """Begin all episodes, with the seed that was asked for."""
        seen, _ = self.env.reset(seed=self._seeds[0])
        self._reset_seeds()
        return seen

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Let a step pass; all episodes are equally long, so they end together."""
        seen, reward, _, over, _ = self.env.step(self._actions)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if over.all():
            infos = [{"terminal_observation": last, "TimeLimit.truncated": True} for last in seen]
            seen, *_ = self.env.step(self._actions)
        return seen, reward.astype(np.float32), over, infos

    def close(self) -> None:
        """Give the knobs' memory back."""
        self.env.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        """Draw every knob."""
        return self.env.render() or ()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Give an attribute, which all knobs have in common."""
        return [getattr(self.env, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of all knobs."""
        setattr(self.env, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **named: Any) -> Any:
        """Call a method once for all knobs."""
        called = getattr(self.env, method_name)(*args, **named)
        return [called] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Tell that no knob is wrapped."""
        return [False] * len(list(self._get_indices(indices)))


if __name__ == "__main__":
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecMonitor

    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    knobs = VecMonitor(SB3Knobs(KnobVectorEnv(FindDetent(), num_envs=64)))
    PPO("MlpPolicy", knobs, n_steps=300, batch_size=4800, verbose=1).learn(steps)
