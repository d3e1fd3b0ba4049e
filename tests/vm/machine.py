"""A virtual machine that boots a kernel and runs a command in the host's own file system."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from tests.vm import initramfs

TREE = Path(__file__).parent.parent.parent
ACCELERATOR_VARIABLE = "TORSIO_VM_ACCEL"
# Features of a processor that NumPy's wheels need; qemu64 has cx16.
_FEATURES = "+ssse3,+sse4.1,+sse4.2,+popcnt"
_PROCESSOR = f"qemu64,{_FEATURES}"
# An emulated processor takes a nanosecond of the guest's time for an instruction; where it waits,
# time jumps on. So a test does not depend on the host's load. QEMU counts with one thread only.
_ACCELERATION = {
    "kvm": ["-accel", "kvm"],
    "tcg": ["-accel", "tcg,thread=single,tb-size=512", "-icount", "shift=0,sleep=off"],
}
_BOOT = (
    "console=ttyS0 panic=-1 quiet mitigations=off nokaslr tsc=reliable no_timer_check audit=0 "
    "apparmor=0 random.trust_cpu=on log_buf_len=4M"
)
# Under QEMU 7.2 a boot has died of a double fault right behind an emulated cmpxchg16b in the
# kernel's allocator, with flags that no instruction sets. The kernel does well without; programs
# are shown that the processor has it.
_BOOT_EMULATED = "clearcpuid=cx16"
_PROBE_LIMIT_S = 5.0
_TAIL_LINES = 60


class GuestFailed(Exception):
    """The machine did not end as it should; says how, and how its console ended."""


@dataclass(frozen=True)
class Machine:
    """One kernel's virtual machine.

    Attributes
    ----------
    kernel
        Folder with ``vmlinuz`` and ``modules``; see ``tools/kernels.py``.
    share
        Folder that the guest sees as ``/torsio-share`` and may write to. Holds ``console`` and,
        after a run, ``dmesg``.
    emulated
        Emulate the processor even where the host's own could run the guest. Time in the guest is
        then the count of instructions, 1 ns each, whatever the host is busy with; it passes quickly
        where the guest waits for the host's files.
    """

    kernel: Path
    share: Path
    emulated: bool = False

    def run(self, command: str, *, limit_s: float) -> None:
        """Boot, run a shell command as root, and end.

        Raises
        ------
        GuestFailed
            If the command's status is not 0, the kernel panics, or time is over.
        """
        self.share.mkdir(parents=True, exist_ok=True)
        (self.share / "command").write_text(command)
        (self.share / "tree").write_text(f"{TREE}\n")
        (self.share / "dmesg").unlink(missing_ok=True)
        name = "tcg" if self.emulated else accelerator(self.kernel)
        status = self._boot(name, "", limit_s)
        if status != 1:  # a panic ends with 0
            reason = {
                None: f"did not end in {limit_s:g} s",
                0: "died: panic or reset",
            }.get(status, f"ended with status {(status or 0) // 2}")
            raise GuestFailed(f"the guest {reason}; its console's end:\n{self.console_tail()}")

    def probe(self, accelerator_name: str) -> bool:
        """Tell whether the machine comes up at all with an accelerator."""
        self.share.mkdir(parents=True, exist_ok=True)
        return self._boot(accelerator_name, "torsio.probe", _PROBE_LIMIT_S) == 1

    def console_tail(self) -> str:
        """Return the last lines that the guest has printed."""
        text = (self.share / "console").read_text(errors="replace")
        return "\n".join(text.splitlines()[-_TAIL_LINES:])

    def _boot(self, accelerator_name: str, arguments: str, limit_s: float) -> int | None:
        qemu = shutil.which("qemu-system-x86_64")
        if qemu is None:
            raise GuestFailed("no QEMU; on Debian: apt-get install qemu-system-x86")
        image = self.share / "initramfs"
        image.write_bytes(initramfs.build(self.kernel))
        console = self.share / "console"
        console.write_bytes(b"")
        accel = _ACCELERATION[accelerator_name]
        emulated = _BOOT_EMULATED if accelerator_name == "tcg" else ""
        command = [
            *(qemu, "-M", "pc", *accel, "-cpu", _PROCESSOR),
            *("-smp", "1", "-m", "1024", "-nodefaults", "-no-user-config", "-no-reboot"),
            *("-display", "none", "-serial", f"file:{console}"),
            *("-kernel", str(self.kernel / "vmlinuz"), "-initrd", str(image)),
            *("-append", f"{_BOOT} {emulated} {arguments}"),
            *("-device", "isa-debug-exit,iobase=0xf4,iosize=4"),
            *_folder("root", Path("/"), "readonly=on,"),
            *_folder("share", self.share, ""),
        ]
        with console.open("ab") as errors:
            try:
                return subprocess.run(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=errors,
                    timeout=limit_s,
                    check=False,
                ).returncode
            except subprocess.TimeoutExpired:
                return None


def _folder(tag: str, path: Path, options: str) -> tuple[str, ...]:
    escaped = str(path).replace(",", ",,")
    local = f"local,id={tag},path={escaped},{options}security_model=none,multidevs=remap"
    return ("-fsdev", local, "-device", f"virtio-9p-pci,fsdev={tag},mount_tag={tag}")


def accelerator(kernel: Path) -> str:
    """Return "kvm" where a machine comes up with it, else "tcg", which is emulation.

    The environment variable ``TORSIO_VM_ACCEL`` decides without a try. The result of a try is
    kept in the kernel's folder.

    Raises
    ------
    ValueError
        If the variable names neither.
    """
    chosen = os.environ.get(ACCELERATOR_VARIABLE)
    if chosen is not None:
        if chosen not in _ACCELERATION:
            raise ValueError(f"{ACCELERATOR_VARIABLE} is {chosen!r}, must be kvm or tcg")
        return chosen
    if not os.access("/dev/kvm", os.R_OK | os.W_OK):
        return "tcg"
    # The file may exist without working, and finding out takes long: do it once.
    answer = kernel / "accelerator"
    if not answer.exists():
        share = kernel / "probe"
        answer.write_text("kvm" if Machine(kernel, share).probe("kvm") else "tcg")
        shutil.rmtree(share)
    return answer.read_text()
