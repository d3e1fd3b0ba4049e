"""The kernel's own tests of USB devices: its driver ``usbtest``, and what its ``testusb`` does.

The driver comes with the kernel, the program ``testusb`` only with its sources: it hands a test's
number and size to the driver and waits, which is `Usbtest.run` here.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import socket
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from tests.vm import initramfs
from tests.vm.guest.virtual_bus import Cable, VirtualKnob
from tests.vm.guests import KERNELS

_DRIVER = Path("/sys/bus/usb/drivers/usbtest")
_IOCTL = 0xC0105512  # USBDEVFS_IOCTL of linux/usbdevice_fs.h
_TEST = 0xC01C5564  # _IOWR('U', 100, of seven words), of drivers/usb/misc/usbtest.c

# Parts of the device descriptor: packet size, vendor and product. The driver takes only devices
# that it knows. With Linux' gadget for tests it uses any endpoints of the descriptors.
_KNOB, _GADGET = bytes.fromhex("40 0912 0100"), bytes.fromhex("40 2505 a0a4")
# Endpoint descriptors of interface 0.
_OUT, _IN = (bytes((7, 5, address, 3, 64, 0, 1)) for address in (0x01, 0x81))


class _Parameters(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_uint32)
        for name in ("test", "iterations", "length", "vary", "sglen", "seconds", "microseconds")
    ]


class _Request(ctypes.Structure):
    _fields_ = [("interface", ctypes.c_int), ("code", ctypes.c_int), ("data", ctypes.c_void_p)]


def lying_cable(*, bulk_out: bool = False, bulk_in: bool = False) -> Cable:
    """Return a cable on which the kernel takes the knob for the driver's gadget.

    Also, if told to, endpoints of interface 0 for bulk ones, which most of the driver's tests are
    for. The knob cannot tell the difference: the packets are the same, and how often it is asked
    is the host's business.
    """
    lies = [(_KNOB, _GADGET)]
    lies += [
        (one, one[:3] + b"\2" + one[4:]) for one, lie in ((_OUT, bulk_out), (_IN, bulk_in)) if lie
    ]

    def pump(source: socket.socket, sink: socket.socket, told: list[tuple[bytes, bytes]]) -> None:
        with suppress(OSError):
            while data := source.recv(1 << 16):
                for truth, lie in told:
                    data = data.replace(truth, lie)
                sink.sendall(data)
        with suppress(OSError):
            sink.shutdown(socket.SHUT_RDWR)  # ends the other direction too
        source.close()

    def cable(knob: socket.socket) -> socket.socket:
        with socket.create_server(("127.0.0.1", 0)) as listener:
            kernel = socket.create_connection(listener.getsockname())
            middle, _ = listener.accept()
        for end in (kernel, middle):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for source, sink, told in ((knob, middle, lies), (middle, knob, [])):
            threading.Thread(target=pump, args=(source, sink, told), daemon=True).start()
        return kernel

    return cable


def _libc(name: str, *arguments: object) -> None:
    if ctypes.CDLL(None, use_errno=True).syscall(*arguments) != 0:
        code = ctypes.get_errno()
        raise OSError(code, f"{name}: {os.strerror(code)}")


@contextmanager
def loaded(kernel: str, parameters: Mapping[str, int]) -> Iterator[None]:
    """Load the driver for as long as it lasts."""
    init_module, delete_module = 175, 176  # numbers on x86-64
    module = initramfs.load_order(KERNELS / kernel / "modules", ("usbtest",))["usbtest"]
    text = " ".join(f"{name}={value}" for name, value in parameters.items()).encode()
    _libc("init_module", init_module, module, ctypes.c_ulong(len(module)), text)
    try:
        yield
    finally:
        _libc("delete_module", delete_module, b"usbtest", os.O_NONBLOCK)


class Usbtest:
    """Interface 0 of a knob in the hands of the driver."""

    def __init__(self, knob: VirtualKnob) -> None:
        self._knob = knob
        name = knob.interface.name
        if not (_DRIVER / name).exists():  # another driver came first
            (knob.interface / "driver/unbind").write_text(name)
            (_DRIVER / "bind").write_text(name)

    def run(
        self, test: int, *, iterations: int = 1, length: int = 64, vary: int = 0, sglen: int = 0
    ) -> None:
        """Run one test.

        Raises
        ------
        OSError
            If it fails; the kernel's log says why.
        """
        numbers = [int((self._knob.sysfs / name).read_text()) for name in ("busnum", "devnum")]
        parameters = _Parameters(test, iterations, length, vary, sglen, 0, 0)
        request = _Request(0, ctypes.c_int(_TEST & 0xFFFFFFFF).value, ctypes.addressof(parameters))
        file = os.open("/dev/bus/usb/{:03}/{:03}".format(*numbers), os.O_RDWR)
        try:
            fcntl.ioctl(file, _IOCTL, request)
        except OSError as error:
            raise OSError(
                error.errno, f"usbtest {test}: {errno.errorcode.get(error.errno or 0)}"
            ) from error
        finally:
            os.close(file)
