"""The studio's bridge: a page in a browser sees and drives a knob that Python holds.

Needs the extra ``studio``. `serve` is what ``torsio studio`` runs; see docs/studio.md.
"""

from torsio.studio.page import page_folder

__all__ = ["page_folder"]
