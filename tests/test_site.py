"""Sphinx gets every document, and no link leads out of the site."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tools import cpp_reference, site

TREE = Path(__file__).parent.parent
# A comment, and the name that it explains.
PUBLIC = re.compile(
    r"((?:^///.*\n)+)(?:class|struct|enum class|using) (?:TORSIO_EXPORT )?(\w+)", re.MULTILINE
)


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give what Sphinx would read."""
    folder = tmp_path_factory.mktemp("site") / "source"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(site, "SOURCE", folder)
        patch.setattr(site, "DOXYGEN", folder.parent / "doxygen")
        site.write_source()
    return folder


def _anchors(page: Path) -> set[str]:
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def test_links_in_the_tree_lead_to_files_and_headings() -> None:
    pages = [*TREE.glob("*.md"), *TREE.glob("docs/**/*.md"), *TREE.glob("examples/**/*.md")]
    lost = []
    for page in pages:
        for link in re.findall(r"(?<!\[)\]\(((?!https?:)[^)\s]+)", page.read_text()):
            path, _, anchor = link.partition("#")
            file = (page.parent / path).resolve() if path else page
            if not file.exists() or (anchor and anchor not in _anchors(file)):
                lost.append(f"{page.relative_to(TREE)}: {link}")
    assert lost == []


@pytest.fixture(scope="module")
def doxygen(source: Path) -> Path:
    """Give what Doxygen has found in the headers."""
    return source.parent / "doxygen/xml"


def test_reference_has_each_public_name_of_the_headers_with_its_sentence(
    source: Path, doxygen: Path
) -> None:
    assert cpp_reference.missing() == set()
    sentences = {entry.name: entry.sentence for entry in cpp_reference.entries(doxygen)}
    wanted = []
    for header in cpp_reference.HEADERS:
        page = (source / f"names/{header.stem}_hpp.rst").read_text().split()
        for comment, name in PUBLIC.findall(re.sub("`|docs/", "", header.read_text())):
            first, last = comment.split()[1], comment.split(".")[0].split()[-1]
            wanted.append(name)
            assert f"torsio::{name}" in page
            sentence = sentences[f"torsio::{name}"].split(".")[0].split()
            assert (sentence[0], sentence[-1]) == (first, last)
    assert {"Knob", "Wall", "Error", "Law", "Effect", "PlantParams", "DeviceWatch"} <= {*wanted}
    assert len(wanted) > 80
