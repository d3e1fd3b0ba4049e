"""Variants of a trade: parts left out, other rates, counts and laws; each played, and kept."""

from __future__ import annotations

import hashlib
import json
import time
import warnings
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any, Final, get_args

from torsio import _torsio, protocol
from torsio.closed_loop import ClosedLoop, LoopOptions
from torsio.common.whole_file import content
from torsio.errors import Error
from torsio.knob import Knob
from torsio.knob.opening import open as open_knob
from torsio.printed.config import CONFIGS, Law
from torsio.printed.emulator_options import EmulatorOptions
from torsio.printed.hands import PrescribedMotion
from torsio.printed.plant import PlantParams
from torsio.telemetry import Record
from torsio.trading.visits import Difference, Visit, differ, felt_nm, moved

__all__ = [
    "HIGHEST_HZ",
    "PARTS",
    "RATES_HZ",
    "WHOLE",
    "Kept",
    "Runs",
    "Variant",
    "emulated_options",
    "present",
    "variants",
]

HIGHEST_HZ: Final = 20_000
RATES_HZ: Final = (HIGHEST_HZ, 10_000, 5_000, 2_000, 1_000)
_NO_SPRING: Final[dict[str, Any]] = {
    "spring_and_brake": False,
    "shaft_hardening": None,
    "brake_hysteresis": None,
    "belt": None,
}
PARTS: Final[dict[str, dict[str, Any]]] = {
    "hysteresis": {"brake_hysteresis": None},
    "hardening": {"shaft_hardening": None},
    "belt": {"belt": None},
    "cogging": {"cogging": None},
    "electrics": {"electrics": None},
    "noise": {"encoder_noise_counts": 0.0},
    "brake": {"brake_limit_nm": 0.0},  # and the coil of the electrics, see `Variant.of`
    "spring and brake": _NO_SPRING,
}
"""For each part, the change of the plant that leaves it out."""
WHOLE: Final = ("brake", "spring and brake")  # leave out most of the plant, so never combined
_WITH_SPRING: Final = ("hysteresis", "hardening", "belt", "brake")
_REPORT_BYTES: Final = 64
_HELD_S: Final = 1.0  # until the soft start's effect on the brake is gone


@dataclass(frozen=True)
class Variant:
    """A way to simulate a scene with less, or with something else.

    Attributes
    ----------
    left_out
        Parts, by their names in `PARTS`.
    counts_per_rev, law
        None: as they are. A knob with another encoder or law is another knob, so neither is ever
        proposed.
    other_noise
        The reference again with other noise: what differs less differs by chance.
    """

    left_out: tuple[str, ...] = ()
    rate_hz: int = HIGHEST_HZ
    counts_per_rev: int | None = None
    law: Law | None = None
    other_noise: bool = False

    @property
    def name(self) -> str:
        """Say what it is, in words."""
        words = [f"without {', '.join(self.left_out)}"] if self.left_out else []
        words += [f"{self.rate_hz // 1000} kHz"] if self.rate_hz != HIGHEST_HZ else []
        words += [f"{self.counts_per_rev} counts"] if self.counts_per_rev else []
        words += [f"law {self.law}"] if self.law else []
        words += ["other noise"] if self.other_noise else []
        return ", ".join(words) or "all parts at the highest rate"

    @property
    def lacks(self) -> tuple[str, ...]:
        """Parts that are left out, and those that went with the spring."""
        more = _WITH_SPRING if "spring and brake" in self.left_out else ()
        return self.left_out + more

    def leaves_out_all_of(self, other: Variant) -> bool:
        """Tell whether it has no part that `other` lacks, and no higher rate."""
        return {*other.lacks} <= {*self.lacks} and self.rate_hz <= other.rate_hz

    @property
    def may_be_proposed(self) -> bool:
        """It is the same knob, simulated with less."""
        return not (self.counts_per_rev or self.law or self.other_noise)

    def of(self, options: LoopOptions) -> LoopOptions:
        """Change a loop so. Its device's beliefs stay as they are."""
        changes: dict[str, Any] = {}
        for part in self.left_out:
            changes |= PARTS[part]
        if "brake" in self.left_out and options.plant.electrics:
            weak = replace(options.plant.electrics, coil_torque_constant_nm_per_a=1e-12)
            changes["electrics"] = weak
        actuator, control = options.actuator, options.control
        if self.counts_per_rev:
            changes["counts_per_rev"] = self.counts_per_rev
            actuator = actuator and replace(actuator, counts_per_rev=self.counts_per_rev)
        if self.law:
            control = replace(control, law=self.law)
        return replace(
            options,
            plant=replace(options.plant, **changes),
            actuator=actuator,
            control=control,
            control_period_ns=round(1e9 / self.rate_hz),
            seed=options.seed + self.other_noise,
        )


def present(plant: PlantParams) -> list[str]:
    """Name the parts that a plant has."""
    return [
        name
        for name, without in PARTS.items()
        if (plant.spring_and_brake or name not in _WITH_SPRING)
        and any(getattr(plant, field) != value for field, value in without.items())
    ]


def variants(options: LoopOptions, *, quick: bool) -> list[Variant]:
    """Give what is tried, the reference first; unless quick, every combination at every rate."""
    plant = options.plant
    parts = present(plant)
    subsets = _subsets(parts, quick=quick)
    tried = [Variant(left_out=left_out, rate_hz=rate) for rate in RATES_HZ for left_out in subsets]
    tried += [Variant(left_out=("brake",))] if "brake" in parts else []
    counts = plant.counts_per_rev
    tried += [Variant(counts_per_rev=counts // by) for by in (2, 4, 8) if counts >= 64 * by]
    tried += [Variant(law=law) for law in get_args(Law) if law != options.control.law]
    # The current sensor has noise too.
    tried += [Variant(other_noise=True)] if plant.encoder_noise_counts or plant.electrics else []
    return tried


def _subsets(parts: Sequence[str], *, quick: bool) -> list[tuple[str, ...]]:
    """Give the parts that are left out together, none first."""
    small = [part for part in parts if part not in WHOLE]
    subsets = _together(small, (0, 1, len(small)) if quick else range(len(small) + 1))
    if "spring and brake" in parts:
        others = [part for part in small if part not in _WITH_SPRING]
        ends = _together(others, (0, len(others)) if quick else range(len(others) + 1))
        subsets += [("spring and brake", *end) for end in sorted(ends)]
    return subsets


def _together(parts: Sequence[str], sizes: Iterable[int]) -> list[tuple[str, ...]]:
    return [part for size in dict.fromkeys(sizes) for part in combinations(parts, size)]


def _sum(row: object) -> int:
    return zlib.crc32(json.dumps(row).encode())


class Kept:
    """Results in a file of lines, so that an interrupted trade goes on where it was."""

    def __init__(self, path: Path | None) -> None:
        self._path, self._found = path, dict[str, dict[str, Any]]()
        if path is None or not path.exists():
            return
        # No UTF-16: new lines are appended in UTF-8.
        text = content(path).decode("utf-8-sig", errors="replace")
        for line in filter(None, text.splitlines()):
            try:
                one = json.loads(line)
                if one["crc32"] == _sum(one["row"]):  # else a bit has flipped
                    self._found[one["key"]] = one["row"]
            except (ValueError, KeyError, TypeError, RecursionError):
                if not line.startswith('{"key"'):
                    raise Error(f"{path} keeps no results of a trade: give another file") from None
                # else it was torn

    def get(self, of: object, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Give the kept results of these settings, or make and keep them."""
        key = hashlib.sha256(f"{_torsio.__version__} {_whole(of)}".encode()).hexdigest()[:24]
        if key not in self._found:
            self._found[key] = make()
            self._keep({"key": key, "crc32": _sum(self._found[key]), "row": self._found[key]})
        return self._found[key]

    def _keep(self, row: dict[str, Any]) -> None:
        path = self._path
        if path is None:
            return
        try:
            with path.open("a", encoding="utf-8") as file:
                # A line of its own, whatever was torn before.
                file.write(json.dumps(row).join("\n\n"))
        except OSError as error:
            self._path = None
            warnings.warn(f"{path}: {error.strerror}; nothing more is kept there", stacklevel=3)


def _whole(of: object) -> str:
    """Write all of a value; the repr of a data class leaves out long fields."""
    if is_dataclass(of):
        return f"{type(of).__name__}{[_whole(getattr(of, each.name)) for each in fields(of)]}"
    return f"{[*map(_whole, of)]}" if isinstance(of, tuple | list) else repr(of)


class Runs:
    """Plays variants of a loop, and tells how each differs from the reference.

    Parameters
    ----------
    options
        The loop with all parts; its period is not looked at.
    threads
        Runs at a time.
    """

    def __init__(self, options: LoopOptions, kept: Kept, threads: int) -> None:
        self.options: LoopOptions = options
        self._kept, self._threads = kept, threads
        self._references: dict[Visit, Record] = {}

    def reference(self, visit: Visit) -> Record:
        """Give the visit with all parts at the highest rate, a row each millisecond."""
        if visit not in self._references:
            self._references[visit] = self._play(Variant(), visit)[0]
        return self._references[visit]

    def measure(
        self,
        tried: Sequence[Variant],
        visits: Iterable[Visit],
        on_progress: Callable[[int, int], None] = lambda _done, _total: None,
    ) -> list[tuple[Difference, float]]:
        """Give the worst difference of each, and the least CPU time for a second, in seconds."""
        visits = tuple(visits)
        for visit in visits:
            self.reference(visit)
        with ThreadPoolExecutor(self._threads) as pool:
            results: Iterator[dict[str, Any]] = pool.map(lambda one: self._row(one, visits), tried)
            try:
                found = []
                for row in results:
                    found.append((Difference(**row["difference"]), float(row["cpu_s"])))
                    on_progress(len(found), len(tried))
                return found
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise

    def _row(self, variant: Variant, visits: tuple[Visit, ...]) -> dict[str, Any]:
        def make() -> dict[str, Any]:
            worst, cpu_s = Difference(), float("inf")
            for visit in visits:
                rows, took_s = self._play(variant, visit)
                worst = worst.worse(self.difference(variant, visit, rows))
                cpu_s = min(cpu_s, took_s)
            return {"difference": vars(worst), "cpu_s": cpu_s}

        return self._kept.get((variant, visits, self.options), make)

    def _play(self, variant: Variant, visit: Visit, held_ns: int = 0) -> tuple[Record, float]:
        """Play a visit; perhaps the knob was held at angle 0 before, while the scene played."""
        options = variant.of(visit.of(self.options))
        duration_s = visit.lasts_s(self.options.hand)
        every = max(1, round(1_000_000 / options.control_period_ns))
        if held_ns:
            loop = ClosedLoop(replace(options, hand=PrescribedMotion(angle_rad=0.0)))
            loop.run(duration_s=1e-9 * held_ns, record_every=2**32 - 1)
            loop.set_hand(moved(options.hand, lambda at_s, value: (at_s + 1e-9 * held_ns, value)))
        else:
            loop = ClosedLoop(options)
        begin_s = time.thread_time()
        rows = loop.run(duration_s=duration_s, record_every=every)
        return rows, (time.thread_time() - begin_s) / duration_s

    def difference(self, variant: Variant, visit: Visit, rows: Record) -> Difference:
        """Compare a variant's visit, a row each millisecond, with the reference's."""
        reference, hand = self.reference(visit), self.options.hand
        plants = self.options.plant, variant.of(self.options).plant
        felt = felt_nm(reference, plants[0], hand), felt_nm(rows, plants[1], hand)
        return differ(reference, rows, felt, self.options.scene)

    def on_device(self, variant: Variant, visit: Visit) -> tuple[Difference, float, float]:
        """Play a visit on the whole emulated device, protocol included.

        Returns
        -------
        tuple
            The difference, without the knob's own friction, which the device does not tell; the
            CPU time for a second, in s; and the bytes on the wire in a second.
        """
        options = variant.of(visit.of(self.options))
        duration_s = visit.lasts_s(self.options.hand)
        every = round(1_000_000 / options.control_period_ns)
        with (
            warnings.catch_warnings(),
            open_knob("emulated", emulator=emulated_options(options, log_truth=True)) as knob,
        ):
            warnings.simplefilter("ignore")  # of swings: measured here anyway
            played_tick = _hold_until_armed(knob, options)
            begin, begin_s = knob.statistics(), time.process_time()
            knob.emulator.truth()
            knob.emulator.set_hand(options.hand)
            knob.record(duration_s + 1e-3)
            took_s = time.process_time() - begin_s
            rows, end = knob.emulator.truth()[::every], knob.statistics()
        held_ns = round(1e9 * rows["time_s"][0]) - played_tick * options.control_period_ns
        reference = self._play(Variant(), visit, held_ns)[0]
        rows, reference = rows[: len(reference)], reference[: len(rows)]
        for record in (rows, reference):
            record["time_s"] -= record["time_s"][0]
        # The same torques of both: the device's rows lack the friction.
        shown = reference[[name for name in reference.dtype.names or () if "friction" not in name]]
        hand, plants = self.options.hand, (self.options.plant, options.plant)
        felt = felt_nm(shown, plants[0], hand), felt_nm(rows, plants[1], hand)
        reports = (end.reports_sent - begin.reports_sent) + (
            end.reports_received - begin.reports_received
        )
        found = differ(reference, rows, felt, self.options.scene)
        return found, took_s / duration_s, _REPORT_BYTES * reports / duration_s


def emulated_options(options: LoopOptions, **more: Any) -> EmulatorOptions:
    """Give the options of the whole device that does as a loop."""
    plant = options.plant
    known = {name: getattr(options, name, None) for name in CONFIGS}
    given = {name: one for name, one in known.items() if one and one != type(one)()}
    return EmulatorOptions(
        control_rate_hz=1e9 / options.control_period_ns,
        plant=plant,
        seed=options.seed,
        **given,
        **more,
    )


def _hold_until_armed(knob: Knob, options: LoopOptions) -> int:
    """Play and arm while somebody holds the knob at angle 0, past the soft start.

    Returns the tick from which on the scene has played.
    """
    knob.emulator.set_hand(PrescribedMotion(angle_rad=0.0))
    tap = knob._knob.tap(with_telemetry=False)
    if options.scene is not None:
        knob.play(options.scene)
    decoded = [protocol.decode(content) for _, sent, content in tap.take() if not sent]
    ticks = [values["tick"] for name, values in decoded if name == "acknowledgement"]
    knob.arm()
    knob.sleep(options.control.passive_ramp_s + _HELD_S)
    return max(ticks, default=0)
