"""`torsio report`: all that somebody needs to look into a fault, in one file.

The file is a zip: what `torsio doctor` finds, versions, and a recording that `torsio replay` runs
again. There is nothing of the user in it but what the recording's own notes say.
"""

from __future__ import annotations

import getpass
import json
import platform
import re
import tempfile
import zipfile
from importlib.metadata import distributions
from pathlib import Path
from typing import Any, Final

import torsio
from torsio import protocol
from torsio.apps import doctor
from torsio.common.emulated import selects_emulated
from torsio.common.whole_file import beside
from torsio.errors import Error

__all__ = ["collect"]

_PACKAGES: Final = ("mcap", "numpy", "starlette", "torsio", "torsio-studies", "uvicorn")
_ABOUT: Final = """\
A report about a Torsio knob.

doctor.json     what `torsio doctor` found
versions.json   of library, protocol, Python and system
recording.mcap  what the knob did, if there is one; `torsio replay recording.mcap` runs it again

The knob's serial number is in it. Names of users, of the computer and of folders are not, unless
notes that a program made in the recording have some.
"""


def _versions() -> dict[str, Any]:
    found = {d.metadata["Name"].lower(): d.version for d in distributions()}
    return {
        "library": torsio.__version__,
        "protocol": protocol.VERSION,
        "fingerprint": f"0x{protocol.fingerprint():08x}",
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "packages": {name: found[name] for name in _PACKAGES if name in found},
    }


def _who() -> tuple[str, str]:
    """Give the user's folder and name; a container may have none."""
    try:
        user = getpass.getuser()
    except (ImportError, KeyError, OSError):
        user = ""
    try:
        return str(Path.home()), user
    except RuntimeError:
        return "", user


def _impersonal(text: str) -> str:
    """Leave out where the user lives, and what user and computer are called."""
    home, user = _who()
    if len(home) > 1:
        text = text.replace(home, "~")
    for name, word in {user: "USER", platform.node(): "HOST"}.items():
        if len(name) > 1 and name != "root":
            text = re.sub(rf"\b{re.escape(name)}\b", word, text)
    # The links of findings lead to the documents of this computer.
    text = re.sub(r"file://[^\"\s]*/(docs/)", r"\1", text)
    return re.sub(r"/\S*/(torsio/\S*)", r"\1", text)


def collect(
    selector: str, file: Path, *, recording: Path | None = None, duration_s: float = 2.0
) -> list[str]:
    """Write the report; give the names of its parts.

    Parameters
    ----------
    selector
        As for `torsio.open`; empty means all knobs that are plugged in; none is recorded then.
    file
        The file to make or overwrite; its name ends in ``.zip``.
    recording
        Your recording of the fault. None records now, if a knob can be opened.
    duration_s
        How long.

    Raises
    ------
    torsio.Error
        If the recording is none, or the file's name ends otherwise.
    OSError
        If the file cannot be written.
    """
    if file.suffix != ".zip":
        raise Error(f"a report's name ends in .zip, and {str(file)!r} does not")
    if recording is not None:
        torsio.load(recording)  # or it is no use to anybody
    reports = [report.as_dict() for report in doctor.diagnose(selector)]
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "recording.mcap"
        if recording is None:
            recording = _record(selector, made, duration_s)
        parts = {
            "README.txt": _ABOUT,
            "doctor.json": _impersonal(json.dumps(reports, indent=2)),
            "versions.json": _impersonal(json.dumps(_versions(), indent=2)),
        }
        with (
            beside(file) as part,
            zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive,
        ):
            for name, content in parts.items():
                archive.writestr(name, content)
            if recording is not None:
                archive.write(recording, "recording.mcap")
            return archive.namelist()


def _record(selector: str, file: Path, duration_s: float) -> Path | None:
    """Record the knob as it is, if it can be; the doctor has said why not."""
    options = torsio.EmulatorOptions(log_inputs=True) if selects_emulated(selector) else None
    try:
        with torsio.open(selector or None, emulator=options) as knob, knob.record_to(file):
            knob.sleep(duration_s)
    except Error:
        return file if file.exists() else None
    return file
