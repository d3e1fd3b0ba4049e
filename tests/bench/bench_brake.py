"""``./dev bench brake`` runs tests/studies/brake.py, which says what it measures."""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
runpy.run_module("tests.studies.brake", run_name="__main__")
