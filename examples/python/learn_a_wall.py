"""Learn to share a wall's torque between motor and brake, and compare with the device's laws.

The cross-entropy method on a policy of 14 numbers. Each candidate renders walls of several
stiffnesses on emulated knobs of its own. Gymnasium's vector environment steps all of them together.
The next candidates are drawn around the best. Gymnasium comes with ``pip install '.[gym]'``.

    learn_a_wall.py [GENERATIONS]       30 learn it, in some four seconds of processor time
"""

from __future__ import annotations

import argparse

import numpy as np

from torsio.gym import KnobVectorEnv, RenderWall

CANDIDATES, BEST, WALLS = 64, 12, 8
FEATURES = 7  # what the device senses, and a constant
PLANT = {"knob_coulomb_nm": (4e-3, 8e-3), "brake_time_constant_s": (0.05, 0.07)}
LEARN_SEED, JUDGE_SEED = 1, 99


def walls(candidates: int) -> KnobVectorEnv:
    """Give knobs with walls to so many candidates, the same ones to each."""
    return KnobVectorEnv(RenderWall(plant=PLANT, kinds=WALLS), candidates * WALLS)


def features(seen: np.ndarray) -> np.ndarray:
    """Give what the policy weighs; the brake knows no sign."""
    wanted, spring, capacity, speed, motor, _ = seen.T
    same = np.where(wanted * spring >= 0.0, np.abs(wanted), 0.0)
    return np.column_stack([wanted, spring, capacity, speed, motor, same, np.ones(len(seen))])


def earn(env: KnobVectorEnv, policies: np.ndarray, seed: int | None = None) -> np.ndarray:
    """Give what policies, shape (n, FEATURES, 2), earn on average over walls that are drawn."""
    n = len(policies)
    seen, _ = env.reset(seed=seed)
    total = np.zeros(n * WALLS)
    ended = False
    while not ended:
        weighed = features(seen).reshape(n, WALLS, FEATURES)
        actions = np.clip(weighed @ policies, -1.0, 1.0).reshape(n * WALLS, 2)
        seen, reward, _, truncated, _ = env.step(actions)
        total += reward
        ended = bool(truncated.all())  # all at once
    earned: np.ndarray = total.reshape(n, WALLS).mean(axis=1)
    return earned


def learn(generations: int) -> np.ndarray:
    """Give the policy that so many generations come to, shape (FEATURES, 2)."""
    rng = np.random.default_rng(LEARN_SEED)
    env = walls(CANDIDATES)
    env.reset(seed=LEARN_SEED)  # each generation's walls follow from it
    middle, spread = np.zeros((FEATURES, 2)), np.ones((FEATURES, 2))
    for generation in range(generations):
        policies = middle + spread * rng.standard_normal((CANDIDATES, FEATURES, 2))
        earned = earn(env, policies)
        best = policies[np.argsort(earned)[-BEST:]]
        # Noise that fades, so that it does not settle too early.
        middle, spread = best.mean(axis=0), best.std(axis=0) + 0.3 * 0.85**generation
        if generation % 10 == 0:
            print(f"generation {generation}: best {earned.max():.2f}, mean {earned.mean():.2f}")
    return middle


def count(text: str) -> int:
    """Read how many generations."""
    if not (text.isdecimal() and 1 <= int(text) <= 1000):
        raise argparse.ArgumentTypeError(f"{text} is no whole number from 1 to 1000")
    return int(text)


def main() -> None:
    """Learn, then compare on walls that nobody has seen."""
    parser = argparse.ArgumentParser(description="Learn to render a wall.")
    parser.add_argument("generations", nargs="?", type=count, default=30, metavar="GENERATIONS")
    policy = learn(parser.parse_args().generations)
    env = walls(1)
    task = RenderWall(plant=PLANT, kinds=WALLS)
    results = {
        "nothing": earn(env, np.zeros((1, FEATURES, 2)), JUDGE_SEED)[0],
        "learned": earn(env, policy[np.newaxis], JUDGE_SEED)[0],
    }
    for law in ("paper", "compensated", "calibrated"):
        # Gymnasium draws from a generator of this kind, so that the walls are the same.
        rng = np.random.default_rng(JUDGE_SEED)
        results[f"the law {law}"] = task.law(WALLS, rng, law).mean()
    for name, earned in results.items():
        print(f"{name}: {earned:.3f}, an error of {5 * abs(earned) ** 0.5:.1f} mN m RMS")


if __name__ == "__main__":
    main()
