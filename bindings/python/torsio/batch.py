"""Thousands of closed loops that go on together, for learning and for statistics.

Each is a `torsio.closed_loop.ClosedLoop`: controller, encoder, plant and hand. It does the same as
alone, to the bit, for any number of threads. States and actions are arrays over the loops that are
looked at and written where they are.

>>> import torsio
>>> from torsio.batch import Knobs, LoopOptions
>>> wall = torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4)
>>> hand = torsio.TorqueHand(torque_nm=0.0)
>>> knobs = Knobs(1000, LoopOptions(scene=wall, hand=hand), actions="hand")
>>> knobs.actions["hand_torque_nm"] = 0.03
>>> knobs.step(500)
>>> bool((knobs.states["angle_rad"] > 0.1).all())
True
"""

from __future__ import annotations

import sys
import threading
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from time import monotonic
from typing import Any, Final, Literal, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from torsio import _torsio
from torsio.closed_loop import LoopOptions, checked_options
from torsio.common import checks
from torsio.errors import Error, InvalidArgument
from torsio.telemetry import LOOP_DTYPE, Record

__all__ = ["ACTION_DTYPE", "LOOP_DTYPE", "MOST_AT_ONCE", "Actions", "Knobs", "LoopOptions"]

Actions: TypeAlias = Literal["none", "hand", "commands", "hand and commands"]

ACTION_DTYPE = _torsio.emulator.ACTION_DTYPE
"""Inputs of a loop: ``hand_torque_nm`` on the knob, and ``motor_command_nm`` and
``brake_command_nm`` in place of the law's.
"""

MOST_AT_ONCE: Final = 10_000_000
"""Knobs that may run together."""

_STATE_OF: Final = f"torsio {_torsio.__version__} {sys.platform}\n".encode()
_FIRST_TICKS: Final = 100_000
_LONGEST_S: Final = 0.25  # aim for a part of a step, so that Ctrl-C is heard


class Knobs:
    """Many closed loops under one clock.

    Parameters
    ----------
    n
        How many; 1 to ten million.
    options
        One for all loops, or a sequence of one for each. Loops that are given the very same object
        share the tables of their steps: a thousand objects are a thousand times the memory.
        A spin-up is not possible. None is free space.
    actions
        Content of :attr:`actions`: the hand's torque, if every hand is a `TorqueHand`; the commands
        of motor and brake, so that the law only senses; both; or nothing.
    seeds
        Seeds of the encoders' noise: one for each loop, or the first; the others count up from it.
    threads
        How many share a step; None is as many as this process may use. The results do not depend
        on it.

    Raises
    ------
    TypeError, ValueError
        A value is out of its range; the sentence names it.
    """

    def __init__(
        self,
        n: int,
        options: LoopOptions | Sequence[LoopOptions] | None = None,
        *,
        actions: Actions = "none",
        seeds: int | npt.ArrayLike = 0,
        threads: int | None = None,
    ) -> None:
        """Set them up and have each sense for the first time."""
        n = checks.whole("n", n, 1, MOST_AT_ONCE)
        if actions not in get_args(Actions):
            allowed = ", ".join(map(repr, get_args(Actions)))
            raise InvalidArgument(f"actions is {checks.show(actions)}, allowed are {allowed}")
        if isinstance(options, LoopOptions) or options is None:
            kinds, kind_of = [options or LoopOptions()], np.zeros(n, dtype=np.uint32)
        else:
            each = list(checks.each("options", options, "LoopOptions, or one for each knob"))
            if len(each) != n:
                raise InvalidArgument(f"options are {len(each)}, and n is {n}: one for each knob")
            found: dict[int, int] = {}
            kind_of = np.array([found.setdefault(id(one), len(found)) for one in each], np.uint32)
            kinds = list({id(one): one for one in each}.values())
        for kind in kinds:
            checked_options(kind)
        threads = checks.threads(threads)
        each_options = [kinds[kind] for kind in kind_of]
        self._made: dict[str, Any] = {
            "n": n,
            "options": each_options,
            "actions": actions,
            "threads": threads,
        }
        self._kinds = len(kinds)
        self._seeds = _seeds(seeds, n)
        self._batch = _torsio.emulator.Batch(
            kinds,
            kind_of,
            self._seeds,
            threads,
            acts_hand="hand" in actions,
            acts_commands="commands" in actions,
        )
        self._is_free = threading.Lock()
        self._states = self._batch.states
        self._actions = self._batch.actions

    def __len__(self) -> int:
        """Say how many knobs there are."""
        return len(self._states)

    def __repr__(self) -> str:
        """Say how many there are, of how many kinds, what acts on them and where they are."""
        times_s = self._states["time_s"]
        at = " to ".join(f"{of:.6g}" for of in sorted({times_s.min(), times_s.max()}))
        return (
            f"<torsio.batch.Knobs {len(self)} of {self._kinds} kinds, "
            f"actions {self._made['actions']!r}, at {at} s>"
        )

    @property
    def states(self) -> Record:
        """True, sensed and decided values now: LOOP_DTYPE, shape (n,).

        This is the knobs' own memory. Every step changes it; do not write it. A knob's row equals
        the one that `ClosedLoop.run` would give of this moment.
        """
        return self._states

    @property
    def actions(self) -> Record:
        """Inputs that act from the next step on: ACTION_DTYPE, shape (n,), to be written.

        The memory of the knobs itself. As numbers, ``knobs.actions.view(float).reshape(-1, 3)``.
        """
        return self._actions

    def step(self, ticks: int = 1) -> None:
        """Let all go on for so many control periods, while other Python threads run.

        Raises
        ------
        ValueError, RuntimeError
            That names the first knob that cannot go on, because of its action, or because nothing
            holds it. The others have gone on; its own state is of a moment before it failed.
        Error
            If they are in the middle of a step.
        """
        left = checks.whole("ticks", ticks, 1, 2**40)
        at_once = max(1, _FIRST_TICKS // len(self))
        with self._alone():
            goes_on, failure = False, None
            while left > 0:
                begin_s = monotonic()
                try:
                    self._batch.step(min(left, at_once), goes_on)
                except (ValueError, RuntimeError) as error:
                    failure = failure or error
                goes_on = True
                left -= at_once
                # Loops differ a hundredfold in what a tick costs.
                took_s = monotonic() - begin_s
                at_once = max(1, int(at_once * min(8.0, _LONGEST_S / max(took_s, 1e-9))))
            if failure is not None:
                raise failure

    def reset(
        self, which: npt.ArrayLike | None = None, *, seeds: int | npt.ArrayLike | None = None
    ) -> None:
        """Begin anew: all knobs, the knobs where a mask is true, or a list of indices.

        Parameters
        ----------
        seeds
            One for each that begins anew, or the first one's; None are those that they had first.
        """
        n = len(self)
        chosen = np.arange(n) if which is None else np.asarray(which)
        if chosen.dtype == np.bool_:
            if chosen.shape != (n,):
                raise InvalidArgument(f"which is a mask of shape {chosen.shape}, wanted is ({n},)")
            chosen = np.flatnonzero(chosen)
        if chosen.shape == (0,):  # an empty list is one of floats
            chosen = chosen.astype(int)
        if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer):
            raise InvalidArgument("which must be a mask or indices, in one dimension")
        if chosen.size and not (chosen.min() >= 0 and chosen.max() < n):
            raise InvalidArgument(
                f"which has {chosen.min()} to {chosen.max()}, allowed 0 to {n - 1}"
            )
        if len(np.unique(chosen)) != len(chosen):
            raise InvalidArgument("which has the same knob twice")
        new = self._seeds[chosen] if seeds is None else _seeds(seeds, len(chosen))
        with self._alone():
            self._batch.reset(chosen.astype(np.uint32), new)

    def state(self) -> bytes:
        """Give all that the knobs remember now, for `set_state` of knobs that were made alike.

        Raises `InvalidArgument` if a plant has electrics.
        """
        with self._alone():
            saved = self._batch.save()
        return _STATE_OF + zlib.crc32(saved).to_bytes(4, "little") + saved

    def set_state(self, state: bytes) -> None:
        """Go on from where `state` was given: the same steps give the same bits.

        `pickle` and `copy` use it too. Raises `InvalidArgument` if the state is damaged, or of
        other knobs or another version; nothing is changed then.
        """
        checks.kind("state", state, bytes, "what state() gave")
        saved = state[len(_STATE_OF) + 4 :]
        if not state.startswith(_STATE_OF + zlib.crc32(saved).to_bytes(4, "little")):
            raise InvalidArgument(
                f"the state is damaged, or not of version {_torsio.__version__} on {sys.platform}"
            )
        with self._alone():
            self._batch.restore(saved)

    __setstate__ = set_state

    def __reduce__(self) -> tuple[object, ...]:
        """Give how to make them anew, and what they remember."""
        return partial(Knobs, **self._made, seeds=self._seeds), (), self.state()

    @contextmanager
    def _alone(self) -> Iterator[None]:
        if not self._is_free.acquire(blocking=False):
            raise Error(
                "these knobs are in the middle of a step, in another thread or in a hand's "
                "function; wait for its end"
            )
        try:
            yield
        finally:
            self._is_free.release()


def _seeds(seeds: int | npt.ArrayLike, n: int) -> npt.NDArray[np.uint64]:
    if isinstance(seeds, int | np.integer):
        first = checks.whole("seeds", seeds, 0, 2**64 - 1)
        # They count on from 0 after the last one.
        return np.uint64(first) + np.arange(n, dtype=np.uint64)
    # As Python's own: one array of large and small numbers would be of floats.
    given = np.array(seeds, dtype=object)
    if given.shape != (n,) or not all(isinstance(one, int | np.integer) for one in given):
        raise InvalidArgument(f"seeds must be a whole number, or {n} of them in one dimension")
    each = (checks.whole("seeds", one, 0, 2**64 - 1) for one in given)
    return np.fromiter(each, dtype=np.uint64, count=n)
