"""A Dask cluster on this machine, and rows that two runs can be compared by."""

from __future__ import annotations

import importlib
import math
from typing import Any


def local_cluster(**options: Any) -> Any:
    distributed = importlib.import_module("distributed")
    return distributed.LocalCluster(dashboard_address=":0", **options)


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
