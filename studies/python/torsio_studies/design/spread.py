"""Spreads the batches of a study over cores, or over machines with Dask."""

from __future__ import annotations

import contextlib
import importlib
import multiprocessing
import re
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from importlib.metadata import version
from typing import Any

from torsio.common.checks import usable_cores
from torsio_studies.common import Study, StudyError
from torsio_studies.design.devices import evaluate_batch
from torsio_studies.design.store import Store

Rows = list[dict[str, float]]
Results = Iterator[tuple[Any, Rows]]
Evaluate = Callable[[Any], Rows]

_ANSWER_S = 10.0  # that a scheduler has to answer
_ADDRESS = re.compile(r"((tcp|tls|ws|wss)://)?(\[[0-9a-fA-F:.]+\]|[^\s:/\[\]]+):\d{1,5}")


@contextlib.contextmanager
def spread(
    batches: Sequence[Any],
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    evaluate: Evaluate = evaluate_batch,
) -> Iterator[tuple[int, Results]]:
    """Give the number of workers and an iterator over results, in the order they are done.

    Parameters
    ----------
    scheduler
        Address of a Dask scheduler, ``tcp://host:8786``; None uses the cores of this machine.
    workers
        Processes on this machine; None takes one per core that this one may use. 1 works in this
        process.
    evaluate
        A function at the top of a module: what is done with a batch.

    Raises
    ------
    StudyError
        If the scheduler cannot be reached or has nobody who can work, or a worker dies.
    """
    if scheduler is not None:
        with _on_cluster(batches, scheduler, evaluate) as both:
            yield both
        return
    count = min(workers or usable_cores(), max(1, len(batches)))
    if count == 1:
        yield 1, ((batch, evaluate(batch)) for batch in batches)
        return
    # Fresh processes: a fork would copy threads' locks in whatever state they are.
    pool = ProcessPoolExecutor(
        count, mp_context=multiprocessing.get_context("spawn"), initializer=_ignore_interrupts
    )
    try:
        yield count, _from_pool(pool, batches, evaluate)
    finally:
        pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def complete(
    study: Study, store: Store, work: Sequence[Any], what: str, evaluate: Evaluate = evaluate_batch
) -> Iterator[tuple[int, Iterator[Rows]]]:
    """Spread the batches that a store lacks; each is kept and counted before its rows are given.

    Parameters
    ----------
    what
        Name of the designs in the batches, for who waits.
    """
    kept = store.intact(work)
    todo = [batch for batch in work if batch not in kept]
    total, left = (sum(len(batch.designs) for batch in of) for of in (work, todo))
    report = study.counter(f"{total} {what}, {total - left} of them from before", total)
    report(total - left)
    settings = study.settings

    def keep(results: Results) -> Iterator[Rows]:
        done = total - left
        for batch, rows in results:
            store.write(batch, rows)
            done += len(batch.designs)
            report(done)
            yield rows

    with spread(
        todo,
        scheduler=settings.get("scheduler"),
        workers=settings.get("workers"),
        evaluate=evaluate,
    ) as (workers, results):
        yield workers, keep(results)


def _ignore_interrupts() -> None:
    """Leave Ctrl-C to the process that has started this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _from_pool(pool: ProcessPoolExecutor, batches: Sequence[Any], evaluate: Evaluate) -> Results:
    futures = {pool.submit(evaluate, batch): batch for batch in batches}
    try:
        for future in as_completed(futures):
            yield futures[future], future.result()
    except BrokenProcessPool:
        raise StudyError(
            "a worker process died; what was done before is kept: run again to go on"
        ) from None


def worker_version() -> str:
    """Give the version of torsio where this runs."""
    return version("torsio")


@contextlib.contextmanager
def _on_cluster(
    batches: Sequence[Any], address: str, evaluate: Evaluate
) -> Iterator[tuple[int, Results]]:
    # Asked here, for a client that was given something else complains from its threads for long.
    if not _ADDRESS.fullmatch(address):
        raise StudyError(
            f"{address!r} is no address of a Dask scheduler: give one such as tcp://host:8786"
        )
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        raise StudyError(
            "a scheduler needs the package distributed; in a clone of the project: "
            "pip install './studies[cluster]'"
        ) from None
    try:
        client = distributed.Client(address, timeout=_ANSWER_S, set_as_default=False)
    except (OSError, ValueError) as error:
        # The last line says what went wrong; those before it are the inside of Dask.
        why = (str(error).strip().splitlines() or [type(error).__name__])[-1]
        raise StudyError(
            f"no Dask scheduler answers at {address} within {_ANSWER_S:.0f} s: {why}"
        ) from None
    with client:
        yield _check_workers(client, address), _from_cluster(distributed, client, batches, evaluate)


def _check_workers(client: Any, address: str) -> int:
    cores = int(sum(client.nthreads().values()))
    if cores == 0:
        raise StudyError(
            f"the scheduler at {address} has no workers: start some with dask worker {address}"
        )
    try:
        versions = set(client.run(worker_version).values())
    except Exception as error:
        raise StudyError(f"the workers at {address} cannot use torsio: {error}") from None
    if versions != {worker_version()}:
        raise StudyError(
            f"the workers at {address} have torsio {', '.join(sorted(versions))}, "
            f"this is {worker_version()}"
        )
    return cores


def _from_cluster(
    distributed: Any, client: Any, batches: Sequence[Any], evaluate: Evaluate
) -> Results:
    futures = dict(zip(client.map(evaluate, batches, pure=False), batches, strict=True))
    try:
        for future in distributed.as_completed(list(futures), loop=client.loop):
            yield futures[future], future.result()
    except (OSError, distributed.CancelledError, distributed.KilledWorker) as error:
        raise StudyError(
            f"the cluster was lost ({type(error).__name__}); what was done before is kept: "
            "run again to go on"
        ) from None
    finally:
        client.cancel(list(futures))
