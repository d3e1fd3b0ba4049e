"""How many files a change takes: some are made in a clone of HEAD, one after the other, and tried.

``./dev bench change`` edits the files that CONTRIBUTING.md names, and prints the others: for the
configuration `TrialConfig` and the effect `Trial`, with two fields and a rule across them each,
for a field of `ControlConfig` and for a law. It builds libraries and Python module. Then it plays,
sets, saves and reads on the emulated device, from Python, and the configuration also from C. What
breaks a rule is refused. The last lines are rows for docs/results.md, from what git sees.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

TREE = Path(__file__).parents[2]
DEFINITION = "firmware/protocol/definition/configurations.py"
LAWS = "firmware/protocol/definition/enumerations.py"
PARTITION = "firmware/core/partition.hpp"
EFFECTS = "firmware/protocol/definition/effects.py"
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
EFFECT = """TRIAL = _effect(
    0x2D, "Trial", "A trial.",
    torque("low_nm", "at most the next"), torque("high_nm", "gives what it is more"),
    example={"low_nm": 0.01, "high_nm": 0.02},
)
"""
PREPARE = """Verdict prepare_effect(const protocol::Trial& in, const Resolution&,
                       core::Effect& out) {
  if (in.high_nm < in.low_nm) {
    return {Status::inconsistent, field_index<protocol::Trial>("high_nm")};
  }
  out = core::Trial{in.high_nm - in.low_nm};
  return {};
}
"""
STRUCT = "struct Trial {\n  float torque_nm;\n};\n\n"
IN_WORDS = """    if constexpr (requires { in.high_nm; }) {
      return "high_nm is " + number_text(in.high_nm) + ", below low_nm";
    }
"""
FIELD = '    number("trial_rad", "rad", 0.0, 10.0, "a trial"),\n'
SCENE = "float torque_nm(const Trial& trial, const Moment&) { return trial.torque_nm; }\n"
CASE = """    case Law::trial:
      motor_nm = 0.5F * desired_nm;
      brake_nm = 0.0F;
      break;
"""
# File, a place in it, and what is written before the place.
BY_HAND = {
    "effect with a rule": (
        (EFFECTS, "EFFECTS = (", EFFECT),
        (EFFECTS, "    CURVE, IMPACT,", "    TRIAL,\n"),
        ("firmware/core/effects.hpp", "/// std::monostate is", STRUCT),
        ("firmware/core/effects.hpp", "Curve, Impact>;", "Trial, "),
        ("firmware/core/scene.cpp", "float torque_nm(const EndStops& stops", SCENE),
        ("firmware/device/prepare.cpp", "Verdict prepare_effect(const protocol::EndStops", PREPARE),
        ("sdk/conversion/scene.cpp", '    return std::string(field) + " does', IN_WORDS),
    ),
    "control law": (
        (LAWS, ")\n\nBASIS = ", '    Value("trial", "a trial"),\n'),
        (PARTITION, "};\nconstexpr const LawTraits& traits(", "    LawTraits{},  // trial\n"),
        (PARTITION, "    case Law::motor_only:", CASE),
    ),
    "field of a configuration": ((DEFINITION, '    torque(\n        "free_assist_nm"', FIELD),),
    "configuration with a rule": (
        (DEFINITION, "CONFIGURATIONS = (", REPORT),
        (DEFINITION, ")  # fmt: skip\n# Their fields", "TRIAL_CONFIG,"),
        (DEFINITION, "ACTUATOR_CONFIG, SHAFT_CONFIG)", "TRIAL_CONFIG, "),
        ("firmware/device/config.cpp", "float torque_step_nm(", CHECK),
        ("sdk/conversion/configuration.cpp", "}  // namespace torsio::conversion", REFUSAL),
    ),
}
IN_PYTHON = """import pytest, torsio
wanted = torsio.TrialConfig(trial_low_rad=0.25, trial_high_rad=0.5)
with torsio.open("emulated:trial") as knob:
    knob.update(law="trial", trial_rad=0.5)
    with pytest.raises(torsio.InvalidArgument, match="high_nm is 0.01"):
        knob.play(torsio.Trial(low_nm=0.02, high_nm=0.01))
    knob.play(torsio.Trial(low_nm=0.01, high_nm=0.012))
    knob.arm()
    told = knob.record(0.2)[-1]
    assert told["desired_torque_nm"] == pytest.approx(0.002)
    assert told["motor_command_nm"] == pytest.approx(0.001)
    knob.disarm()
    knob.configure(wanted)
    knob.save()
with torsio.open("emulated:trial") as knob:
    assert knob.trial_config() == wanted
    assert knob.control_config().trial_rad == 0.5
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


def _make(clone: Path, change: str, run: Callable[..., str]) -> str:
    for name, place, text in BY_HAND[change]:
        old = (clone / name).read_text(encoding="utf-8")
        assert old.count(place) == 1, place
        (clone / name).write_text(old.replace(place, text + place), encoding="utf-8")
    by_hand = [line.split() for line in run("git", "diff", "--numstat").splitlines()]
    run(sys.executable, "-m", "tools.definition.generate")
    changed = run("git", "diff", "--name-only").splitlines()
    run("git", "add", "-A")
    names = ", ".join(f"`{name}` {added}" for added, _, name in by_hand)
    return f"| {change} | {len(by_hand)} | {names} | {len(changed) - len(by_hand)} |"


def main() -> None:
    """Make the trial and print the rows."""
    with tempfile.TemporaryDirectory() as folder:
        clone, build = Path(folder) / "clone", Path(folder) / "build"

        def run(*command: str | Path) -> str:
            paths = {"PYTHONPATH": "bindings/python", "LD_LIBRARY_PATH": str(build / "sdk/c")}
            return subprocess.check_output(command, cwd=clone, env=os.environ | paths, text=True)

        clone.mkdir()
        run("git", "clone", "-q", "--shared", TREE, ".")
        rows = [_make(clone, change, run) for change in BY_HAND]
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
    print(*rows, sep="\n")


if __name__ == "__main__":
    main()
