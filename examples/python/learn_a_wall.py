"""Learn to share a wall's torque between motor and brake, and compare with the device's laws.

The cross-entropy method on a policy of 14 numbers: each of many candidates renders walls of several
stiffnesses on emulated knobs of its own, all of them stepped together, and the best draw the next.

    learn_a_wall.py [GENERATIONS]       about a second each; 60 learn it
"""

from __future__ import annotations

import sys

import numpy as np

from torsio.tasks import RenderWall

CANDIDATES, BEST, WALLS = 64, 12, 8
FEATURES = 7  # what the device senses, and a constant
PLANT = {"knob_coulomb_nm": (4e-3, 8e-3), "brake_time_constant_s": (0.05, 0.07)}


def features(seen: np.ndarray) -> np.ndarray:
    """Give what the policy weighs; the brake knows no sign."""
    wanted, spring, capacity, speed, motor, _ = seen.T
    same = np.where(wanted * spring >= 0.0, np.abs(wanted), 0.0)
    return np.column_stack([wanted, spring, capacity, speed, motor, same, np.ones(len(seen))])


def earn(task: RenderWall, policies: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Give what policies, shape (n, FEATURES, 2), earn on average over the walls."""
    n = len(policies)
    knobs = task.knobs(n * WALLS, rng)
    total = np.zeros(n * WALLS)
    for _ in range(task.steps):
        weighed = features(task.observe(knobs.states)).reshape(n, WALLS, FEATURES)
        actions = np.clip(weighed @ policies, -1.0, 1.0).reshape(n * WALLS, 2)
        task.act(actions, knobs)
        knobs.step(task.ticks_per_step)
        total += task.reward(knobs.states, actions)
    earned: np.ndarray = total.reshape(n, WALLS).mean(axis=1)
    return earned


def main(generations: str = "60") -> None:
    """Learn, then compare on walls that nobody has seen."""
    rng = np.random.default_rng(1)
    task = RenderWall(plant=PLANT, kinds=WALLS)  # every candidate gets the same walls
    middle, spread = np.zeros((FEATURES, 2)), np.ones((FEATURES, 2))
    for generation in range(int(generations)):
        policies = middle + spread * rng.standard_normal((CANDIDATES, FEATURES, 2))
        earned = earn(task, policies, rng)
        best = policies[np.argsort(earned)[-BEST:]]
        # Noise that fades, so that it does not settle too early.
        middle, spread = best.mean(axis=0), best.std(axis=0) + 0.3 * 0.93**generation
        if generation % 10 == 0:
            print(f"generation {generation}: best {earned.max():.2f}, mean {earned.mean():.2f}")

    judge = RenderWall(plant=PLANT, kinds=WALLS)
    learned = earn(judge, middle[np.newaxis], np.random.default_rng(99))[0]
    print(f"learned: {learned:.3f}, an error of {5 * abs(learned) ** 0.5:.1f} mN m RMS")
    for law in ("paper", "compensated"):
        earned_nm = judge.law(WALLS, np.random.default_rng(99), law).mean()
        print(f"the law {law}: {earned_nm:.3f}, {5 * abs(earned_nm) ** 0.5:.1f} mN m RMS")


if __name__ == "__main__":
    main(*sys.argv[1:])
