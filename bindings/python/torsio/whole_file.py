"""Files that are written wholly or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def beside(path: str | Path) -> Iterator[Path]:
    """Give a place beside a file's, and put what is written there in the file's when it is whole.

    If anything is raised, a full disk for example, the file is as it was before. The ending of the
    name stays, which tells some writers the format. What is wrong with the place is wrong with the
    file, by its own name.
    """
    file = Path(path).resolve()
    part = file.with_name(f".part-{os.getpid()}-{file.name}")
    try:
        part.open("wb").close()  # so that whatever writes finds the folder
        yield part
        part.replace(file)
    except OSError as error:
        if error.filename != str(part):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        with suppress(OSError):  # of a place that is wrong, which is told already
            part.unlink()
