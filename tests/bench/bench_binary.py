"""``./dev bench binary`` runs tests/studies/binary.py, which says what it measures."""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
runpy.run_module("tests.studies.binary", run_name="__main__")
