"""Find or fetch hidapi's sources, to be compiled into what is handed out as a file.

It is what hidapi's authors published, from the distribution's source package. Nothing of it is ever
committed.
"""

from __future__ import annotations

from pathlib import Path

from tools import apt


def locate(folder: Path) -> Path:
    """Return the folder of hidapi's sources, fetching them if they are not there.

    Raises
    ------
    RuntimeError
        If they cannot be had.
    """
    found = sorted(folder.glob("hidapi-*/hidapi/hidapi.h"))
    if not found:
        suite = apt.os_release("VERSION_CODENAME")
        components = "universe" if apt.os_release("ID") == "ubuntu" else "main"
        source = (apt.system_archive(), suite, components)
        packages = apt.PrivateApt(folder / "apt", [source], "deb-src")
        archive = packages.download_source("hidapi")
        apt.run(["tar", "-xf", str(archive), "-C", str(folder.resolve())], folder)
        found = sorted(folder.glob("hidapi-*/hidapi/hidapi.h"))
    if not found:
        raise RuntimeError("the source package of hidapi has no hidapi/hidapi.h")
    return found[-1].parent.parent.resolve()
