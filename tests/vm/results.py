"""Reads what a guest reports: JUnit's XML, one case for each of its tests."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Result:
    """How one test of a guest ended.

    Attributes
    ----------
    problem
        Empty if the test passed, else all that is known.
    """

    problem: str


def test_key(node_id: str) -> tuple[str, str]:
    """Return the class and the name that JUnit has for a pytest node."""
    path, _, name = node_id.partition("::")
    return path.removesuffix(".py").replace("/", "."), name


def read_junit(file: Path) -> dict[tuple[str, str], Result]:
    """Return the result of each test; a skipped one has a problem, as everywhere in this suite.

    Raises
    ------
    ValueError
        If there is no such file, or it is not whole, or it has no tests.
    """
    try:
        root = ElementTree.parse(file).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise ValueError(f"the guest left no readable results: {error}") from error
    results: dict[tuple[str, str], Result] = {}
    for case in root.iter("testcase"):
        problems = [
            "\n".join(filter(None, (part.tag, part.get("message"), part.text)))
            for part in case
            if part.tag in ("failure", "error", "skipped")
        ]
        key = (case.get("classname", ""), case.get("name", ""))
        if earlier := results.get(key):  # an error after the test gets a case of its own
            problems.insert(0, earlier.problem)
        results[key] = Result("\n".join(filter(None, problems)))
    if not results:
        raise ValueError("the guest's results have no tests")
    return results
