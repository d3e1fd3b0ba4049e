"""Find or fetch Raspberry Pi's SDK and TinyUSB, which the firmware is built with.

``python -m tools.firmware_sources FOLDER`` prints the SDK's folder. In this order it takes

1. ``PICO_SDK_PATH``, if that is set: a checkout with its submodule ``lib/tinyusb``;
2. the packages ``pico-sdk-source`` and ``tinyusb-source``, if they are installed;
3. the same packages, downloaded and unpacked into FOLDER. Distributions that are older than the
   packages get them from a newer release, through an apt state of its own: nothing on the system
   changes, nothing is installed, and no rights are needed.

Only the standard library is used: this runs before there is an environment.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

PACKAGES = ("pico-sdk-source", "tinyusb-source")
NEWER = {"debian": ("trixie", "forky", "sid"), "ubuntu": ("plucky", "questing", "resolute")}
SDK = Path("usr/src/pico-sdk")
_ETC = Path("/etc/apt")


@dataclass(frozen=True)
class Archive:
    """Where the system gets its packages from."""

    uri: str
    signed_by: str = ""


def is_sdk(folder: Path) -> bool:
    """Tell whether a folder holds the SDK with TinyUSB."""
    tinyusb = folder / "lib/tinyusb/src/portable/raspberrypi/rp2040/dcd_rp2040.c"
    return (folder / "pico_sdk_init.cmake").exists() and tinyusb.exists()


def parse_sources(text: str) -> Archive | None:
    """Return the first archive of packages in a ``.sources`` or ``.list`` file.

    Security archives are passed over: they hold no other release's packages.
    """
    fields: dict[str, str] = {}
    for line in [*text.splitlines(), ""]:
        if line.startswith("#"):
            continue
        if match := re.match(r"([A-Za-z-]+):\s*(.*)", line):
            fields[match.group(1).lower()] = match.group(2).strip()
        elif match := re.match(r"deb\s+(?:\[([^]]*)\]\s+)?(\S+)\s+(\S+)\s", line):
            options, uri, suite = match.groups(default="")
            signed_by = re.search(r"signed-by=(\S+)", options)
            if "security" not in uri + suite:
                return Archive(uri, signed_by.group(1) if signed_by else "")
        elif not line.strip():
            uri = fields.get("uris", "").split(" ")[0]
            suites = fields.get("suites", "")
            usable = "deb" in fields.get("types", "").split() and "main" in fields.get(
                "components", ""
            )
            if uri and usable and "security" not in uri + suites:
                return Archive(uri, fields.get("signed-by", ""))
            fields = {}
    return None


def system_archive() -> Archive:
    """Return the system's own archive.

    Raises
    ------
    RuntimeError
        If there is none.
    """
    parts = _ETC / "sources.list.d"
    files = [*sorted(parts.glob("*.sources")), _ETC / "sources.list", *sorted(parts.glob("*.list"))]
    distributions = tuple(NEWER)
    for file in files:
        archive = parse_sources(file.read_text(encoding="utf-8")) if file.exists() else None
        ours = file.name.startswith(distributions)
        if archive and (ours or any(name in archive.uri for name in distributions)):
            return archive
    raise RuntimeError("apt knows no archive of this distribution")


def distribution() -> str:
    """Return ``debian`` or ``ubuntu``, or whatever the system calls itself."""
    release = Path("/etc/os-release").read_text(encoding="utf-8")
    match = re.search(r'^ID="?([a-z]+)', release, re.M)
    return match.group(1) if match else ""


def private_apt(folder: Path, archive: Archive, suite: str, components: str) -> list[str]:
    """Prepare an apt state in a folder and return the options that make apt use it."""
    for name in ("lists/partial", "archives/partial", "sources", "parts"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    signed = f"Signed-By: {archive.signed_by}\n" if archive.signed_by else ""
    (folder / "sources/one.sources").write_text(
        f"Types: deb\nURIs: {archive.uri}\nSuites: {suite}\nComponents: {components}\n{signed}",
        encoding="utf-8",
    )
    # The system's own settings, proxies for example, but not its hooks: some empty the cache of
    # whatever apt runs beside this one.
    for file in (_ETC / "apt.conf.d").iterdir():
        text = file.read_text(encoding="utf-8")
        if "-Invoke" not in text:
            (folder / "parts" / file.name).write_text(text, encoding="utf-8")
    settings = {
        "Dir::Etc::SourceList": "/dev/null",
        "Dir::Etc::SourceParts": folder / "sources",
        "Dir::Etc::Parts": folder / "parts",
        "Dir::Etc::PreferencesParts": "/dev/null",
        "Dir::State::Lists": folder / "lists",
        "Dir::Cache": folder,
        "Acquire::Languages": "none",
        "Acquire::Retries": "3",
    }
    if os.geteuid() == 0:
        settings["APT::Sandbox::User"] = "root"
    return [word for name, value in settings.items() for word in ("-o", f"{name}={value}")]


def _run(command: list[str], folder: Path) -> str:
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise RuntimeError(f"{' '.join(command[:2])} failed:\n{result.stdout}{result.stderr}")
    return result.stdout


def fetch(folder: Path) -> Path:
    """Download and unpack both packages; return the SDK's folder.

    Raises
    ------
    RuntimeError
        If no release of the system's distribution could give them.
    """
    if shutil.which("apt-get") is None:
        raise RuntimeError("this system has no apt-get")
    name = distribution()
    components = "universe" if name == "ubuntu" else "main"
    archive = system_archive()
    complaints = []
    for suite in NEWER.get(name, ()):
        apt = folder / "apt"
        shutil.rmtree(folder, ignore_errors=True)
        apt.mkdir(parents=True)
        options = private_apt(apt.resolve(), archive, suite, components)
        try:
            _run(["apt-get", "-q", *options, "update"], apt)
            _run(["apt-get", "-q", *options, "download", *PACKAGES], apt)
            for package in sorted(apt.glob("*.deb")):
                _run(["dpkg-deb", "-x", str(package.resolve()), str(folder.resolve())], apt)
        except RuntimeError as error:
            complaints.append(f"{suite}: {error}")
            continue
        shutil.rmtree(apt)
        if is_sdk(folder / SDK):
            return folder / SDK
    raise RuntimeError("\n".join(complaints) or f"no known release of {name or 'this system'}")


def locate(folder: Path) -> Path:
    """Return the SDK's folder, fetching it into ``folder`` if there is no other.

    Raises
    ------
    RuntimeError
        If ``PICO_SDK_PATH`` is not an SDK, or nothing could be fetched.
    """
    if chosen := os.environ.get("PICO_SDK_PATH"):
        if not is_sdk(Path(chosen)):
            raise RuntimeError(f"PICO_SDK_PATH={chosen} is not Raspberry Pi's SDK with lib/tinyusb")
        return Path(chosen).resolve()
    for candidate in ("/" / SDK, folder / SDK):
        if is_sdk(candidate):
            return candidate.resolve()
    return fetch(folder).resolve()


def main(arguments: list[str]) -> int:
    """Print the SDK's folder, or say on standard error why there is none."""
    try:
        print(locate(Path(arguments[0])))
    except RuntimeError as error:
        hint = "set PICO_SDK_PATH to a checkout of pico-sdk with its submodule lib/tinyusb"
        print(f"{error}\n{hint}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
