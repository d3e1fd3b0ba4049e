"""The C++ reference of the site: pages that name what the headers say of each class.

Doxygen reads the headers, and Breathe shows on a page what it has read. A public name without a
sentence is an error, as is whatever else Doxygen complains of.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

TREE = Path(__file__).parent.parent
_SDK, _PLANT = TREE / "sdk/include/torsio", TREE / "emulator/include/torsio"
# In the order in which a user meets them. The lists of fields are for tools, which read them.
HEADERS = tuple(
    folder / f"{name}.hpp"
    for folder, name in (
        *(
            (_SDK, name)
            for name in (
                *(
                    "knob",
                    "knob_configurations",
                    "scene",
                    "telemetry",
                    "config",
                    "error",
                    "emulator",
                ),
            )
        ),
        (_SDK, "emulator_options"),
        (_PLANT, "plant"),
        *((_SDK, name) for name in ("config_file", "firmware", "hotplug", "transport")),
    )
)
_LEFT_OUT = {_SDK / "fields.hpp", _PLANT / "field.hpp", _PLANT / "plant_fields.hpp"}

_DOXYGEN = """\
INPUT = {input}
OUTPUT_DIRECTORY = {output}
STRIP_FROM_PATH = {tree}
QUIET = YES
WARN_AS_ERROR = FAIL_ON_WARNINGS
WARN_IF_INCOMPLETE_DOC = NO
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
# A comment's first sentence stands for the whole in a list.
JAVADOC_AUTOBRIEF = YES
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = TORSIO_EXPORT=
EXCLUDE_SYMBOLS = *::Impl operator==
# Ours name several exceptions in one sentence, and say when.
ALIASES = "throws=\\par Throws^^"
# The documents they name are pages beside the reference.
INPUT_FILTER = "sed -E 's|docs/(([a-z-]+/)?[a-z]+)[.]md|[\\1.md](../\\1.html)|g'"
"""
# A reader of the site does not edit the header.
_PRINTED = re.compile(r" *Printed from the field lists.*")


def missing() -> set[Path]:
    """Return public headers that are on no page."""
    return {*_SDK.glob("*.hpp"), *_PLANT.glob("*.hpp")} - {*HEADERS} - _LEFT_OUT


def read_headers(folder: Path) -> Path:
    """Have Doxygen read the headers, and return the folder with its output.

    Raises
    ------
    RuntimeError
        If it complains; with its complaint.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "Doxyfile"
    listed = " ".join(f'"{header}"' for header in HEADERS)
    settings = _DOXYGEN.format(input=listed, output=f'"{folder}"', tree=f'"{TREE}"')
    file.write_text(settings, encoding="utf-8")
    done = subprocess.run(
        ["doxygen", str(file)], capture_output=True, text=True, check=False, cwd=folder
    )
    if done.returncode or done.stderr:
        raise RuntimeError(f"the comments of the C++ headers:\n{done.stderr}")
    return folder / "xml"


@dataclass(frozen=True)
class Entry:
    """Something that a header has; its kind is what Doxygen and Breathe call it."""

    header: str
    line: int
    kind: str
    name: str
    sentence: str


def entries(xml: Path) -> list[Entry]:
    """Return all that the headers have outside of classes, in their order."""
    found = []
    for file in xml.glob("*.xml"):
        for compound in ElementTree.parse(file).getroot().iter("compounddef"):
            kind, name = compound.get("kind", ""), compound.findtext("compoundname", "")
            if kind in ("class", "struct") and name.count("::") == 1:
                found.append(_entry(compound, kind, name))
            for member in compound.iter("memberdef") if kind == "namespace" else ():
                called = f"{name}::{member.findtext('name')}"
                found.append(_entry(member, member.get("kind", ""), called))
    return sorted(found, key=lambda entry: (entry.header, entry.line))


def _entry(of: ElementTree.Element, kind: str, name: str) -> Entry:
    place = of.find("location")
    assert place is not None
    file, line = Path(place.get("file", "")), int(place.get("line", "0"))
    return Entry(file.name, line, kind, name, words_of(of))


def words_of(of: ElementTree.Element) -> str:
    """Return what is said of something, as plain words."""
    parts = [of.find("briefdescription"), of.find("detaileddescription")]
    return " ".join(
        " ".join("".join(part.itertext()).split()) for part in parts if part is not None
    )


def write_pages(xml: Path, folder: Path) -> list[str]:
    """Write a page for each header; gives their names, in order."""
    every = entries(xml)
    for header in HEADERS:
        about = (
            ElementTree.parse(xml / f"{header.stem.replace('_', '__')}_8hpp.xml")
            .getroot()
            .find("compounddef")
        )
        assert about is not None
        title = f"torsio/{header.name}"
        text = [title, "=" * len(title), "", _PRINTED.sub("", words_of(about)), ""]
        here = [entry for entry in every if entry.header == header.name]
        # First what the page is about: the class that is called as the header.
        here.sort(key=lambda entry: entry.name.lower() != f"torsio::{header.stem}")
        for entry in here:
            text += [f".. doxygen{entry.kind}:: {entry.name}"]
            text += ["   :members:"] if entry.kind in ("class", "struct") else []
            text += [""]
        (folder / f"{header.stem}_hpp.rst").write_text("\n".join(text), encoding="utf-8")
    return [f"{header.stem}_hpp" for header in HEADERS]
