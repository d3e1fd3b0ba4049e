"""Packages from the distribution's archive, without installing them.

An apt state of its own, in a folder: nothing on the system changes, nothing is installed, and no
rights are needed. Only the standard library is used: this runs before there is an environment.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

_ETC = Path("/etc/apt")
_DISTRIBUTIONS = ("debian", "ubuntu")


@dataclass(frozen=True)
class Archive:
    """Where the system gets its packages from."""

    uri: str
    signed_by: str = ""

    @property
    def security(self) -> Archive:
        """Where Debian keeps security updates, on the same server."""
        return Archive(re.sub(r"/debian/?$", "/debian-security", self.uri), self.signed_by)


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
    for file in files:
        archive = parse_sources(file.read_text(encoding="utf-8")) if file.exists() else None
        ours = file.name.startswith(_DISTRIBUTIONS)
        if archive and (ours or any(name in archive.uri for name in _DISTRIBUTIONS)):
            return archive
    raise RuntimeError("apt knows no archive of this distribution")


def os_release(name: str) -> str:
    """Return a value of ``/etc/os-release``: ``ID`` is ``debian`` or ``ubuntu``, for example."""
    release = Path("/etc/os-release").read_text(encoding="utf-8")
    match = re.search(rf'^{name}="?([A-Za-z0-9.]+)', release, re.M)
    return match.group(1) if match else ""


class PrivateApt:
    """An apt state in a folder, made anew, that knows the given suites only.

    Parameters
    ----------
    folder
        Is emptied first.
    sources
        Archive, suite and components, each.
    types
        Kinds to ask for: packages, or with ``deb-src`` sources.
    architecture
        Architecture of the packages, in Debian's words; empty: this machine's.

    Raises
    ------
    RuntimeError
        If the system has no apt-get, or the archives cannot be asked.
    """

    def __init__(
        self,
        folder: Path,
        sources: Iterable[tuple[Archive, str, str]],
        types: str = "deb",
        architecture: str = "",
    ) -> None:
        if shutil.which("apt-get") is None:
            raise RuntimeError("this system has no apt-get")
        shutil.rmtree(folder, ignore_errors=True)
        self.folder = folder.resolve()
        self._architecture = architecture
        for name in ("lists/partial", "archives/partial", "sources", "parts"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        self._write_sources(sources, types)
        # The system's own settings, proxies for example, but not its hooks: some empty the cache
        # of whatever apt runs beside this one.
        for file in (_ETC / "apt.conf.d").iterdir():
            text = file.read_text(encoding="utf-8")
            if "-Invoke" not in text:
                (self.folder / "parts" / file.name).write_text(text, encoding="utf-8")
        # Otherwise apt calls it a success where an archive did not answer, and later knows nothing.
        self._run("apt-get", "-o", "APT::Update::Error-Mode=any", "update")

    def _write_sources(self, sources: Iterable[tuple[Archive, str, str]], types: str) -> None:
        entries = []
        for archive, suite, components in sources:
            signed = f"Signed-By: {archive.signed_by}\n" if archive.signed_by else ""
            entries.append(
                f"Types: {types}\nURIs: {archive.uri}\nSuites: {suite}\n"
                f"Components: {components}\n{signed}"
            )
        text = "\n".join(entries)
        (self.folder / "sources/these.sources").write_text(text, encoding="utf-8")

    def _run(self, program: str, *arguments: str) -> str:
        settings = {
            "Dir::Etc::SourceList": "/dev/null",
            "Dir::Etc::SourceParts": self.folder / "sources",
            "Dir::Etc::Parts": self.folder / "parts",
            "Dir::Etc::PreferencesParts": "/dev/null",
            "Dir::State::Lists": self.folder / "lists",
            "Dir::Cache": self.folder,
            "Acquire::Languages": "none",
            "Acquire::Retries": "3",
            "Acquire::http::Timeout": "30",
        }
        if self._architecture:
            settings["APT::Architecture"] = settings["APT::Architectures"] = self._architecture
        if os.geteuid() == 0:
            settings["APT::Sandbox::User"] = "root"
        options = [word for name, value in settings.items() for word in ("-o", f"{name}={value}")]
        return run([program, "-q", *options, *arguments], self.folder)

    def dependencies(self, package: str) -> list[str]:
        """Return the names of the packages that the newest version of a package depends on."""
        record = self._run("apt-cache", "show", "--no-all-versions", package)
        match = re.search(r"^Depends: (.*)$", record, re.M)
        return re.findall(r"(?:^|, )([a-z0-9][^ ,|]*)", match.group(1)) if match else []

    def download(self, packages: Sequence[str]) -> list[Path]:
        """Download packages, without what they depend on, and return their files."""
        self._run("apt-get", "download", *packages)
        return sorted(self.folder.glob("*.deb"))

    def download_source(self, package: str) -> Path:
        """Download a source package, and return the archive that its authors published."""
        self._run("apt-get", "source", "--download-only", package)
        return next(self.folder.glob("*.orig.tar.*[!c]"))


def run(command: Sequence[str], folder: Path) -> str:
    """Run a command in a folder and return what it prints.

    Raises
    ------
    RuntimeError
        If it fails, with all that it printed.
    """
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise RuntimeError(f"{' '.join(command[:2])} failed:\n{result.stdout}{result.stderr}")
    return result.stdout
