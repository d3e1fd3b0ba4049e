"""Makes the documents a site, in ``build/site/html``: a folder that any host can serve.

``python -m tools.site``, or ``./dev site``. Sphinx makes the pages from the documents, the Python
reference from the docstrings, and the C++ reference from the headers' comments. ``docs/README.md``
orders the pages. The first page has the studio in it, with the emulated knob.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from tools import cpp_reference

TREE = Path(__file__).parent.parent
BUILD = TREE / "build/site"
SOURCE = BUILD / "source"
HTML = BUILD / "html"
PAGE = TREE / "build/studio/page"
DOXYGEN = BUILD / "doxygen"

_MODULES = (
    *("torsio", "torsio.emulator", "torsio.closed_loop", "torsio.protocol", "torsio.telemetry"),
    *("torsio.studio", "torsio.knob.firmware", "torsio.printed.told"),
)

_CONFIGURATION = '''\
"""Settings of Sphinx; written by tools/site.py."""
project = "Torsio"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "breathe"]
breathe_default_project = "torsio"
breathe_projects = {"torsio": "../doxygen/xml"}
breathe_show_include = False
myst_heading_anchors = 3
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "inherited-members": False}
napoleon_google_docstring = False
napoleon_use_ivar = True
html_theme = "furo"
html_title = "Torsio"
html_show_copyright = False
exclude_patterns = []
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
'''
_FIRST = """\
# Torsio

Torsio is a USB knob that pushes back. The knob below runs the firmware's own sources in your
browser: press **arm** and drag it into the wall. **Esc** lets go.

Start here if you [have a knob](how-to/permission.md), [build one](how-to/hardware.md),
[have no hardware](tutorials/first-wall.md),
[test an application](tutorials/test-your-program.md), or [play games](reference/games.md).

<iframe src="studio/index.html" title="The studio, with an emulated knob"
  style="width:100%;height:46rem;border:1px solid var(--color-background-border)"></iframe>

Licence: [MIT](../LICENSE). Parts by others have [their own](../NOTICES.md).

"""
# README's parts that the first page has too.
_START = ("Try it", "How it works", "In Python", "State")


def _toctree(title: str, pages: Iterable[str]) -> str:
    return "\n".join(["```{toctree}", f":caption: {title}", ":maxdepth: 1", "", *pages, "```", ""])


def _start() -> str:
    """Give README's first steps, with links as a document has them."""
    text = (TREE / "README.md").read_text(encoding="utf-8")
    parts = re.findall(r"^## (.+)\n((?:(?!^## ).*\n)+)", text, re.M)
    chosen = "".join(f"## {title}\n{body}" for title, body in parts if title in _START)
    return chosen.replace("](docs/", "](")


def lists() -> dict[str, list[str]]:
    """Give the documents by their kind, as docs/README.md lists them."""
    text = (TREE / "docs/README.md").read_text(encoding="utf-8")
    sections = re.findall(r"^## (.+)\n((?:(?!^## ).*\n)+)", text, re.M)
    return {title: re.findall(r"\]\(([^.)]+)\.md\)", section) for title, section in sections}


def _reference() -> list[str]:
    """Write the pages that name modules and headers, and return the headers' pages."""
    folder = SOURCE / "names"
    folder.mkdir()
    for module in _MODULES:
        # A knob's methods stand in several modules; what exceptions inherit is Python's own.
        options = (
            ":imported-members:\n   :inherited-members: Exception" if module == "torsio" else ""
        )
        (folder / f"{module}.md").write_text(
            f"# {module}\n\n```{{eval-rst}}\n.. automodule:: {module}\n   :members:\n"
            f"{'   ' + options if module == 'torsio' else ''}\n```\n",
            encoding="utf-8",
        )
    return cpp_reference.write_pages(cpp_reference.read_headers(DOXYGEN), folder)


def write_source() -> None:
    """Gather what Sphinx reads."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    shutil.copytree(TREE / "docs", SOURCE)
    headers = [f"names/{name}" for name in _reference()]
    trees = {}
    for title, pages in lists().items():
        if pages:  # README's part is the first page
            trees[title] = pages
        if title == "Reference":
            trees["Python, name by name"] = [f"names/{module}" for module in _MODULES]
            trees["C++, name by name"] = headers
    (SOURCE / "README.md").unlink()
    first = _FIRST + _start() + "\n".join(_toctree(title, pages) for title, pages in trees.items())
    (SOURCE / "index.md").write_text(first, encoding="utf-8")
    (SOURCE / "conf.py").write_text(_CONFIGURATION, encoding="utf-8")
    for page in SOURCE.rglob("*.md"):
        if "names" not in page.parts:
            _bring_along(page)


def _bring_along(page: Path) -> None:
    """Have a page's links out of the documents lead to copies of the files; to folders, nowhere."""
    inside = page.relative_to(SOURCE)

    def link(found: re.Match[str]) -> str:
        words, target = found.groups()
        file = (TREE / "docs" / inside.parent / target).resolve()
        if file.is_relative_to(TREE / "docs") or not file.exists():
            return found[0]  # what leads nowhere Sphinx tells
        if file.is_dir():
            return f"{words} (`{file.relative_to(TREE)}`)"
        copy = SOURCE / "tree" / file.relative_to(TREE)
        copy.parent.mkdir(parents=True, exist_ok=True)
        # Another document would be a page that no list names.
        copy = copy.with_suffix(".txt") if copy.suffix == ".md" else copy
        shutil.copy2(file, copy)
        return f"[{words}]({'../' * (len(inside.parts) - 1)}{copy.relative_to(SOURCE)})"

    text = page.read_text(encoding="utf-8")
    page.write_text(re.sub(r"\[([^\]]*)\]\((\.\./[^)#]+)\)", link, text), encoding="utf-8")


def main() -> int:
    """Make the site; a link that leads nowhere is an error."""
    write_source()
    shutil.rmtree(HTML, ignore_errors=True)
    options = ("-q", "-W", "--keep-going", "-j", "2", "-d", str(BUILD / "doctrees"))
    command = [sys.executable, "-m", "sphinx", *options, str(SOURCE), str(HTML)]
    done = subprocess.run(command, check=False)
    if done.returncode:
        return done.returncode
    if PAGE.is_dir():
        shutil.copytree(PAGE, HTML / "studio")
        # Here it has the documents beside it, and links to them.
        index = HTML / "studio/index.html"
        page = index.read_text(encoding="utf-8")
        documents = '<meta name="documents" content="../" />'
        index.write_text(page.replace("<head>", f"<head>\n    {documents}"), encoding="utf-8")
    print(f"the site is in {HTML.relative_to(TREE)}; serve it with any web server")
    return 0


if __name__ == "__main__":
    sys.exit(main())
