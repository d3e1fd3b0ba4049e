"""Whether the law `calibrated` brings every spring to rest on the boards' own loops, as JSON lines.

``./dev bench buzz`` throws and pushes the emulated knob, with the electrics of a board, into walls
and two-sided springs from 0 to 10^6 N m/rad: at five speeds, let go, in a stiff hand and in a soft
one, with a tick of delay and without, with three encoders, and with a winding that is what the
board takes it for or a third off in resistance and inductance. A line tells for one board, encoder
and winding how many trials there were, how many counts the knob of the worst one moves by from half
a second after contact on, how the loudest motor vibrates, but for a flicker of 0.2 s, and
which trials move by more than two counts or vibrate so that a finger feels it, with how often their
knob turns round: others only creep to where they stay. The exit status is 1 if any turns round or
is felt.

With ``quick`` as argument every tenth stiffness is tried; with names of boards, only those.
"""

from __future__ import annotations

import itertools
import json
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict

import numpy as np

from tests.python.buzzing import BOARDS, HANDS, REST_COUNTS, SPEEDS_RAD_S, Trial, motion
from torsio.perception import VIBRATION_NM

COUNTS = (8192, 32768, 131072)
WINDINGS = ((1.0, 1.0), *itertools.product((0.7, 1.3), repeat=2))
STIFFNESS_NM_PER_RAD = (0.0, *np.geomspace(0.5, 1e6, 24).tolist())


def main(arguments: list[str]) -> int:
    """Print a line for each board, encoder and winding."""
    stiffness = STIFFNESS_NM_PER_RAD[:: 10 if "quick" in arguments else 1]
    boards = [name for name in BOARDS if name in arguments] or list(BOARDS)
    rests = True
    with ThreadPoolExecutor() as pool:
        for board, counts, winding in itertools.product(boards, COUNTS, WINDINGS):
            trials = [
                Trial(
                    board, spring, speed, hand, two_sided, delay, counts,
                    resistance=winding[0], inductance=winding[1],
                )
                for spring, speed, hand, two_sided, delay in itertools.product(
                    stiffness, SPEEDS_RAD_S, HANDS, (False, True), (0, 1)
                )
            ]  # fmt: skip
            motions = list(pool.map(motion, trials))
            moving = [
                asdict(trial) | {"moves_counts": moved, "turns": turns, "vibration_nm": vibration}
                for trial, (moved, turns, vibration) in zip(trials, motions, strict=True)
                if moved > REST_COUNTS or vibration >= VIBRATION_NM
            ]
            felt = any(one["turns"] or one["vibration_nm"] >= VIBRATION_NM for one in moving)
            rests = rests and not felt
            line = {
                "board": board, "counts_per_rev": counts, "resistance": winding[0],
                "inductance": winding[1], "trials": len(trials),
                "most_counts": max(moved for moved, _, _ in motions),
                "loudest_nm": max(vibration for _, _, vibration in motions), "moving": moving,
            }  # fmt: skip
            print(json.dumps(line), flush=True)
    return 0 if rests else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
