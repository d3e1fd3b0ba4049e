"""Keeps what runs inside the guests apart from what runs on the host."""

from __future__ import annotations

import os

from tests.vm.guests import GUEST_VARIABLE

collect_ignore = [] if GUEST_VARIABLE in os.environ else ["guest"]
