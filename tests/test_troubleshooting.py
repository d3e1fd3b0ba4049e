"""Whatever a knob may complain of has an entry on the page that one is sent to."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from firmware.protocol.definition import enumerations as e
from torsio.apps import doctor
from torsio.common import documents

TREE = Path(__file__).parent.parent
PAGE = (TREE / "docs/reference/troubleshooting.md").read_text(encoding="utf-8")
ENTRIES = set(re.findall(r"^### (\S+)$", PAGE, re.MULTILINE))
DOCTOR = "".join(
    file.read_text(encoding="utf-8")
    for file in (TREE / "bindings/python/torsio/apps").glob("doctor/*.py")
)

WANTED = {
    "faults": {bit.name for bit in e.FAULT.bits},
    "statuses": {value.name for value in e.STATUS.values} - {"ok"},
    "reasons": {value.name for value in e.DISARM_REASON.values},
    # The names of findings are written down where they are made, and nowhere else.
    "findings": set(re.findall(r'\bFinding\(\s*"(\w+)"', DOCTOR)),
}


@pytest.mark.parametrize("kind", WANTED)
def test_each_has_an_entry(kind: str) -> None:
    assert len(WANTED[kind]) >= 6
    assert WANTED[kind] - ENTRIES == set()


def test_no_entry_is_about_what_there_is_not() -> None:
    assert set().union(*WANTED.values()) == ENTRIES


@pytest.mark.parametrize("name", sorted(WANTED["findings"] | WANTED["faults"]))
def test_links_lead_to_an_entry_in_a_clone_and_on_a_site(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(documents, "source_folder", lambda: TREE)
    page, _, anchor = documents.entry(name).partition("#")
    assert page == (TREE / "docs/reference/troubleshooting.md").as_uri()
    assert anchor in ENTRIES
    monkeypatch.setenv(documents.VARIABLE, "https://example.org/knob/")
    page, _, anchor = documents.entry(name).partition("#")
    assert page == "https://example.org/knob/reference/troubleshooting.html"
    # Sphinx has no underscores in the ids that it makes.
    assert anchor.replace("-", "_") in ENTRIES
    assert "_" not in anchor


def test_without_clone_or_site_the_entry_is_named_within_the_project(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(documents, "source_folder", lambda: None)
    assert documents.entry("usb") == "docs/reference/troubleshooting.md#usb"


def test_doctor_sends_people_to_the_entries_of_finding_and_faults() -> None:
    for name in WANTED["findings"]:
        finding = doctor.Finding(name, False, "wrong", "mend it", faults=("over_speed",))
        assert finding.more == documents.entry(name)
        assert finding.links == [documents.entry("over_speed"), documents.entry(name)]
    fine = doctor.Finding("usb", True, "fine")
    assert (fine.more, fine.links) == ("", [])
