"""Makes the documents a site, in ``build/site/html``: a folder that any host can serve.

``python -m tools.site``, or ``./dev site``. Sphinx makes the pages from ``docs/*.md``, the Python
reference from the docstrings, and shows the C++ headers, which are that reference. On the first
page is the studio's page, with the emulated knob in it.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).parent.parent
BUILD = TREE / "build/site"
SOURCE = BUILD / "source"
HTML = BUILD / "html"
PAGE = TREE / "build/studio/page"
HEADERS = TREE / "sdk/include/torsio"

_GUIDES = ("studio", "python", "cpp", "games", "emulator", "usb", "hardware", "troubleshooting")
_BACKGROUND = ("architecture", "theory", "protocol", "threads", "reliability", "security")
_STUDIES = ("paper", "actuators", "design", "extremes", "fidelity")
_MODULES = ("torsio", "torsio.emulator", "torsio.protocol", "torsio.telemetry", "torsio.studio")

_CONFIGURATION = '''\
"""Of Sphinx; written by tools/site.py."""
project = "Torsio"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_heading_anchors = 3
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "inherited-members": False}
napoleon_google_docstring = False
napoleon_use_ivar = True
html_theme = "furo"
html_title = "Torsio"
exclude_patterns = []
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
'''
_FIRST = """\
# Torsio

A USB knob that pushes back: firmware, an emulated device that stands in for the hardware, a C++
library and a Python package. The knob below runs the device's own firmware, in your browser. Press
**arm** and drag it into the wall; **Esc** lets go.

<iframe src="studio/index.html" title="The studio, with an emulated knob"
  style="width:100%;height:46rem;border:1px solid var(--color-background-border)"></iframe>

"""


def _toctree(title: str, pages: tuple[str, ...]) -> str:
    return "\n".join(["```{toctree}", f":caption: {title}", ":maxdepth: 1", "", *pages, "```", ""])


def _reference() -> None:
    """Write the pages that name what Sphinx and the headers say themselves."""
    folder = SOURCE / "reference"
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
    for header in sorted(HEADERS.glob("*.hpp")):
        (folder / f"{header.stem}_hpp.md").write_text(
            f"# torsio/{header.name}\n\n```cpp\n{header.read_text(encoding='utf-8')}```\n",
            encoding="utf-8",
        )


def write_source() -> None:
    """Gather what Sphinx reads."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    shutil.copytree(TREE / "docs", SOURCE)
    _reference()
    headers = tuple(f"reference/{h.stem}_hpp" for h in sorted(HEADERS.glob("*.hpp")))
    trees = [
        _toctree("Guides", _GUIDES),
        _toctree("Python", tuple(f"reference/{module}" for module in _MODULES)),
        _toctree("C++", headers),
        _toctree("Background", _BACKGROUND),
        _toctree("Studies", tuple(f"studies/{name}" for name in _STUDIES)),
    ]
    (SOURCE / "index.md").write_text(_FIRST + "\n".join(trees), encoding="utf-8")
    (SOURCE / "conf.py").write_text(_CONFIGURATION, encoding="utf-8")
    # What lies outside the documents is named, as nothing can be followed there.
    games = SOURCE / "games.md"
    text = games.read_text(encoding="utf-8")
    games.write_text(text.replace("](../examples/game)", "](games.md)"), encoding="utf-8")


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
