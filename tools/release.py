"""Puts a release together: ``out/release/`` with all its files, their checksums, a list of parts.

``python -m tools.release --sdk FOLDER --tinyusb FOLDER`` takes what ``./dev wheels``,
``./dev firmware`` and ``./dev site`` have made, makes the wheels that are not there, and an sdist.
Nothing in it depends on when or where it was made: ``--compare FOLDER`` tells whether another
clone's files are the same.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import io
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path

from tools import boards, parts, sdist, wheel_pythons, wheels
from tools import site as documents

TREE = Path(__file__).parent.parent
OUT = TREE / "out/release"


def pack(folder: Path, archive: Path) -> None:
    """Pack a folder, as one that has the archive's name: the same files make the same bytes."""
    top = archive.name.removesuffix(".tar.gz")
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.PAX_FORMAT) as tar:
        for file in sorted(file for file in folder.rglob("*") if file.is_file()):
            entry = tarfile.TarInfo(f"{top}/{file.relative_to(folder).as_posix()}")
            entry.size = file.stat().st_size
            entry.mtime = int(sdist.epoch())
            with file.open("rb") as content:
                tar.addfile(entry, content)
    archive.write_bytes(gzip.compress(plain.getvalue(), mtime=0))


def checksums(folder: Path) -> str:
    """Return a line for each file, as ``sha256sum --check`` reads them."""
    files = sorted(file for file in folder.iterdir() if file.name != "SHA256SUMS")
    return "".join(
        f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}\n" for file in files
    )


def is_of_this_commit(wheel: Path) -> bool:
    """Tell whether a wheel has the last commit's date; a zip counts pairs of seconds."""
    made = datetime.fromtimestamp(int(sdist.epoch()) // 2 * 2, timezone.utc)
    with zipfile.ZipFile(wheel) as files:
        return all(entry.date_time == made.timetuple()[:6] for entry in files.infolist())


def uncommitted(tree: Path) -> list[str]:
    """Return what is to be said of changes in no commit, which the sources would bring along."""
    command = ("git", "status", "--porcelain")
    changed = subprocess.run(command, cwd=tree, capture_output=True, check=True).stdout
    return ["the tree has changes that are in no commit: git status"] if changed else []


def wheels_there() -> list[Path]:
    """Return the wheels of this version."""
    return sorted(wheels.OUT.glob(f"torsio-{parts.version()}-*.whl"))


def missing_wheels() -> list[tuple[str, str]]:
    """Return machine and Python of each wheel that is not there, or is of another commit."""
    names = [wheel.name for wheel in wheels_there() if is_of_this_commit(wheel)]
    return [
        (architecture, python)
        for architecture in wheels.ARCHITECTURES
        for python in wheel_pythons.MAVEN
        if not any(f"-cp{python.replace('.', '')}-" in name and architecture in name
                   for name in names)
    ]  # fmt: skip


def make_wheels(tinyusb: str, chosen: Sequence[str], machines: Sequence[str], *more: str) -> None:
    """Make the wheels that are not there, of these Pythons and for these machines.

    Raises
    ------
    RuntimeError
        If one cannot be made, or does not work.
    """
    for machine in machines:
        pythons = [python for name, python in missing_wheels() if name == machine]
        pythons = [python for python in pythons if python in chosen]
        words = [word for python in pythons for word in ("--python", python)]
        if words and wheels.main(["--tinyusb", tinyusb, "--arch", machine, *words, *more]):
            raise RuntimeError(f"the wheels for {machine} cannot be made")


def differences(one: str, other: str) -> list[str]:
    """Return a line for each file that is not the same in two lists of checksums."""
    sums = [
        {name: digest for digest, name in (line.split("  ", 1) for line in text.splitlines())}
        for text in (one, other)
    ]
    return [
        f"{name} "
        + ("has other bytes" if name in sums[0] and name in sums[1] else "is in one only")
        for name in sorted({*sums[0], *sums[1]})
        if sums[0].get(name) != sums[1].get(name)
    ]


def collect(sdk: Path, tinyusb: str) -> list[str]:
    """Fill ``out/release``, and return what is not there.

    Raises
    ------
    RuntimeError
        If something cannot be made.
    """
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    missing = uncommitted(TREE)
    missing += [
        f"no wheel for Python {python} on {architecture}: ./dev wheels --arch {architecture} "
        f"--python {python}"
        for architecture, python in missing_wheels()
    ]
    found = [wheel for wheel in wheels_there() if is_of_this_commit(wheel)]
    firmware = [
        TREE / "build/firmware" / f"torsio-{board}.{kind}"
        for board in boards.chips()
        for kind in ("uf2", "elf")
    ]
    missing += [f"no {file.name}: ./dev firmware" for file in firmware if not file.exists()]
    for file in (*found, *(file for file in firmware if file.exists())):
        shutil.copy(file, OUT)
    sdist.make(OUT)
    if documents.HTML.is_dir():
        pack(documents.HTML, OUT / f"torsio-{parts.version()}-site.tar.gz")
    else:
        missing.append("no site: ./dev site")
    bill = parts.bill_of_materials(parts.components(Path(tinyusb), sdk))
    (OUT / f"torsio-{parts.version()}.cdx.json").write_text(bill, encoding="utf-8")
    shutil.copy(TREE / "NOTICES.md", OUT)
    (OUT / "SHA256SUMS").write_text(checksums(OUT), encoding="utf-8")
    return missing


def compare(other: Path) -> int:
    """Tell whether the same files are in another folder; return 1 if not."""
    sums = [(folder / "SHA256SUMS").read_text(encoding="utf-8") for folder in (OUT, other)]
    # The files themselves, not what was written down of them.
    for folder, text in zip((OUT, other), sums, strict=True):
        if text != checksums(folder):
            raise RuntimeError(f"{folder} does not have the files of its SHA256SUMS")
    for line in (differing := differences(*sums)):
        print(f"torsio: error: made twice: {line}", file=sys.stderr)
    if not differing:
        print(f"torsio: made twice, {len(sums[0].splitlines())} files have the same bytes")
    return 1 if differing else 0


def main(arguments: Sequence[str]) -> int:
    """Make what is missing, collect and tell; return 1 if anything is still missing."""
    parser = argparse.ArgumentParser(prog="./dev release", allow_abbrev=False)
    parser.add_argument("--sdk", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--tinyusb", help=argparse.SUPPRESS)
    parser.add_argument("--compare", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--arch", action="append", choices=wheels.ARCHITECTURES)
    parser.add_argument("--python", action="append", choices=wheel_pythons.MAVEN)
    parser.add_argument("--no-try", action="store_true", help="do not install wheels")
    options = parser.parse_args(arguments)
    try:
        if options.compare is not None:
            return compare(options.compare)
        make_wheels(
            options.tinyusb,
            options.python or [*wheel_pythons.MAVEN],
            options.arch or wheels.ARCHITECTURES,
            *(["--no-try"] if options.no_try else []),
        )
        missing = collect(options.sdk, options.tinyusb)
    except (RuntimeError, OSError) as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    print((OUT / "SHA256SUMS").read_text(encoding="utf-8"), end="")
    for line in missing:
        print(f"torsio: error: not complete: {line}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
