"""How many files a new configuration takes: one is added to a clone of HEAD, and tried.

``./dev bench configuration`` adds `TrialConfig`, two fields and a rule across them, to the files
that CONTRIBUTING.md names, and prints the others. It builds libraries and Python module, and sets,
saves and reads it on the emulated device, from Python and C; both refuse what breaks the rule. The
last lines are rows for docs/results.md, from what git sees in the clone.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TREE = Path(__file__).parents[2]
DEFINITION = "firmware/protocol/definition/configurations.py"
REPORT = """TRIAL_CONFIG = _configuration(
    0x0D, "TrialConfig", "A trial.", "Set only while disarmed.",
    number("trial_low_rad", "rad", 0.0, 10.0, "at most the next"),
    number("trial_high_rad", "rad", 0.0, 10.0, "at least the one before", default=1.0),
)
"""
CHECK = """protocol::Verdict check_consistent(const protocol::TrialConfig& config) {
  if (config.trial_low_rad <= config.trial_high_rad) return {};
  return {protocol::Status::inconsistent, 3};
}
"""
REFUSAL = """protocol::TrialConfig to_wire(const TrialConfig& config) {
  const protocol::TrialConfig wire = convert(config);
  if (device::check_consistent(wire).ok()) return wire;
  throw InvalidArgument("trial_low_rad is above trial_high_rad");
}
"""
# File, a place in it, and what is written before the place.
BY_HAND = (
    (DEFINITION, "CONFIGURATIONS = (", REPORT),
    (DEFINITION, ")  # fmt: skip\n# Their fields", "TRIAL_CONFIG,"),
    (DEFINITION, "ACTUATOR_CONFIG, SHAFT_CONFIG)", "TRIAL_CONFIG, "),
    ("firmware/device/config.cpp", "float torque_step_nm(", CHECK),
    ("sdk/conversion/configuration.cpp", "}  // namespace torsio::conversion", REFUSAL),
)
IN_PYTHON = """import pytest, torsio
wanted = torsio.TrialConfig(trial_low_rad=0.25, trial_high_rad=0.5)
with torsio.open("emulated:trial") as knob:
    knob.configure(wanted)
    knob.save()
with torsio.open("emulated:trial") as knob:
    assert knob.trial_config() == wanted
    with pytest.raises(torsio.InvalidArgument, match="trial_low_rad is above"):
        knob.update(trial_low_rad=0.75)
"""
IN_C = """#include <torsio.h>
int main(void) {
  torsio_knob* knob;
  torsio_trial_config set, got;
  if (torsio_knob_open("emulated", 0, &knob) || torsio_trial_config_init(&set)) return 1;
  set.trial_low_rad = 0.25;
  if (torsio_knob_set_trial_config(knob, &set) || torsio_trial_config_init(&got)) return 2;
  if (torsio_knob_trial_config(knob, &got) || got.trial_low_rad != 0.25) return 3;
  set.trial_low_rad = 2.0;
  return torsio_knob_set_trial_config(knob, &set) == TORSIO_INVALID_ARGUMENT ? 0 : 4;
}
"""


def main() -> None:
    """Make the trial and print the rows."""
    with tempfile.TemporaryDirectory() as folder:
        clone, build = Path(folder) / "clone", Path(folder) / "build"

        def run(*command: str | Path) -> str:
            paths = {"PYTHONPATH": "bindings/python", "LD_LIBRARY_PATH": str(build / "sdk/c")}
            return subprocess.check_output(command, cwd=clone, env=os.environ | paths, text=True)

        clone.mkdir()
        run("git", "clone", "-q", "--shared", TREE, ".")
        for name, place, text in BY_HAND:
            old = (clone / name).read_text(encoding="utf-8")
            assert old.count(place) == 1, place
            (clone / name).write_text(old.replace(place, text + place), encoding="utf-8")
        by_hand = run("git", "diff", "--numstat").splitlines()
        run(sys.executable, "-m", "tools.definition.generate")
        changed = run("git", "diff", "--name-only").splitlines()
        options = ("-DTORSIO_BUILD_BINDINGS=ON", "-DTORSIO_BUILD_TESTS=OFF", "-DTORSIO_WERROR=ON")
        python = f"-DPython_EXECUTABLE={sys.executable}"
        run("cmake", "--preset", "release", "-B", build, *options, python)
        run("cmake", "--build", build, "--target", "torsio_c", "torsio_python")
        for module in (build / "bindings").glob("_torsio.*"):
            shutil.copy2(module, clone / "bindings/python/torsio")
        run(sys.executable, "-c", IN_PYTHON)
        (build / "trial.c").write_text(IN_C, encoding="utf-8")
        program = (build / "trial.c", "-o", build / "trial", "-Isdk/c/include")
        run("cc", *program, f"-L{build / 'sdk/c'}", "-ltorsio")
        run(build / "trial")
        assert '"trial_config": {' in run("cat", "studio/src/reports.ts")
    for added, _, name in map(str.split, by_hand):
        print(f"| by hand: `{name}` | {added} |")
    print(f"| printed by `./dev generate` | {len(changed) - len(by_hand)} files |")


if __name__ == "__main__":
    main()
