"""The study of designs, spread over processes and over a cluster."""

from __future__ import annotations

import importlib
import os
import socket
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.studies.cluster import local_cluster, without_seconds
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
    with local_cluster(n_workers=2, threads_per_worker=1, processes=True) as cluster:
        yield cluster.scheduler_address


def test_dask_cluster_of_two_workers_gives_the_same_numbers(
    reference: Numbers, two_workers: str
) -> None:
    with spread.spread(BATCHES, scheduler=two_workers) as (workers, results):
        done = {batch.index: without_seconds(rows) for batch, rows in results}
    assert workers == 2
    assert done == reference


def test_study_on_a_dask_cluster_of_two_workers_gives_the_same_parquet(
    tmp_path: Path, two_workers: str
) -> None:
    parquet = importlib.import_module("pyarrow.parquet")
    tables = []
    for name, where in (("cluster", {"scheduler": two_workers}), ("here", {"workers": 1})):
        results = execute(
            "design", out=tmp_path / name, quick=True, settings={"devices": DEVICES, **where}
        )
        assert results["workers"] == (2 if name == "cluster" else 1)
        assert results["computed_now"] == DEVICES + 2 * 9
        tables.append(parquet.read_table(results["parquet"]).drop_columns("seconds").to_pydict())
    cluster, here = tables
    assert list(cluster) == ["group", *(name for name in devices.columns() if name != "seconds")]
    for name, values in here.items():
        np.testing.assert_array_equal(cluster[name], values, err_msg=name)


def test_scheduler_without_workers_is_refused() -> None:
    with (
        local_cluster(n_workers=0) as cluster,
        pytest.raises(StudyError, match=r"has no workers: start some with dask worker tcp://"),
        spread.spread(BATCHES, scheduler=cluster.scheduler_address),
    ):
        pass


class Client:
    """Stands in for a Dask client whose workers give the same answer to everything."""

    loop = None

    def __init__(self, answer: object) -> None:
        self.answer = answer
        self.cancelled = 0

    def nthreads(self) -> dict[str, int]:
        return {"tcp://a:1": 2, "tcp://b:1": 1}

    def run(self, _: Callable[[], str]) -> dict[str, object]:
        if isinstance(self.answer, Exception):
            raise self.answer
        return dict.fromkeys(self.nthreads(), self.answer)

    def map(self, _: object, batches: tuple[Batch, ...], *, pure: bool) -> list[Client]:
        assert not pure
        return [Client(self.answer) for _ in batches]

    def result(self) -> object:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer

    def cancel(self, futures: list[Client]) -> None:
        self.cancelled = len(futures)


def test_workers_of_another_version_are_refused() -> None:
    assert spread._check_workers(Client(spread.worker_version()), "tcp://h:1") == 3
    with pytest.raises(StudyError, match=r"tcp://h:1 have torsio 9\.9\.9, this is \d"):
        spread._check_workers(Client("9.9.9"), "tcp://h:1")


def test_workers_without_torsio_are_refused() -> None:
    with pytest.raises(StudyError, match=r"cannot use torsio: No module named 'torsio'"):
        spread._check_workers(Client(ImportError("No module named 'torsio'")), "tcp://h:1")


@pytest.mark.parametrize("name", ["CancelledError", "KilledWorker", "CommClosedError"])
def test_lost_cluster_is_one_clear_error(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = importlib.import_module("distributed")
    why = {
        "CancelledError": lambda: distributed.CancelledError("gone"),
        "KilledWorker": lambda: distributed.KilledWorker("task", None, 3),
        "CommClosedError": lambda: importlib.import_module("distributed.comm").CommClosedError(),
    }[name]()
    client = Client(why)
    monkeypatch.setattr(distributed, "as_completed", lambda futures, loop: iter(futures))
    with pytest.raises(StudyError, match=rf"the cluster was lost \({name}\).*run again to go on"):
        list(spread._from_cluster(distributed, client, BATCHES, devices.evaluate_batch))
    assert client.cancelled == len(BATCHES)


class Deadly:
    """Kills the process that receives it."""

    def __reduce__(self) -> tuple[Callable[[int], object], tuple[int]]:
        return os._exit, (1,)


def test_worker_process_that_dies_is_one_clear_error() -> None:
    work: Any = (Deadly(), Deadly())
    with (
        pytest.raises(StudyError, match=r"a worker process died;.*run again to go on"),
        spread.spread(work, workers=2) as (_, results),
    ):
        list(results)


def test_no_more_processes_than_cores_that_may_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {3}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    with spread.spread(BATCHES) as (workers, _):
        assert workers == 1


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


@pytest.mark.parametrize(
    "address",
    ["", "nonsense", "nonsense://here", "tcp://host", "tcp://:8786", "tcp://ho st:1", "http://h:1"],
)
def test_address_that_is_none_is_refused_before_dask_is_asked(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(StudyError, match="is no address of a Dask scheduler: give one such as"),
        spread.spread(BATCHES, scheduler=address),
    ):
        pass


@pytest.mark.parametrize("address", ["host:8786", "tcp://10.0.0.1:8786", "tls://[::1]:8786"])
def test_address_of_a_scheduler_is_let_through(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)  # as if it were not installed
    with (
        pytest.raises(StudyError, match="a scheduler needs the package distributed"),
        spread.spread(BATCHES, scheduler=address),
    ):
        pass
