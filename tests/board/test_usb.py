"""The firmware as a USB device: what a host sees, and what it cannot break."""

from __future__ import annotations

import itertools
import struct

import pytest

import torsio
from tests.board.pico import FEATURE, FLASH_BASE, SERIAL, EmulatedPico, UsbStall, enumerated
from tests.python import wire
from tools import uf2

ACTUATOR = wire.REPORTS["actuator_config"].id
CONTROL = wire.REPORTS["control_config"].id


def _text(descriptor: bytes) -> str:
    assert descriptor[0] == len(descriptor)
    assert descriptor[1] == 3
    return descriptor[2:].decode("utf-16-le")


def test_firmware_enumerates_as_the_knob() -> None:
    with EmulatedPico() as pico:
        pico.boot()
        found = pico.enumerate()
    vendor, product = struct.unpack_from("<HH", found["device"], 8)
    assert (vendor, product) == (wire.USB_VENDOR_ID, wire.USB_PRODUCT_ID)
    assert _text(found["manufacturer"]) == "Torsio"
    assert _text(found["product"]) == "haptic knob"
    assert _text(found["serial"]) == SERIAL.hex().upper()
    assert _text(found["control"]) == "Torsio control"
    assert _text(found["game"]) == "Torsio game controller"
    # Two HID interfaces without a boot protocol, each on two interrupt endpoints of 64 bytes, 1 ms.
    configuration = found["configuration"]
    assert configuration[4] == 2
    for number, at in ((0, 9), (1, 41)):
        name, endpoint = number + 4, number + 1
        assert configuration[at : at + 9] == bytes([9, 4, number, 0, 2, 3, 0, 0, name])
        both = [7, 5, 0x80 | endpoint, 3, 64, 0, 1, 7, 5, endpoint, 3, 64, 0, 1]
        assert configuration[at + 18 : at + 32] == bytes(both)
    assert len(configuration) == 73
    assert found["report"].startswith(bytes([0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01]))
    assert found["report"].endswith(b"\xc0")


def test_file_says_what_the_board_says_once_it_runs(lasting_pico: EmulatedPico) -> None:
    model, identity = lasting_pico.model, lasting_pico.get("identity")
    found = torsio.read_firmware(model.image)
    assert (found.board, found.chip) == (model.name, model.chip)
    assert found.fingerprint == identity["fingerprint"]
    assert found.version == ".".join(map(str, identity["firmware_version"]))
    pages = uf2.check(model.image.read_bytes(), model.chip)
    assert found.size == 256 * len(pages)
    # It leaves the configuration alone.
    assert max(pages) + 256 <= FLASH_BASE + model.slots_at


def _binary_info(pages: dict[int, bytes]) -> dict[int, bytes]:
    """Read what picotool shows, by pico/binary_info/structure.h of the SDK: strings by their id."""
    image = b"".join(pages.get(at, bytes(256)) for at in range(FLASH_BASE, max(pages) + 256, 256))
    header = image.index(struct.pack("<I", 0x7188EBF2), 0, 0x200)
    begin, end, copied, mark = struct.unpack_from("<4I", image, header + 4)
    assert mark == 0xE71AA390
    moves: list[
        tuple[int, ...]
    ] = []  # source, first and end address of the copies into RAM at the start; 0 ends the list
    while (move := struct.unpack_from("<3I", image, copied - FLASH_BASE + 12 * len(moves)))[0]:
        moves.append(move)

    def place(address: int) -> int:
        inside = (address - to + source for source, to, last in moves if to <= address < last)
        return next(inside, address) - FLASH_BASE

    found = {}
    for (entry,) in struct.iter_unpack("<I", image[place(begin) : place(end)]):
        kind, tag, name, value = struct.unpack_from("<H2sII", image, place(entry))
        if (kind, tag) == (6, b"RP"):
            found[name] = image[place(value) :].partition(b"\0")[0]
    return found


def test_picotool_can_tell_what_a_file_is(lasting_pico: EmulatedPico) -> None:
    model = lasting_pico.model
    told = _binary_info(uf2.check(model.image.read_bytes(), model.chip))
    program_name, version, board = 0x02031C86, 0x11A9BC3A, 0xB63CFFBB
    assert told[program_name] == b"Torsio haptic knob"
    assert told[version].decode() == torsio.read_firmware(model.image).version
    assert told[board].decode() == model.name


def test_identity_gives_board_rate_and_the_chips_serial_number(pico: EmulatedPico) -> None:
    identity = pico.get("identity")
    assert identity["board"] == pico.model.number
    assert identity["control_period_ns"] == pico.model.tick_ns
    assert bytes(identity["serial"]).decode() == SERIAL.hex().upper()


def test_a_second_bus_reset_and_enumeration_work_like_the_first(pico: EmulatedPico) -> None:
    first = pico.get("identity")
    pico.enumerate()
    assert pico.get("identity") == first
    assert pico.command("disarm") == "ok"


def test_effect_commit_arm_and_telemetry_go_through_the_real_endpoints(pico: EmulatedPico) -> None:
    assert pico.send("stream", decimation=10, prompt="off")["status"] == 0
    assert pico.send("friction", slot=2, torque_nm=0.02, stiffness_nm_per_rad=2.0)["status"] == 0
    assert pico.send("commit", active=1 << 2)["status"] == 0
    assert pico.command("arm") == "ok"
    pico.telemetry.clear()
    pico.listen(10)
    assert len(pico.telemetry) >= 5
    ticks = [report["tick"] for report in pico.telemetry]
    assert all(later > earlier for earlier, later in itertools.pairwise(ticks))
    assert {report["flags"] & 3 for report in pico.telemetry} == {1}


def test_acknowledgement_says_why_a_report_was_refused(pico: EmulatedPico) -> None:
    answer = pico.send("wall", slot=0, angle_turns_q32=0, side="above",
                       stiffness_nm_per_rad=-1.0, damping_nm_s_per_rad=0.0)  # fmt: skip
    assert (answer["report"], answer["status"], answer["field"]) == (0x20, 5, 5)


@pytest.mark.parametrize(
    ("kind", "request_", "value", "index", "length"),
    [
        (0xA1, 0x01, FEATURE << 8 | 0x7E, 0, 64),  # no such report
        (0xA1, 0x01, FEATURE << 8 | 0x10, 0, 64),  # an output report
        (0xA1, 0x01, 0x0143, 0, 64),  # no such input report
        (0xA1, 0x01, FEATURE << 8 | 0x01, 1, 64),  # no such interface
        (0xA1, 0x03, 0, 0, 1),  # GET_PROTOCOL: no boot device
        (0x21, 0x0B, 0, 0, 0),  # SET_PROTOCOL
        (0x21, 0x0A, 0x0400, 0, 0),  # an idle rate
        (0x21, 0x09, 0x0210, 0, 0),  # SET_REPORT without data
        (0x21, 0x55, 0, 0, 0),  # no such class request
        (0xC0, 0x01, 0, 0, 64),  # no vendor requests
        (0x81, 0x06, 0x2300, 0, 64),  # no physical descriptor
        (0x80, 0x06, 0x0600, 0, 10),  # full speed only: no qualifier
        (0x80, 0x06, 0x03EE, 0, 64),  # no such string
        (0x00, 0x03, 0x0007, 0, 0),  # no such feature
        (0x00, 0x06, 0x0100, 0, 18),  # GET_DESCRIPTOR with data to the device
        (0x00, 0x00, 0, 0, 2),  # GET_STATUS with data to the device
    ],
)
def test_unknown_request_stalls_and_the_next_one_works(
    lasting_pico: EmulatedPico, kind: int, request_: int, value: int, index: int, length: int
) -> None:
    before = lasting_pico.get("identity")
    with pytest.raises(UsbStall):
        lasting_pico.control(kind, request_, value, index, length)
    assert lasting_pico.get("identity") == before


def test_less_data_than_announced_stalls_and_changes_nothing(pico: EmulatedPico) -> None:
    values = {**pico.get("control_config"), "sequence": 77, "beta": 0.75}
    good = wire.encode("control_config", values)
    with pytest.raises(UsbStall):
        pico.control(0x21, 0x09, FEATURE << 8 | CONTROL, 0, 64, good[:50])
    pico.listen(3)
    assert pico.get("control_config")["beta"] == 0.5


def test_host_that_reads_nothing_is_made_to_wait_and_loses_no_command(pico: EmulatedPico) -> None:
    sent = 0
    command = wire.REPORTS["command"]
    for sequence in range(100, 200):
        data = struct.pack(command.format, command.id, sequence, 0, 2).ljust(64, b"\0")
        if pico.write(data, within_ms=4) == "nak":
            break
        sent += 1
    assert 10 < sent < 60
    answered = []
    for _ in range(2 * sent):
        found = pico.read()
        if found:
            answered.append(found[1]["sequence"])
    assert answered == list(range(100, 100 + sent))


def test_time_stamps_repeat_from_run_to_run() -> None:
    def run() -> list[object]:
        with enumerated() as pico:
            pico.send("stream", decimation=7, prompt="off")
            pico.turn(40, period_us=33)
            pico.listen(8)
            return [pico.status()["ns"], pico.get("clock"), *pico.telemetry]

    first, second = run(), run()
    assert len(first) > 4
    assert first == second


def test_prompt_report_is_filled_just_before_the_host_asks(pico: EmulatedPico) -> None:
    tick_ns = pico.model.tick_ns
    # So that the main loop has less time to be punctual.
    pico.arm_at_wall(4)
    assert pico.send("stream", decimation=1, prompt="on")["status"] == 0
    # A time before tick 0: the clock's answer is late by less than a tick.
    first_ns = 0
    for _ in range(10):
        asked_ns = pico.run(0.37)
        first_ns = max(first_ns, asked_ns - (pico.get("clock")["tick"] + 1) * tick_ns)
    # At other phases of frame and tick a Pico that has little time leaves frames without a report.
    next_ns = pico.run(0.05)
    ages_ns = []
    for _ in range(20):
        next_ns += 1_000_000
        now_ns = pico.run((next_ns - pico.run(0.0)) / 1e6)
        found = pico.read(within_ms=0.01)
        assert found, "a frame without a report"
        assert found[0] == "telemetry"
        newest = found[1]["tick"] + (found[1]["axis_samples"] >> 4) - 1
        ages_ns.append(now_ns - first_ns - newest * tick_ns)
    # A quarter of a frame, two ticks, and the uncertainty of tick 0. A report left over from the
    # last frame would be a whole frame old.
    assert max(ages_ns[2:]) < 600_000
