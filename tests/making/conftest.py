"""Drawing and finite elements have an environment of their own, behind this one's."""

from __future__ import annotations

import site
import sys
from pathlib import Path

_ENVIRONMENT = Path(__file__).parents[2] / "build/hardware"
_VERSION = f"python{sys.version_info[0]}.{sys.version_info[1]}"
site.addsitedir(str(_ENVIRONMENT / "lib" / _VERSION / "site-packages"))
