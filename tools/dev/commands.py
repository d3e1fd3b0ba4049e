"""The commands, one function each; ``cli.py`` reads their arguments, ``help.txt`` tells of them."""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from tools import usb_ids
from tools.dev import building, environment, fresh, groups, plans
from tools.dev.environment import PYTHON, VENV
from tools.dev.running import (
    BUILD,
    TREE,
    Failed,
    Word,
    become,
    become_root,
    lock,
    run,
    say,
    succeeds,
    without_aslr,
)
from tools.dev.testing import build_tests

# Everything that is made in the tree.
MADE = (
    *("build", "out", "dist", ".venv"),
    *("studio/node_modules", "tests/board/node_modules"),
    *(".hypothesis", ".mypy_cache", ".pytest_cache", ".ruff_cache"),
)
# Tests wait about as long as they compute: for machines, browsers, knobs that keep to the clock.
WORKERS = 2 * (os.cpu_count() or 1)
_PAGE = BUILD / "studio/page"
# Groups of packages that wheels are made and tried with.
_OF_WHEELS = ("windows", "wheels", "machines", "fresh")
_VENDOR, _PRODUCT = usb_ids.ids()
# udev looks at these again: a knob's own nodes, and its nodes for games.
_UDEV_MATCHES = (
    ("--subsystem-match=hidraw",),
    (
        "--subsystem-match=usb",
        f"--attr-match=idVendor={_VENDOR}",
        f"--attr-match=idProduct={_PRODUCT}",
    ),
    (
        "--subsystem-match=input",
        f"--property-match=ID_VENDOR_ID={_VENDOR}",
        f"--property-match=ID_MODEL_ID={_PRODUCT}",
    ),
)


def setup() -> int:
    """Install what is missing."""
    with lock():
        sources = building.FirmwareSources()
        environment.set_up("tests", "game")
        sources.offer()
    return 0


def build(presets: Sequence[str]) -> int:
    """Set up and build presets, ``python`` for the Python packages among them."""
    with lock():
        sources = building.FirmwareSources()
        environment.set_up("tests", "game")
        tinyusb = sources.offer()
        for preset in presets:
            if preset == "python":
                building.build_packages(tinyusb)
            else:
                building.build_preset(preset, tinyusb)
    return 0


def test(arguments: Sequence[str]) -> int:
    """Build what the chosen groups of tests need, and hand over to pytest; see ``plans.py``."""
    plan = plans.plan(arguments)
    if plan.left_out:
        say(f"left out, unchanged since they passed: {', '.join(plan.left_out)}")
    if plan.groups:
        _run_tests(plan)
    say("nothing has changed; `./dev test all` runs everything again")
    return 0


def _run_tests(plan: plans.Plan) -> NoReturn:
    say(f"groups of tests: {', '.join(plan.groups)}")
    with lock():
        build_tests(plan)
    say("running the tests")
    os.environ.update(plan.variables)
    os.environ[groups.BOARDS_VARIABLE] = " ".join(plan.boards)
    os.environ[groups.TURN_VARIABLE] = str(plan.turn)
    # The tools that the build has installed count.
    digests = {**dict.fromkeys(plan.groups, ""), **plans.with_tools(plan.run)}
    os.environ[groups.RUN_VARIABLE] = json.dumps(digests)
    become(
        *without_aslr(
            PYTHON, "-m", "pytest", "-n", str(WORKERS), "--dist", "worksteal", *plan.arguments
        )
    )


def hardware(arguments: Sequence[str]) -> int:
    """Make the files of the knob to build, in ``out/hardware/``; see ``docs/how-to/build.md``."""
    with lock():
        environment.set_up("tests", "making")
        for package in (building.TORSIO, building.STUDIES):
            building.build_python(package, building.FirmwareSources(fetch=False).tinyusb)
        python = environment.make_hardware()
    become(python, "-m", "torsio_hardware", *(arguments or ("all",)))


def _handed_on(module: str, *groups: str) -> Callable[[Sequence[str]], int]:
    """Make a command that sets up what a program needs, and becomes that program."""

    def start(arguments: Sequence[str]) -> int:
        with lock():
            environment.set_up("tests", *groups)
        become(PYTHON, "-m", module, *arguments)

    return start


# Each module's docstring says what it does. A check reads the game's headers too.
check = _handed_on("tools.check", "game")
determinism = _handed_on("tests.determinism.determinism", "compilers")
windows = _handed_on("tools.windows", "windows", "wheels")
macos = _handed_on("tools.macos", "wheels")
generate = _handed_on("tools.definition.generate")


def demo(arguments: Sequence[str]) -> int:
    """Build what the demo needs, and nothing else, and run it.

    A user at a terminal gets the page at the end. There the mouse turns the same knob.
    """
    is_person = sys.stdin.isatty() and sys.stdout.isatty()
    is_watched = is_person and not {"--json", "--help"} & set(arguments)
    with lock():
        groups, python = (("studio",), environment.PAGE) if is_watched else ((), environment.DEMO)
        coming = environment.begin(*groups, python=python)
        # The virtual USB knob comes along where TinyUSB is there already.
        tinyusb = building.FirmwareSources(fetch=False).tinyusb
        building.build_preset("release", tinyusb, "--target", *building.LIBRARIES)
        coming.finish()
        # Without the emulated device for browsers, which takes a minute to compile.
        page = building.begin_studio("--page") if is_watched else None
        building.build_python(building.TORSIO, tinyusb)
        if page is not None:
            page.result()
    status = run(VENV / "bin/torsio", "demo", "wall", "--device", "emulated", *arguments)
    if status == 0 and page is not None:
        say("open this page to turn the knob with the mouse; Ctrl-C ends it")
        become(VENV / "bin/torsio", "studio", "--device", "emulated", "--page", _PAGE)
    if status == 0 and "--json" not in arguments:
        say("to turn this knob with the mouse, in a browser: ./dev studio")
    return status


def game(arguments: Sequence[str]) -> int:
    """Build the example game and play it."""
    with lock():
        environment.set_up("tests", "game")
        building.build_preset("dev", "", "--target", "torsio_safe")
    become(BUILD / "dev/examples/game/safe", *arguments)


def studio(arguments: Sequence[str]) -> int:
    """Build the page and open a knob to it."""
    with lock():
        environment.set_up("tests", "studio")
        page = building.begin_studio()
        building.build_python(building.TORSIO, building.FirmwareSources(fetch=False).tinyusb)
        page.result()
    become(VENV / "bin/torsio", "studio", "--page", _PAGE, *arguments)


def site() -> int:
    """Make the documents a site."""
    with lock():
        environment.set_up("tests", "studio", "documents")
        page = building.begin_studio()
        building.build_python(building.TORSIO, building.FirmwareSources(fetch=False).tinyusb)
        page.result()
    become(PYTHON, "-m", "tools.site")


def mutate(arguments: Sequence[str]) -> int:
    """Run mutants; see ``tests/mutation/mutate.py``."""
    with lock():
        sources = building.FirmwareSources()
        environment.set_up("tests", "mutants")
        tinyusb = sources.require() and sources.tinyusb
        if any(word.startswith("--random") for word in arguments):
            page = building.begin_studio()
            building.build_packages(tinyusb)
            page.result()
    become(PYTHON, "-m", "tests.mutation.mutate", "--tinyusb", tinyusb, *arguments)


def fuzz(arguments: Sequence[str]) -> int:
    """Run fuzz targets; see ``tests/fuzz/fuzz.py``."""
    with lock():
        sources = building.FirmwareSources()
        environment.set_up("tests")
        sources.require()
        names = [path.stem for path in sorted((TREE / "tests/fuzz").glob("fuzz_*.cpp"))]
        building.build_preset("fuzz", sources.tinyusb, "--target", *names)
    become(*without_aslr(PYTHON, "-m", "tests.fuzz.fuzz", *arguments))


def soak(arguments: Sequence[str]) -> int:
    """Let knobs live for hours of virtual time; see ``tests/determinism/soak.cpp``."""
    hours, *rest = arguments or ["1000"]
    with lock():
        sources = building.FirmwareSources(fetch=False)
        environment.set_up("tests")
        building.build_preset("release", sources.tinyusb, "--target", "torsio_soak")
    threads = str(os.cpu_count() or 1)
    become(
        BUILD / "release/tests/determinism/torsio_soak",
        "--hours",
        hours,
        "--threads",
        threads,
        *rest,
    )


def unplugs(arguments: Sequence[str]) -> int:
    """Pull the plug of knobs in use; see ``tests/endurance/unplugs.py``."""
    on_kernel = any(argument.startswith("--kernel") for argument in arguments)
    with lock():
        environment.set_up("tests")
        kernels = building.begin_fetching_kernels() if on_kernel else None
        sources = building.FirmwareSources(fetch=on_kernel)
        building.build_python(building.TORSIO, sources.tinyusb)
        if kernels is not None:
            building.build_preset("release", sources.tinyusb, "--target", "torsio_virtual_knob")
            kernels.result()
    become(PYTHON, "-m", "tests.endurance.unplugs", *arguments)


def faults(arguments: Sequence[str]) -> int:
    """Let each thing fail once; see ``tests/faults/faults.py``."""
    with lock():
        environment.set_up("tests")
        sources = building.FirmwareSources()
        building.build_preset("release", sources.tinyusb, "--target", "torsio_c")
        building.build_packages(sources.tinyusb)
    become(PYTHON, "-m", "tests.faults.faults", *arguments)


def firmware() -> int:
    """Build the boards' firmware and tell what it takes."""
    with lock():
        sources = building.FirmwareSources()
        environment.set_up("firmware")
        building.build_firmware(sources.require())
        images = [f"build/firmware/torsio-{board}" for board in reversed(building.BOARDS)]
        report: list[Word] = [PYTHON, "-m", "tools.firmware_report"]
        status = run(*report, *(f"{image}.elf" for image in images))
        if status != 0:
            return status
        files = [f"{image}.{suffix}" for suffix in ("uf2", "elf", "map") for image in images]
        return run("ls", "-l", *sorted(files))


def wheels(arguments: Sequence[str]) -> int:
    """Build the wheels; see ``tools/wheels.py``."""
    with lock():
        sources = building.FirmwareSources()
        kernels = building.begin_fetching_kernels()
        environment.set_up(*_OF_WHEELS)
        tinyusb = sources.require() and sources.tinyusb
        kernels.result()
    become(PYTHON, "-m", "tools.wheels", "--tinyusb", tinyusb, *arguments)


def release(arguments: Sequence[str]) -> int:
    """Make all files of a release, with ``--twice`` in another clone too, and compare them."""
    rest = [word for word in arguments if word != "--twice"]
    status = _make_release(rest)
    if len(rest) == len(arguments):
        return status
    # Elsewhere, and without what compilers keep: nothing of either may be in the files.
    again = BUILD / "release-again"
    fresh.clone(again)
    say("release: making it again in another clone, build/release-again")
    with tempfile.TemporaryDirectory() as kept:
        alone = ("env", "CCACHE_DISABLE=1", f"ZIG_GLOBAL_CACHE_DIR={kept}")
        run(*alone, again / "dev", "release", "--no-try", *rest)
    compared = run(PYTHON, "-m", "tools.release", "--compare", again / "out/release")
    return status or compared


def _make_release(arguments: Sequence[str]) -> int:
    """Build firmware, site and the wheels that are missing; see ``tools/release.py``."""
    with lock():
        sources = building.FirmwareSources()
        kernels = building.begin_fetching_kernels()
        environment.set_up("tests", "firmware", "studio", "documents", *_OF_WHEELS)
        page = building.begin_studio()
        building.build_firmware(sources.require())
        building.build_python(building.TORSIO, sources.tinyusb)
        page.result()
        kernels.result()
    if status := run(PYTHON, "-m", "tools.site"):
        return status
    folders = ("--sdk", sources.sdk, "--tinyusb", sources.tinyusb)
    return run(PYTHON, "-m", "tools.release", *folders, *arguments)


def ros(arguments: Sequence[str]) -> int:
    """Test the example for ROS 2 with ROS's own library."""
    with lock():
        environment.set_up("tests")
        building.build_python(building.TORSIO, building.FirmwareSources(fetch=False).tinyusb)
        environment.make_ros()
    become(PYTHON, "-m", "pytest", "tests/ros/check_joint_state.py", *arguments)


def udev(*, remove: bool) -> int:
    """Install or remove the udev rule, and let udev apply the change.

    Below ``DESTDIR`` only the file is written: for packages, and for a look at it.
    """
    destination = os.environ.get("DESTDIR", "")
    rule = Path(f"{destination}/etc/udev/rules.d/60-torsio.rules")
    change: list[Word] = ["install", "-D", "-m", "644", "sdk/60-torsio.rules", rule]
    if remove:
        change = ["rm", "-f", rule]
    line = " ".join(str(word) for word in change)
    as_root: list[str] = []
    if not destination:
        if shutil.which("udevadm") is None:
            raise Failed(
                "this system has no udev, so no rule can help; as root you may open the knob anyway"
            )
        as_root = become_root("udev's rules belong to root", line)
    if run(*as_root, *change) != 0:
        raise Failed(f"'{line}' failed")
    say(f"{'removed' if remove else 'installed'} {rule}")
    if destination:
        return 0
    if run(*as_root, "udevadm", "control", "--reload") != 0:
        raise Failed(
            "udev does not run here, as in most containers; the change counts when it starts"
        )
    # For knobs that are plugged in already. The rest of hidraw is not changed by being looked at.
    for match in _UDEV_MATCHES:
        if status := run(*as_root, "udevadm", "trigger", "--action=change", *match):
            return status
    succeeds(*as_root, "udevadm", "settle", "--timeout=5")
    say(
        "udev has read its rules again and gone over what is plugged in; "
        "`torsio doctor` checks the knob"
    )
    return 0


def clean() -> int:
    """Remove everything that was made in the tree."""
    systems = BUILD / "fresh"
    if systems.exists():
        as_root = become_root("the systems in build/fresh belong to root", f"rm -rf {systems}")
        if run(*as_root, "rm", "-rf", "--one-file-system", systems) != 0:
            raise Failed("build/fresh cannot be removed")
    for name in MADE:
        shutil.rmtree(TREE / name, ignore_errors=True)
    for folder in list(TREE.rglob("__pycache__")):
        shutil.rmtree(folder, ignore_errors=True)
    say("clean")
    return 0
