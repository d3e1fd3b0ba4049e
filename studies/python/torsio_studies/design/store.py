"""Results of a large study on disk: one small Parquet file a batch.

A file appears whole or not at all, so that a run which is interrupted, by whatever, loses at most
the batches it was working on, and the next run goes on from there.
"""

from __future__ import annotations

import errno
import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt
import pyarrow
from pyarrow import parquet

from torsio.common.whole_file import content
from torsio_studies.common import StudyError, write_atomically

Array = npt.NDArray[np.float64]
_KEY = b"torsio_design"  # and of other studies: files of old must stay readable
_DIGEST = b"torsio_digest"


class Batch(Protocol):
    """Part of the work that is computed and stored together."""

    @property
    def group(self) -> str:
        """Its table."""

    @property
    def index(self) -> int:
        """Its part of the table."""

    @property
    def designs(self) -> tuple[Any, ...]:
        """Computed rows."""


_OneOf = TypeVar("_OneOf", bound=Batch)


def _digest(table: Any) -> bytes:
    """Give what changes with any name or number: Parquet's checksums leave out its headers."""
    return hashlib.sha256(repr(table.to_pydict()).encode()).hexdigest().encode()


class Store:
    """A folder of results that belong together.

    Parameters
    ----------
    folder
        Made if it is not there.
    settings
        Settings that the numbers depend on, beside the designs; other results are refused.

    Raises
    ------
    StudyError
        If the folder cannot be made.
    """

    def __init__(self, folder: Path, settings: dict[str, Any]) -> None:
        self.folder = folder
        self._key = json.dumps(settings, sort_keys=True).encode()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StudyError(f"cannot make {folder}: {error.strerror}") from None

    def path(self, batch: Batch) -> Path:
        """Give where a batch is kept."""
        return self.folder / f"{batch.group}-{batch.index:06}.parquet"

    def intact(self, batches: Sequence[_OneOf]) -> set[_OneOf]:
        """Give the batches that are here already, having looked into every one.

        Raises
        ------
        StudyError
            If one is damaged or belongs to other settings; nothing is changed.
        """
        return {
            batch
            for batch in batches
            if self.path(batch).exists() and len(self._read(batch)) == len(batch.designs)
        }

    def write(self, batch: Batch, rows: Sequence[dict[str, float]]) -> None:
        """Keep a batch, whole or not at all.

        Raises
        ------
        StudyError
            If that fails, for want of space for instance; everything earlier is kept.
        """
        table = pyarrow.Table.from_pylist(list(rows))
        self._write(table, self.path(batch))

    def _write(self, table: Any, path: Path) -> None:
        table = table.replace_schema_metadata({_KEY: self._key, _DIGEST: _digest(table)})
        try:
            write_atomically(
                path,
                lambda partial: parquet.write_table(table, str(partial), write_page_checksum=True),
            )
        except StudyError as error:
            raise StudyError(
                f"{error}; batches already in {self.folder} are kept: run again to go on"
            ) from None

    def _read(self, batch: Batch) -> Any:
        path = self.path(batch)
        try:
            # As one file, whatever Parquet files lie beside it; memory, so that it is closed again.
            file = parquet.ParquetFile(
                pyarrow.BufferReader(content(path)), page_checksum_verification=True
            )
            table = file.read()
            digest = _digest(table)
        except (OSError, ValueError, pyarrow.ArrowException) as error:
            if isinstance(error, OSError) and error.errno not in (None, errno.EINVAL):
                raise StudyError(f"cannot read {path}: {error.strerror}") from None
            raise self._damaged(path) from None
        metadata = table.schema.metadata or {}
        if metadata.get(_KEY) != self._key or _DIGEST not in metadata:
            raise StudyError(
                f"{path} holds results of other settings or of another version; they are left "
                "alone: give another folder with --results"
            )
        if metadata[_DIGEST] != digest:
            raise self._damaged(path)
        return table

    @staticmethod
    def _damaged(path: Path) -> StudyError:
        return StudyError(
            f"{path} is damaged: delete it to have it computed again; all others are kept"
        )

    def read(self, batches: Sequence[Batch]) -> dict[str, dict[str, Array]]:
        """Give all results: per group, per column, shape (n,)."""
        tables: dict[str, list[Any]] = {}
        for batch in batches:
            tables.setdefault(batch.group, []).append(self._read(batch))
        joined = {group: pyarrow.concat_tables(parts) for group, parts in tables.items()}
        return {
            group: {
                name: np.asarray(table[name].to_numpy(), dtype=np.float64)
                for name in table.column_names
            }
            for group, table in joined.items()
        }

    def merge(self, batches: Sequence[Batch], path: Path) -> Path:
        """Put all results into one file, with the group as first column."""
        parts = []
        for batch in batches:
            table = self._read(batch)
            group = pyarrow.array([batch.group] * len(table), pyarrow.string())
            parts.append(table.add_column(0, "group", group))
        self._write(pyarrow.concat_tables(parts), path)
        return path
