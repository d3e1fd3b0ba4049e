"""The first file system of a virtual machine: busybox, a few kernel modules, and a script."""

from __future__ import annotations

import gzip
import lzma
import re
import shutil
import stat
from pathlib import Path

# Modules that a test needs beside the kernel's built-in ones. Their dependencies come along.
MODULES = (
    "virtio_pci",
    "9pnet_virtio",
    "9p",
    "overlay",
    "vhci_hcd",
    "usbhid",
    "hid_generic",
    "evdev",
    "joydev",
)
INIT = Path(__file__).with_name("init.sh")
_SUFFIXES = (".ko", ".ko.xz", ".ko.gz")


def module_name(file: Path | str) -> str:
    """Return a module's name as the kernel writes it."""
    return Path(file).name.partition(".ko")[0].replace("-", "_")


def read_module(file: Path) -> bytes:
    """Return a module as the kernel takes it, unpacked."""
    data = file.read_bytes()
    if file.suffix == ".xz":
        return lzma.decompress(data)
    return gzip.decompress(data) if file.suffix == ".gz" else data


def dependencies(module: bytes) -> list[str]:
    """Return the names of the modules that a module says it depends on."""
    match = re.search(rb"\0depends=([^\0]*)\0", module)
    names = match.group(1).decode().split(",") if match else []
    return [module_name(name) for name in names if name]


def load_order(folder: Path, wanted: tuple[str, ...] = MODULES) -> dict[str, bytes]:
    """Return the wanted modules of a folder and all that they depend on, in the order to load.

    Raises
    ------
    LookupError
        If there is a module neither in the folder nor in the kernel itself.
    """
    files = {module_name(file): file for file in folder.iterdir() if file.name.endswith(_SUFFIXES)}
    builtin_list = folder / "modules.builtin"
    builtin = {module_name(line) for line in builtin_list.read_text().splitlines()}
    order: dict[str, bytes] = {}

    def add(name: str) -> None:
        if name in order or name in builtin:
            return
        if name not in files:
            raise LookupError(f"{folder} has no module {name}; see MODULES in tools/kernels.py")
        module = read_module(files[name])
        for dependency in dependencies(module):
            add(dependency)
        order[name] = module

    for name in wanted:
        add(name)
    return order


def cpio(files: dict[str, tuple[int, bytes]]) -> bytes:
    """Return an archive in the kernel's "newc" format from paths to mode and content."""
    out = bytearray()
    for number, (path, (mode, data)) in enumerate([*files.items(), ("TRAILER!!!", (0, b""))], 1):
        name = path.encode() + b"\0"
        fields = (number, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(name), 0)
        out += b"070701" + b"".join(b"%08X" % field for field in fields) + name
        out += bytes(-len(out) % 4) + data
        out += bytes(-len(out) % 4)
    return bytes(out)


def build(kernel: Path) -> bytes:
    """Return the initial file system for a kernel's folder.

    Raises
    ------
    LookupError
        If busybox or a module is missing.
    """
    busybox = shutil.which("busybox")
    if busybox is None:
        raise LookupError("no busybox; on Debian: apt-get install busybox-static")
    folders = ("bin", "proc", "sys", "dev", "lower", "upper", "root", "modules")
    files = dict.fromkeys(folders, (stat.S_IFDIR | 0o755, b""))
    files["bin/busybox"] = (stat.S_IFREG | 0o755, Path(busybox).read_bytes())
    files["init"] = (stat.S_IFREG | 0o755, INIT.read_bytes())
    modules = load_order(kernel / "modules")
    for name, module in modules.items():
        files[f"modules/{name}.ko"] = (stat.S_IFREG | 0o644, module)
    order = "".join(f"{name}\n" for name in modules)
    files["modules/order"] = (stat.S_IFREG | 0o644, order.encode())
    return cpio(files)
