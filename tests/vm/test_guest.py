"""Every test in ``guest/`` on every kernel, as one pytest test each."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.once import once
from tests.vm import guests, kernel_log, results


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    kernels = guests.kernels()
    if not kernels:
        pytest.fail("there are no kernels in build/kernels; run ./dev test usb", pytrace=False)
    if "node_id" in metafunc.fixturenames:
        cases = [(kernel, test) for kernel in kernels for test in guests.guest_tests(kernel)]
        ids = [
            f"{kernel}: {test.removeprefix('tests/').removeprefix('vm/guest/')}"
            for kernel, test in cases
        ]
        metafunc.parametrize(("kernel", "node_id"), cases, ids=ids)
    elif "kernel" in metafunc.fixturenames:
        metafunc.parametrize("kernel", kernels)


@pytest.fixture(scope="session")
def failures(request: pytest.FixtureRequest) -> dict[str, str]:
    """Run the selected tests once for all workers; give each kernel's own failure, if any."""
    wanted: dict[str, list[str]] = {}
    for item in request.session.items:
        parameters = getattr(getattr(item, "callspec", None), "params", {})
        if item.path == Path(__file__) and "kernel" in parameters:
            tests = wanted.setdefault(parameters["kernel"], [])
            if "node_id" in parameters:
                tests.append(parameters["node_id"])
    for kernel, tests in wanted.items():
        if not tests:  # only the log was asked for
            tests.extend(guests.guest_tests(kernel))
    failures: dict[str, str] = once(
        guests.share("session") / "failures.json", lambda: guests.run_guests(wanted)
    )
    return failures


def test_guest(failures: dict[str, str], kernel: str, node_id: str) -> None:
    if failures[kernel]:
        pytest.fail(failures[kernel], pytrace=False)
    found = results.read_junit(guests.junit(kernel)).get(results.test_key(node_id))
    if found is None:
        pytest.fail("the guest's results do not have this test", pytrace=False)
    if found.problem:
        pytest.fail(found.problem, pytrace=False)


def test_kernel_log_has_no_complaint(failures: dict[str, str], kernel: str) -> None:
    if failures[kernel]:
        pytest.fail(failures[kernel], pytrace=False)
    log = (guests.share(kernel) / "dmesg").read_text(errors="replace")
    assert "vhci_hcd" in log
    # Each test has looked already, those without a mark more strictly.
    assert kernel_log.complaints(log, kernel_log.HARMLESS_WITH_MARK) == []
