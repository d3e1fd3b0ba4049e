"""The package's help for tests of programs: pytest's fixtures and their parts."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

import torsio
from tests.python.processes import python
from torsio import testing
from torsio.telemetry import TELEMETRY_DTYPE, Record


def log_of(angle_rad: list[float], spring_nm: float, motor_nm: float) -> Record:
    log = np.zeros(len(angle_rad), dtype=TELEMETRY_DTYPE)
    log["time_s"] = np.arange(len(angle_rad)) * 1e-3
    log["angle_rad"] = angle_rad
    log["spring_torque_nm"] = spring_nm
    log["motor_command_nm"] = motor_nm
    log["flags"] = 1  # armed
    return log


# --- assertions -----------------------------------------------------------------------------------


def test_felt_is_what_shaft_and_motor_do_together() -> None:
    assert testing.felt_nm(log_of([0.0], -0.02, -0.01)) == pytest.approx([-0.03])


def test_assert_felt_takes_a_number_numbers_and_a_function_of_the_angle() -> None:
    log = log_of([0.1, 0.2], -0.02, -0.01)
    testing.assert_felt(log, -0.03)
    testing.assert_felt(log, [-0.03, -0.031])
    testing.assert_felt(log, lambda angle_rad: -0.15 * angle_rad, tolerance_nm=0.0151)
    with pytest.raises(TypeError, match=r"torques in N m, is Wall\("):
        testing.assert_felt(log, torsio.Wall(stiffness_nm_per_rad=1.0))  # type: ignore[arg-type]
    with pytest.raises(torsio.InvalidArgument, match=r"write assert_felt\(log, expected\)"):
        testing.assert_felt(-0.03, log)  # type: ignore[arg-type]
    with pytest.raises(torsio.InvalidArgument, match=r"as knob.record\(1.0\) or .* is 0.3"):
        testing.assert_felt(0.3, -0.03)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected must be torques in N m, is 'x'"):
        testing.assert_felt(log, "x")


def test_assert_felt_names_the_worst_row_and_counts_the_others() -> None:
    log = log_of([0.1, 0.2, 0.3], 0.0, 0.0)
    with pytest.raises(AssertionError) as caught:
        testing.assert_felt(log, [0.0, 0.03, 0.02])
    assert str(caught.value) == (
        "felt 0.00 mN m where 30.00 mN m was expected, at 0.0010 s and 0.2000 rad; "
        "2 of 3 rows are off by more than 5.00 mN m"
    )


def test_assert_felt_looks_at_the_span_alone_and_at_the_share() -> None:
    log = log_of([0.0] * 10, 0.0, 0.0)
    log["motor_command_nm"][4] = 0.05
    testing.assert_felt(log, 0.0, to_s=0.0035)
    testing.assert_felt(log, 0.0, from_s=0.0045)
    testing.assert_felt(log, 0.0, share=0.9)
    with pytest.raises(AssertionError):
        testing.assert_felt(log, 0.0, share=0.95)
    log["motor_command_nm"][5] = np.nan
    with pytest.raises(AssertionError, match="2 of 10"):
        testing.assert_felt(log, 0.0, share=0.9)


# --- hand and faults ------------------------------------------------------------------------------


def open_knob(**options: object) -> torsio.Knob:
    return torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(log_truth=True, **options),  # type: ignore[arg-type]
    )


def test_hand_turns_to_the_devices_angle_also_after_a_new_zero() -> None:
    with open_knob() as knob:
        hand = testing.HoldingHand(knob)
        hand.turn_to(0.3)
        assert knob.position_rad() == pytest.approx(0.3, abs=2e-3)
        knob.zero()
        hand.turn_to(0.3)
        assert knob.position_rad() == pytest.approx(0.3, abs=2e-3)
        assert hand.truth()["angle_rad"][-1] == pytest.approx(0.6, abs=4e-3)


def test_hand_says_that_somebody_else_took_the_truth() -> None:
    with open_knob() as knob:
        hand = testing.HoldingHand(knob)
        hand.turn_to(0.1)
        knob.emulator.truth()
        with pytest.raises(torsio.Error, match=r"take it with HoldingHand.truth\(\)"):
            hand.turn_to(0.2)


def test_what_an_outer_block_does_goes_on_when_an_inner_one_ends() -> None:
    with open_knob() as knob:
        faults = testing.Faults(knob)
        with faults.silence():
            with faults.silence(), faults.damage(0.0):
                pass
            with pytest.raises(torsio.Timeout):
                knob.arm()
        with faults.damage(0.0), faults.damage(1.0):
            with faults.damage(0.0):
                pass
            with pytest.raises(torsio.Timeout):
                knob.arm()
        with faults.emergency_stop():
            with faults.emergency_stop():
                pass
            knob.sleep(0.1)
            with pytest.raises(torsio.Refused):
                knob.clear_fault()
        knob.sleep(0.1)
        knob.clear_fault()
        knob.arm()


def test_damage_is_the_same_for_the_same_seed() -> None:
    def lost(seed: int) -> int:
        with open_knob(seed=seed) as knob, testing.Faults(knob).damage(0.3):
            knob.start_telemetry()
            knob.sleep(1.0)
            knob.read()
            return knob.statistics().samples_lost

    assert lost(1) == lost(1) > 0
    assert lost(1) != lost(2)


def test_faults_end_quietly_when_the_knob_is_gone_by_then() -> None:
    knob = open_knob()
    faults = testing.Faults(knob)
    with faults.emergency_stop(), faults.silence():
        knob.close()


def test_virtual_time_is_the_knobs_and_ends_with_its_block() -> None:
    # By itself: any other thread that sleeps would let the knob's time pass too.
    program = """if True:
    import pickle, time
    import torsio
    from torsio import testing

    real = time.monotonic, time.perf_counter_ns, time.sleep
    with torsio.open("emulated") as knob, testing.virtual_time(knob):
        assert pickle.loads(pickle.dumps(time.sleep)) is time.sleep
        begin_s, begin_ns, knob_s = time.monotonic(), time.perf_counter_ns(), knob.emulator.time_s
        time.sleep(20.0)
        passed_s = knob.emulator.time_s - knob_s
        print(passed_s, time.monotonic() - begin_s, (time.perf_counter_ns() - begin_ns) / 1e9)
    print((time.monotonic, time.perf_counter_ns, time.sleep) == real)
    """
    result = python(program, check=True)
    passed_s, monotonic_s, counter_s, restored = result.stdout.split()
    assert float(passed_s) == pytest.approx(20.0, abs=2e-3)
    assert float(monotonic_s) == pytest.approx(float(passed_s), abs=1e-6)
    assert float(counter_s) == pytest.approx(float(passed_s), abs=1e-6)
    assert restored == "True"


# --- the plugin -----------------------------------------------------------------------------------


def test_package_does_not_import_pytest() -> None:
    program = "import sys, torsio, torsio.testing; print('pytest' in sys.modules)"
    assert python(program, check=True).stdout == "False\n"


def test_fixtures_give_a_knob_a_hand_and_faults(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import time
        import pytest, torsio
        from torsio.testing import assert_felt

        @pytest.mark.torsio(control_rate_hz=10_000, seed=5)
        def test_wall(torsio_knob, torsio_hand):
            assert torsio_knob.info.control_rate_hz == 10_000
            torsio_knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.0))
            torsio_knob.arm()
            log = torsio_hand.turn_to(0.13)
            assert_felt(log, lambda angle: -1.0 * (angle - 0.1).clip(min=0.0), from_s=0.3)

        def test_faults(torsio_knob, torsio_faults):
            torsio_knob.arm()
            with torsio_faults.emergency_stop():
                assert torsio_knob.wait_for("fault")
            torsio_faults.unplug()
            with pytest.raises(torsio.Disconnected):
                torsio_knob.health()

        def test_program_that_opens_and_sleeps(torsio_open, torsio_time):
            with torsio.open("TS-0001") as knob:
                before = knob.emulator.time_s
                time.sleep(60.0)
                assert knob.emulator.time_s - before > 59.0

        def test_time_goes_on_without_a_knob(torsio_open, torsio_time, torsio_faults):
            begin_s = time.monotonic()
            knob = torsio.open()
            knob.sleep(1.0)
            torsio_faults.unplug()
            with pytest.raises(torsio.Disconnected):
                knob.sleep(1.0)
            time.sleep(2.0)
            knob.close()
            time.sleep(3.0)
            assert time.monotonic() - begin_s == pytest.approx(6.0, abs=0.01)
            with torsio.open() as again:
                assert again is not knob
                assert torsio.open() is again
                time.sleep(4.0)
                assert again.emulator.time_s >= 4.0
            assert time.monotonic() - begin_s == pytest.approx(10.0, abs=0.1)
            again = torsio.open()
            torsio_faults.unplug()
            with pytest.raises(torsio.Disconnected):
                again.sleep(1.0)
            with pytest.raises(ValueError):
                time.sleep(-1.0)

        @pytest.mark.torsio(seed=6)
        def test_seed_is_the_marks(torsio_knob, torsio_seed):
            assert torsio_seed == 6

        def test_seed_follows_from_the_name(torsio_seed):
            import zlib
            assert torsio_seed == zlib.crc32(
                b"test_fixtures_give_a_knob_a_hand_and_faults.py::test_seed_follows_from_the_name")
        """
    )
    pytester.runpytest("-W", "error", "--strict-markers").assert_outcomes(passed=6)


def test_fixture_of_the_users_own_is_what_the_others_work_on(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import time
        import pytest, torsio

        @pytest.fixture
        def torsio_knob():
            with torsio.open("emulated") as knob:
                yield knob

        def test_it(torsio_knob, torsio_open, torsio_time, torsio_faults):
            assert torsio.open() is torsio_knob
            before_s = torsio_knob.emulator.time_s
            time.sleep(1.0)
            assert torsio_knob.emulator.time_s - before_s == pytest.approx(1.0)
            torsio_faults.unplug()
            assert torsio_knob.state == "disconnected"
        """
    )
    pytester.runpytest().assert_outcomes(passed=1)


def test_time_is_the_same_for_all_threads(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import sys, threading, time
        import torsio

        def test_it(torsio_open, torsio_time, monkeypatch):
            told, ended = [], threading.Event()

            def look():
                last_s = time.monotonic()
                while not ended.is_set():
                    now_s = time.monotonic()
                    told.append(now_s - last_s)
                    last_s = now_s

            before = sys.getswitchinterval()
            sys.setswitchinterval(1e-6)
            threads = [threading.Thread(target=look) for _ in range(3)]
            begin_s = time.monotonic()
            for thread in threads:
                thread.start()
            for _ in range(30):
                with torsio.open():
                    time.sleep(1.0)
            ended.set()
            for thread in threads:
                thread.join()
            sys.setswitchinterval(before)
            assert abs(time.monotonic() - begin_s - 30.0) < 0.1
            assert min(told) >= 0.0
        """
    )
    pytester.runpytest().assert_outcomes(passed=1)


def test_run_that_asks_for_no_knob_loads_neither_library_nor_numpy(
    pytester: pytest.Pytester,
) -> None:
    pytester.makepyfile(
        "import sys\n\ndef test_it():\n    assert not {'numpy', 'torsio'} & set(sys.modules)\n"
    )
    pytester.runpytest_subprocess().assert_outcomes(passed=1)


def test_failure_tells_the_seed_and_keeps_a_recording(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        def test_it(torsio_knob, torsio_hand):
            torsio_hand.turn_to(0.2, duration_s=0.3)
            for _ in torsio_knob.telemetry(0.1): pass
            assert False

        def test_good(torsio_knob):
            with torsio_knob.record_to("a.mcap"):
                assert len(torsio_knob.record(0.05)) == 50
        """
    )
    result = pytester.runpytest("--torsio-seed=77", "--torsio-recordings=kept")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "*- torsio -*",
            "seed 77; again with: pytest --torsio-seed=77 '*::test_it'",
            "recording kept/*test_it-????????.npz",
        ]
    )
    (path,) = (pytester.path / "kept").iterdir()
    with np.load(path) as kept:
        assert int(kept["seed"]) == 77
        assert len(kept["telemetry"]) == 400
        assert kept["truth"]["angle_rad"].max() == pytest.approx(0.2, abs=1e-3)


def test_assert_felt_that_fails_names_arm_and_shows_no_source_of_the_library(
    pytester: pytest.Pytester,
) -> None:
    pytester.makepyfile(
        "from torsio.testing import assert_felt\n"
        "def test_it(torsio_knob): assert_felt(torsio_knob.record(0.01), 0.1)"
    )
    shown = pytester.runpytest().stdout.str()
    assert "the knob was disarmed throughout: arm() turns the torque on" in shown
    assert "def assert_felt" not in shown


def test_assert_felt_names_a_fault_that_kept_the_torque_off() -> None:
    log = log_of([0.1, 0.2], 0.0, 0.0)
    log["flags"] = 2  # in fault
    with pytest.raises(AssertionError, match=r"kept the torque off: knob.faults\(\) names it"):
        testing.assert_felt(log, -0.03)


def test_recording_of_a_closed_knob_goes_into_the_cache(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        "def test_it(torsio_knob):\n torsio_knob.sleep(0.1)\n torsio_knob.close()\n assert False"
    )
    result = pytester.runpytest()
    result.assert_outcomes(failed=1)
    (path,) = (pytester.path / ".pytest_cache/d/torsio").iterdir()
    with np.load(path) as kept:
        assert len(kept["truth"]) > 0
    pytester.runpytest("-p", "no:cacheprovider")
    assert len(list((pytester.path / "torsio-recordings").iterdir())) == 1


def test_every_knob_of_every_test_has_a_recording_of_its_own(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import pytest, torsio

        @pytest.mark.parametrize("name", ["a/b", "a.b", "a_b"])
        def test_it(torsio_open, name):
            torsio.open().close()
            torsio.open()
            assert False
        """
    )
    pytester.runpytest("--torsio-recordings=kept").assert_outcomes(failed=3)
    assert len(list((pytester.path / "kept").iterdir())) == 6


@pytest.mark.parametrize("seed", ["x", "-1", "1.5", str(2**64)])
def test_bad_seed_is_refused_before_any_test_runs(pytester: pytest.Pytester, seed: str) -> None:
    result = pytester.runpytest(f"--torsio-seed={seed}")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(
        [f"*--torsio-seed is '{seed}', allowed are 0 to 18446744073709551615*"]
    )


def test_mark_with_an_unknown_option_says_which_there_are(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("import pytest\n@pytest.mark.torsio(sed=1)\ndef test_it(torsio_knob): pass")
    result = pytester.runpytest()
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*pytest.mark.torsio takes fields of torsio.EmulatorOptions*"])


def test_random_seed_is_told_and_can_be_given_again(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_it(torsio_knob, torsio_seed):\n assert torsio_seed == -1")
    text = pytester.runpytest("--torsio-seed=random").stdout.str()
    seed = text.partition("again with: pytest --torsio-seed=")[2].partition(" ")[0]
    assert seed.isdecimal()
    pytester.runpytest(f"--torsio-seed={seed}").stdout.fnmatch_lines([f"*assert {seed} == -1*"])


def test_examples_of_the_page_pass(pytester: pytest.Pytester) -> None:
    from tests.pages import examples

    pages = ("docs/how-to/testing.md", "docs/reference/testing.md")
    for index, example in enumerate(one for page in pages for one in examples(page, "python")):
        (pytester.path / f"test_page_{index}.py").write_text(example.code)
    pytester.runpytest("-W", "error").assert_outcomes(passed=4)


WAIT = """if True:
    import asyncio, concurrent.futures, multiprocessing.connection, queue, subprocess, sys
    import torsio
    from torsio import testing

    pool = concurrent.futures.ThreadPoolExecutor(1)
    condition = multiprocessing.Condition()
    condition.acquire()
    with torsio.open("emulated") as knob, testing.virtual_time(knob):
        {}
        assert knob.emulator.time_s < 1.0
    print("done")
"""


@pytest.mark.parametrize(
    "wait",
    [
        "asyncio.run(asyncio.sleep(0.01))",
        "list(concurrent.futures.as_completed([pool.submit(int)], timeout=5.0))",
        "multiprocessing.Pipe()[0].poll(0.01)",
        "multiprocessing.connection.wait([multiprocessing.Pipe()[0]], 0.01)",
        "condition.wait_for(int, timeout=0.01)",
        "try: multiprocessing.Queue().get(timeout=0.01)\n        except queue.Empty: pass",
        "try: queue.Queue().get(timeout=0.01)\n        except queue.Empty: pass",
        "subprocess.run([sys.executable, '-c', ''], timeout=60.0)",
    ],
)
def test_wait_of_the_standard_library_ends_by_the_walls_clock(wait: str) -> None:
    # In a process of its own, with a limit for any loaded machine.
    result = python(WAIT.format(wait))
    assert result.stdout == "done\n", result.stderr


def test_every_module_of_the_standard_library_with_a_deadline_is_known() -> None:
    library = Path(os.__file__).parent
    none_waits_in_c = {"pydoc", "sched", "test", "trace", "tkinter", "idlelib", "lib2to3"}
    found = {
        file.relative_to(library).parts[0].removesuffix(".py")
        for file in library.rglob("*.py")
        if "-packages" not in str(file)
        and re.search(r"time\.monotonic\(|import monotonic", file.read_text(errors="replace"))
    }
    assert found - none_waits_in_c <= testing.WAITING


def test_group_of_xdist_changes_neither_seed_nor_command(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("""
        import pytest
        @pytest.mark.xdist_group("a")
        def test_it(torsio_knob): assert False
    """)
    told = []
    for options in ([], ["-n1", "--dist=loadgroup"]):
        output = pytester.runpytest_subprocess(*options).stdout.str()
        told += re.findall(r"seed \d+; again with: pytest .*", output)
    assert len(told) == 2
    assert told[0] == told[1]
    assert told[0].endswith("::test_it'")
