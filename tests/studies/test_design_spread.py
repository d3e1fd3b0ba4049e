"""The study of designs, spread over processes and over a cluster."""

from __future__ import annotations

import importlib
import math
import socket
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from torsio_studies.common import StudyError
from torsio_studies.design import devices, spread
from torsio_studies.design.devices import Batch, Design
from torsio_studies.design.store import Store
from torsio_studies.execution import execute

DEVICES = 8
# Light devices, so that the tests are quick.
FAST = tuple(
    Design(beta=beta, control_rate_hz=500.0, knob_inertia_kg_m2=inertia)
    for beta in (0.0, 0.5)
    for inertia in (4e-5, 6e-5)
)
Numbers = dict[int, list[dict[str, float | None]]]
BATCHES = tuple(Batch("sample", i, (one,)) for i, one in enumerate(FAST))


def without_seconds(rows: list[dict[str, float]]) -> list[dict[str, float | None]]:
    """Leave out what is never the same, and give None for NaN, which equals nothing."""
    return [
        {
            key: None if math.isnan(value) else value
            for key, value in row.items()
            if key != "seconds"
        }
        for row in rows
    ]


def _done(batches: tuple[Batch, ...], **where: Any) -> Numbers:
    with spread.spread(batches, **where) as (_, results):
        return {batch.index: without_seconds(rows) for batch, rows in results}


@pytest.fixture(scope="module")
def reference() -> Numbers:
    return _done(BATCHES, workers=1)


def test_two_processes_give_the_same_numbers(
    reference: Numbers,
) -> None:
    assert _done(BATCHES, workers=2) == reference


@pytest.fixture(scope="module")
def two_workers() -> Iterator[str]:
    """Address of a scheduler on this machine, with two worker processes."""
    distributed: Any = importlib.import_module("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
    ) as cluster:
        yield cluster.scheduler_address


def test_dask_cluster_of_two_workers_gives_the_same_numbers(
    reference: Numbers, two_workers: str
) -> None:
    with spread.spread(BATCHES, scheduler=two_workers) as (workers, results):
        done = {batch.index: without_seconds(rows) for batch, rows in results}
    assert workers == 2
    assert done == reference


@pytest.fixture
def silent_port() -> Iterator[int]:
    with socket.socket() as taken:  # bound but not listening: nobody answers
        taken.bind(("127.0.0.1", 0))
        yield taken.getsockname()[1]


def test_unreachable_scheduler_is_one_clear_error_and_earlier_results_stay(
    tmp_path: Path, silent_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spread, "_ANSWER_S", 0.5)
    folder = tmp_path / "design"
    settings = {"evaluation": devices.EVALUATION, "law": "paper", "batch_size": 4}
    earlier = Store(folder, settings)
    first = next(iter(devices.batches(DEVICES, 3, "paper", 4)))
    row = asdict(Design()) | dict.fromkeys(devices.columns()[7:], 1.0)
    earlier.write(first, [row] * 4)
    kept = earlier.path(first).read_bytes()
    address = f"tcp://127.0.0.1:{silent_port}"
    with pytest.raises(StudyError, match=f"no Dask scheduler answers at {address}") as caught:
        execute(
            "design",
            out=tmp_path,
            quick=True,
            settings={"devices": DEVICES, "scheduler": address},
        )
    assert "\n" not in str(caught.value)
    assert earlier.path(first).read_bytes() == kept
