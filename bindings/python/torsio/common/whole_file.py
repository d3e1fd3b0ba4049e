"""Files that are written wholly or not at all."""

from __future__ import annotations

import errno
import json
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from torsio.errors import Error, InvalidArgument

_MOST_BYTES = 256 * 1024 * 1024


def content(path: str | Path) -> bytes:
    """Read a file that may be none of ours, and without an end. Raises `OSError`, if huge too."""
    try:
        with Path(path).open("rb") as file:
            read = file.read(_MOST_BYTES + 1)
    except OSError as error:  # a read does not name the file
        raise OSError(error.errno, error.strerror, str(path)) from None
    if len(read) > _MOST_BYTES:
        raise OSError(
            errno.EFBIG, f"more than {_MOST_BYTES >> 20} MiB is no file of Torsio's", str(path)
        )
    return read


def text_of(path: str | Path) -> str:
    """Read a text, also as PowerShell's redirection and Notepad write it.

    Raises
    ------
    InvalidArgument
        It is no text; says so with the file's name.
    OSError
        From `content`.
    """
    read = content(path)
    try:
        return read.decode(json.detect_encoding(read))
    except UnicodeDecodeError as error:
        raise InvalidArgument(f"{path} is no text: {error}") from None


def user_folder(kind: str) -> Path:
    """Give the user's folder for files of a kind, whether it exists or not."""
    home = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share"
    return Path(home) / "torsio" / kind


def keep_text(path: Path, text: str) -> None:
    """Write a file, whole or not at all, and its folders. Raises `Error` if that fails."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with beside(path) as part:
            part.write_text(text, encoding="utf-8")
    except OSError as error:
        raise Error(f"cannot write {path}: {error.strerror}") from None


@contextmanager
def beside(path: str | Path) -> Iterator[Path]:
    """Give a place beside a file's, and put what is written there in the file's when it is whole.

    If anything is raised, a full disk for example, the file is as it was before. The ending of the
    name stays, which tells some writers the format; so do owner and mode of the file. An error of
    the place is an error of the file, by its own name. A pipe or a device is given itself.
    """
    file = Path(path).resolve()
    if file.exists() and not (file.is_file() or file.is_dir()):
        yield file
        return
    # A longer ending names no format, and may leave no room for the rest of the name.
    part = file.with_name(f".part-{os.getpid()}-{os.urandom(4).hex()}{file.suffix[:32]}")
    try:
        # So that whatever writes finds the folder; nobody may read more than of the file.
        part.touch(0o600 if file.exists() else 0o666, exist_ok=False)
        yield part
        if file.exists():
            if sys.platform != "win32":
                with suppress(OSError):  # only root may give files away
                    os.chown(part, file.stat().st_uid, file.stat().st_gid)
            with suppress(OSError):  # a disk without modes; otherwise fewer may read it
                shutil.copymode(file, part)
        part.replace(file)
    except OSError as error:
        if error.filename not in (None, str(part)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        with suppress(OSError):  # a wrong place is reported already
            part.unlink()
