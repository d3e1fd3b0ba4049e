"""What a release is put together with: checksums, the list of parts, hidapi's sources."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from tools import hidapi_source, release, wheels

TREE = Path(__file__).parent.parent


def test_checksums_are_as_sha256sum_reads_them(tmp_path: Path) -> None:
    (tmp_path / "a.whl").write_bytes(b"a")
    (tmp_path / "b c.uf2").write_bytes(b"b")
    (tmp_path / "SHA256SUMS").write_text(release.checksums(tmp_path))
    check = ["sha256sum", "--strict", "--check", "SHA256SUMS"]
    told = subprocess.run(check, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert told == "a.whl: OK\nb c.uf2: OK\n"


def test_list_of_parts_names_version_and_licence_of_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sdk = tmp_path / "sdk"
    (sdk / "lib/tinyusb/src").mkdir(parents=True)
    numbers = "".join(
        f"#define TUSB_VERSION_{name}   {n}\n"
        for n, name in enumerate(("MAJOR", "MINOR", "REVISION"))
    )
    (sdk / "lib/tinyusb/src/tusb_option.h").write_text(numbers)
    lines = [f"set(PICO_SDK_VERSION_{name} 2)" for name in ("MAJOR", "MINOR", "REVISION")]
    (sdk / "pico_sdk_version.cmake").write_text("\n".join(lines))
    monkeypatch.setattr(hidapi_source, "locate", lambda _: Path("hidapi-hidapi-0.13.1"))
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    bill = json.loads(json.dumps(release.bill_of_materials(sdk)))
    assert bill["metadata"]["timestamp"] == "1970-01-02T00:00:00Z"
    versions = {part["name"]: part["version"] for part in bill["components"]}
    assert versions["hidapi"] == "0.13.1"
    assert versions["TinyUSB"] == "0.1.2"
    assert versions["pico-sdk"] == "2.2.2"
    assert all(part["licenses"][0]["expression"] for part in bill["components"])

    (sdk / "lib/tinyusb/src/tusb_option.h").write_text("")
    with pytest.raises(RuntimeError, match="version of TinyUSB"):
        release.bill_of_materials(sdk)


def test_hidapi_that_is_there_is_not_fetched_again(tmp_path: Path) -> None:
    header = tmp_path / "hidapi-hidapi-9.8.7/hidapi/hidapi.h"
    header.parent.mkdir(parents=True)
    header.touch()
    assert hidapi_source.locate(tmp_path) == header.parent.parent


def test_wheels_are_built_with_what_the_tests_have() -> None:
    pins = wheels.BUILT_WITH.findall((TREE / "pyproject.toml").read_text(encoding="utf-8"))
    assert sorted(pin.partition("==")[0] for pin in pins) == ["pybind11", "scikit-build-core"]
