"""Results that one worker of pytest works out for all of them."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any


def once(file: Path, make: Callable[[], Any]) -> Any:
    """Return what a function gives, which is called by the first worker of a run alone.

    Parameters
    ----------
    file
        Keeps the result, as JSON.
    make
        Its result must survive JSON.
    """
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID", "")
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if run and file.exists():
            known = json.loads(file.read_text())
            if known["run"] == run:
                return known["result"]
        result = make()
        file.write_text(json.dumps({"run": run, "result": result}))
    return result
