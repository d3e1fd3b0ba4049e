"""The script ``dev`` runs this: ``python -m tools.dev COMMAND ARGUMENTS``."""

from __future__ import annotations

import sys

from tools.dev import cli

sys.exit(cli.main(sys.argv[1:]))
