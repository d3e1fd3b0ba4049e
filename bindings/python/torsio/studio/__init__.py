"""The studio's bridge: a page in a browser sees and drives a knob that Python holds.

`live` lets a page look on while a program drives its knob; ``torsio studio`` hands the knob to the
page. Both need the extra ``studio``. See docs/reference/studio.md.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from torsio.common import checks
from torsio.common.extras import lacking
from torsio.errors import Error
from torsio.knob import Knob, need_knob
from torsio.studio.page import page_folder

if TYPE_CHECKING:
    from torsio.studio.live_page import LivePage

__all__ = ["live", "page_folder"]


def live(knob: Knob, *, page: str | Path | None = None, port: int = 0) -> LivePage:
    """Let pages of this machine look on at a knob that this program drives.

    They see state, telemetry as the program streams it, faults and configuration, and can change
    nothing. It runs in a thread of its own until it is closed.

    Parameters
    ----------
    knob
        An open knob; the program goes on with it as before.
    page
        The folder of a built page, if it is not where the package finds it.
    port
        Port of this machine; 0 takes a free one.

    Returns
    -------
    LivePage
        Its ``address`` is to be opened in a browser; ``close()`` it, or use ``with``. A notebook of
        this machine shows the page.

    Raises
    ------
    torsio.Error
        If the page is not built, the port is in use, or what the extra brings is missing.
    """
    need_knob(knob)
    checks.whole("port", port, 0, 65535)
    try:
        from torsio.studio.live_page import LivePage
    except ModuleNotFoundError as error:
        raise Error(lacking("the studio", "studio", error)) from None
    return LivePage(knob, page_folder(page), port)
