"""Running a study by its name."""

from __future__ import annotations

import contextlib
import importlib
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol, cast

from rich.console import Console

from torsio.common.screen import progress
from torsio_studies import STUDIES
from torsio_studies.common import (
    SCHEMA,
    Results,
    Study,
    StudyError,
    check_replaceable,
    make_folder,
    plain,
    save,
)


class _Module(Protocol):
    def run(self, study: Study) -> Results: ...
    def show(self, results: Results, console: Console) -> None: ...


def execute(
    name: str,
    *,
    json_file: Path | None = None,
    out: Path | None = None,
    quick: bool = False,
    console: Console | None = None,
    settings: dict[str, Any] | None = None,
) -> Results:
    """Run a study: progress, figures into `out`, results into `json_file`.

    Raises
    ------
    StudyError
        If there is no such study, a package that it needs is missing, or something cannot be
        written; earlier results are kept.
    """
    if name not in STUDIES:
        raise StudyError(f"there is no study {name!r}; there are {', '.join(sorted(STUDIES))}")
    if json_file is not None:
        check_replaceable(json_file, name)
    if out is not None:
        make_folder(out)
    try:
        module = cast(_Module, importlib.import_module(f"torsio_studies.{name}.study"))
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package in ("", "torsio", "torsio_studies"):
            raise  # ours, and not the user's to install
        raise StudyError(
            f"the study {name} needs the Python package {package}: pip install {package}"
        ) from None
    begin = time.perf_counter()
    study = Study(name, out, quick, settings or {})
    with contextlib.ExitStack() as stack:
        if console is not None:
            study.progress = stack.enter_context(progress(console))
        own = module.run(study)
    results: Results = {
        "schema": SCHEMA,
        "study": name,
        "torsio": version("torsio"),
        "quick": quick,
        "seconds": round(time.perf_counter() - begin, 3),
        "figures": study.figures,
        **own,
    }
    results = cast(Results, plain(results))
    if json_file is not None:
        save(results, json_file)
    if console is not None:
        module.show(results, console)
    return results
