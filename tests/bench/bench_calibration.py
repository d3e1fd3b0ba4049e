"""``./dev bench calibration`` runs tests/studies/calibration_binary.py, where more is said."""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
runpy.run_module("tests.studies.calibration_binary", run_name="__main__")
