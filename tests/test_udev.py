"""The udev rule and the command that installs it, as far as a test without a knob can go."""

from __future__ import annotations

import os
import re
import shutil
import stat
import subprocess
from pathlib import Path

import pytest

from tests.python import wire
from tools import usb_ids

TREE = Path(__file__).parent.parent
RULE = TREE / "sdk" / "60-torsio.rules"
INSTALLED = Path("etc/udev/rules.d/60-torsio.rules")


def _dev(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [TREE / "dev", *arguments],
        capture_output=True,
        text=True,
        check=False,
        cwd="/",
        env={**os.environ, **environment},
    )


def _statements() -> list[str]:
    lines = RULE.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def test_rule_is_read_before_the_rules_that_act_on_its_tag() -> None:
    # systemd's 73-seat-late.rules hand the device to the user who is logged in.
    assert int(RULE.name.split("-")[0]) < 73


def test_rule_gives_hidraw_and_usb_node_of_our_device_to_the_seat_and_to_nobody_else() -> None:
    # Taken apart by the grammar of udev(7): KEY{attribute} operator "value", separated by commas.
    pair = re.compile(r'\s*([A-Z]+(?:\{\w+\})?)\s*(==|\+=|=)\s*"([^"]*)"\s*')
    parsed = []
    for statement in _statements():
        matches = [pair.fullmatch(part) for part in statement.split(",")]
        assert all(matches)
        parsed.append({match[1] + match[2]: match[3] for match in matches if match})
    vendor, product = wire.USB_ID.split(":")
    assert parsed == [
        {
            "SUBSYSTEM==": "hidraw",
            "ATTRS{idVendor}==": vendor,
            "ATTRS{idProduct}==": product,
            "TAG+=": "uaccess",
        },
        {
            "SUBSYSTEM==": "input",
            "KERNEL==": "event*",
            "ATTRS{idVendor}==": vendor,
            "ATTRS{idProduct}==": product,
            "ENV{EVDEV_ABS_00}=": ":::0:0",
            "RUN{builtin}+=": "keyboard",
        },
        {
            "SUBSYSTEM==": "usb",
            "ENV{DEVTYPE}==": "usb_device",
            "ATTR{idVendor}==": vendor,
            "ATTR{idProduct}==": product,
            "TAG+=": "uaccess",
        },
    ]


def test_ids_of_the_header_stand_in_the_rule_and_the_documents() -> None:
    assert ":".join(usb_ids.ids()) == wire.USB_ID
    hardware = TREE / "docs" / "how-to" / "hardware.md"
    assert wire.USB_ID in hardware.read_text(encoding="utf-8")
    assert {RULE, hardware} <= set(usb_ids.places())
    for place in usb_ids.places():
        text = place.read_text(encoding="utf-8")
        if usb_ids.with_ids(text) != text:
            pytest.fail(f"{place} has other ids; run ./dev generate", pytrace=False)


def test_other_ids_are_put_into_rule_and_document(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(usb_ids, "ids", lambda: ("16c0", "27d9"))
    rule = 'ATTRS{idVendor}=="1209", ATTRS{idProduct}=="0001", TAG+="uaccess"'
    assert (
        usb_ids.with_ids(rule)
        == 'ATTRS{idVendor}=="16c0", ATTRS{idProduct}=="27d9", TAG+="uaccess"'
    )
    assert usb_ids.with_ids("calls itself 1209:0001,") == "calls itself 16c0:27d9,"


def test_dev_udev_installs_the_rule_below_destdir_and_removes_it(tmp_path: Path) -> None:
    rule = tmp_path / INSTALLED
    result = _dev("udev", DESTDIR=str(tmp_path))
    assert result.returncode == 0, result.stderr
    assert result.stdout == f"torsio: installed {rule}\n"
    assert rule.read_bytes() == RULE.read_bytes()
    assert stat.S_IMODE(rule.stat().st_mode) == 0o644
    assert _dev("udev", DESTDIR=str(tmp_path)).returncode == 0  # again
    for _ in range(2):
        result = _dev("udev", "--remove", DESTDIR=str(tmp_path))
        assert (result.returncode, result.stdout) == (0, f"torsio: removed {rule}\n")
        assert not rule.exists()


def _commands_without(folder: Path, *names: str) -> str:
    """Make a PATH that has what the script needs and nothing of udev or sudo."""
    folder.mkdir()
    for name in (
        "bash",
        "env",
        "readlink",
        "dirname",
        "cut",
        "tail",
        "install",
        "rm",
        "cat",
        *names,
    ):
        (folder / name).symlink_to(shutil.which(name) or pytest.fail(f"no {name}"))
    return str(folder)


def test_dev_udev_says_when_a_system_has_no_udev(tmp_path: Path) -> None:
    result = _dev("udev", PATH=_commands_without(tmp_path / "bin"), DESTDIR="")
    assert result.returncode == 1
    assert result.stdout == ""
    assert result.stderr.startswith("torsio: error: this system has no udev")
    assert len(result.stderr.splitlines()) == 1


def test_installed_sdk_has_the_rule_where_udev_looks(tmp_path: Path) -> None:
    subprocess.run(
        ["cmake", "--install", TREE / "build" / "release", "--prefix", tmp_path],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    # udev(7): /usr/lib/udev/rules.d and /usr/local/lib/udev/rules.d, so lib below the prefix.
    assert (tmp_path / "lib/udev/rules.d" / RULE.name).read_bytes() == RULE.read_bytes()
