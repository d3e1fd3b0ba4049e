"""The udev rule and the command that installs it, as far as a test without a knob can go."""

from __future__ import annotations

import os
import re
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


def test_installed_sdk_has_the_rule_where_udev_looks(tmp_path: Path) -> None:
    subprocess.run(
        ["cmake", "--install", TREE / "build" / "release", "--prefix", tmp_path],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    # udev(7): /usr/lib/udev/rules.d and /usr/local/lib/udev/rules.d, so lib below the prefix.
    assert (tmp_path / "lib/udev/rules.d" / RULE.name).read_bytes() == RULE.read_bytes()
