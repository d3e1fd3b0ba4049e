"""Find or fetch hidapi's sources, to be compiled into what is handed out as a file.

``python -m tools.hidapi_source FOLDER`` downloads the distribution's source package, unpacks what
hidapi's authors published into FOLDER and prints where it is. Nothing of it is ever committed.
"""

from __future__ import annotations

import sys
from pathlib import Path

from tools import apt

HINT = "hidapi's sources come from the distribution's source package, through apt"


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


def main(arguments: list[str]) -> int:
    """Print the folder, or say on standard error why there is none."""
    try:
        print(locate(Path(arguments[0])))
    except (RuntimeError, OSError) as error:
        print(f"{error}\n{HINT}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
