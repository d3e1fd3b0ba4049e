"""The tree's size and shape beside an older revision's, as tables for docs/results.md.

``./dev bench tree [REVISION]`` counts lines of text and files by folder, printed files apart, and
looks for each folder's most complex function, by lizard. Then it tells what the pages say of a
tick, how many files by hand of the product name `ShaftConfig`, and what went and came since by
``git diff --numstat``. Last it counts each row of what the page lists as taken out.
"""

from __future__ import annotations

import csv
import re
import subprocess
import sys
import tarfile
import tempfile
from collections import Counter
from io import BytesIO
from pathlib import Path

from tools.lengths import PRINTED

TREE = Path(__file__).parents[2]
PRODUCT = ("firmware", "emulator", "sdk", "bindings", "studies", "studio", "hardware", "tools")
FOLDERS = (*PRODUCT[:7], "examples", "tools", "tests", "docs")
TOLD = {
    "instructions of a tick, one wall, `pico2`, `pico`": r"^\| one wall \| (.+) \| (.+) \|$",
    "the same with the law `calibrated`": r"^\| one wall, with .+`calibrated` \| (.+) \| (.+) \|$",
}


def git(*command: str) -> bytes:
    return subprocess.run(["git", *command], cwd=TREE, stdout=subprocess.PIPE, check=True).stdout


def taken_out() -> list[str]:
    """Give the page's rows, with the lines that their commits took out of their paths.

    What a commit adds there, or puts back, counts against it.
    """
    page = (TREE / "docs/results.md").read_text(encoding="utf-8")
    table = page.partition("<!-- begin: taken out -->")[2].partition("<!-- end")[0]
    rows, sums = [], [0, 0]
    for what, commits, paths, instead in re.findall(
        r"^\| (.+?) \| [-\d,]+ \| ([0-9a-f ]{8,}) \| `(.+?)` \| (.+) \|$", table, re.M
    ):
        shown = git("show", "--numstat", "--format=", *commits.split(), "--", *paths.split())
        lines = 0
        for added, removed, name in (line.split("\t") for line in shown.decode().splitlines()):
            less = 0 if added == "-" else int(removed) - int(added)
            lines += less
            sums[name.startswith("tests/")] += less
        rows.append(f"| {what} | {lines:,} | {commits} | `{paths}` | {instead} |")
    return [*rows, f"| all | {sum(sums):,} | | of it `tests` {sums[1]:,} | |"]


def told_by(tool: str, *arguments: str | Path) -> str:
    command = [Path(sys.executable).parent / tool, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def complexities(folder: Path) -> list[tuple[int, str]]:
    languages = ("-l", "cpp", "-l", "python", "-l", "typescript")
    rows = csv.reader(told_by("lizard", *languages, "--csv", folder).splitlines())
    return [(int(row[1]), row[7].rpartition("::")[2]) for row in rows]


class Shape:
    """A revision: lines by path, what is printed, pages, and the most complex functions."""

    def __init__(self, revision: str, folder: Path) -> None:
        with tarfile.open(fileobj=BytesIO(git("archive", revision))) as archive:
            archive.extractall(folder, filter="data")
        self.files: dict[str, int] = {}
        self.printed: set[str] = set()
        self.shaft = 0
        for path in sorted(folder.rglob("*")):
            name = str(path.relative_to(folder))
            skipped = path.suffix == ".svg" or path.name == "package-lock.json"
            if skipped or not path.is_file() or b"\0" in path.read_bytes():
                continue
            text = path.read_text(encoding="utf-8", errors="replace")
            self.files[name] = text.count("\n")
            if PRINTED in text[:450]:
                self.printed.add(name)
            elif name.startswith(PRODUCT):
                by_hand = re.sub("begin: generated.*?end: generated", "", text, flags=re.S)
                self.shaft += bool(re.search("ShaftConfig|shaft_config", by_hand))
        pages = sorted((folder / "docs").rglob("*.md"))
        self.pages = "\n".join(page.read_text(encoding="utf-8") for page in pages)
        self.worst: dict[str, str] = {}
        for part in PRODUCT:
            if found := complexities(folder / part):
                count, name = max(found)
                self.worst[part] = f"`{name}` {count}"

    def of(self, folder: str) -> list[str]:
        return [
            name for name in self.files
            if name.startswith(f"{folder}/") and name not in self.printed
        ]  # fmt: skip

    def told(self, pattern: str) -> str:
        found = re.search(pattern, self.pages, re.M)
        return ", ".join(found.groups()) if found else ""


def main(revision: str = "8065d3eb") -> None:
    """Print the tables."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as other:
        before, now = Shape(revision, Path(one)), Shape("HEAD", Path(other))
    both = (before, now)

    def row(name: str, files: list[list[str]], *more: str) -> None:
        lines = [
            f"{sum(of.files[name] for name in n):,}" for of, n in zip(both, files, strict=True)
        ]
        counts = [f"{len(n):,}" for n in files]
        print(f"| {' | '.join([name, *lines, *counts, *more])} |")

    for folder in FOLDERS:
        files = [of.of(folder) for of in both]
        shown = []
        for of, names in zip(both, files, strict=True):
            largest = max(names, default="", key=of.files.__getitem__)
            told = f"`{largest.removeprefix(folder + '/')}`, {of.files[largest]}" if names else ""
            shown.append(told)
        row(f"`{folder}/`", files, *shown, *(of.worst.get(folder, "") for of in both))
    row("printed by `./dev generate`", [sorted(of.printed) for of in both], "", "", "", "")
    row("all", [list(of.files) for of in both], "", "", "", "")
    print()
    for name, pattern in TOLD.items():
        print(f"| {name} | {before.told(pattern)} | {now.told(pattern)} |")
    print(f"| files by hand that name `ShaftConfig` | {before.shaft} | {now.shaft} |\n")
    went: Counter[str] = Counter()
    came: Counter[str] = Counter()
    for line in git("diff", "--numstat", "-M", revision, "HEAD").decode().splitlines():
        added, removed, name = line.split("\t")
        if added != "-" and not name.endswith((".svg", ".svg}")):
            folder = re.split("[/ ]", name.lstrip("{"))[0]
            came[folder] += int(added)
            went[folder] += int(removed)
    for folder in FOLDERS:
        print(f"| `{folder}/` | {went[folder]:,} | {came[folder]:,} |")
    print("", *taken_out(), sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
