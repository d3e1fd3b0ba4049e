"""Opens a knob that is plugged in through a wheel, in a virtual machine.

``python -m tests.vm.wheel SYSTEM TRIAL VERSION`` boots a machine in which the folder SYSTEM is the
root of the program that opens the knob; see ``tools/wheel_oldest.py``, which makes it.
"""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from tests.vm import guests
from tests.vm.machine import GuestFailed, Machine
from tools import wheel_oldest


def run(system: Path, trial: Path, version: str) -> str:
    """Boot the machine, and return what the first steps said in it.

    Raises
    ------
    GuestFailed
        If the knob was not opened, or the wall not felt.
    """
    share = guests.share("wheel")
    share.mkdir(parents=True, exist_ok=True)
    own = wheel_oldest.HOME
    program = f"{system}{own}/lib/python{version}/site-packages/torsio/bin/torsio_virtual_knob"
    steps = (f"{own}/bin/python", "-W", "error", f"{wheel_oldest.TRIAL}/first_steps.py")
    inside = ("chroot", str(system), *steps)
    words = [sys.executable, "-m", "tests.vm.guest.wheel", program, *inside]
    mounts = {"/dev": "dev", "/sys": "sys", "/proc": "proc", "/run": "run", str(trial): "trial"}
    lines = [
        f"mount --rbind {shlex.quote(here)} {shlex.quote(f'{system}/{there}')} || exit 2"
        for here, there in mounts.items()
    ]
    command = f"""\
export HOME=/tmp PYTHONUNBUFFERED=1 PATH=/usr/sbin:/usr/bin:/sbin:/bin
cd {shlex.quote(str(guests.TREE))} || exit 2
{chr(10).join(lines)}
{shlex.join(words)} >/torsio-share/told
"""
    kernel = guests.KERNELS / guests.kernels()[0]
    Machine(kernel, share).run(command, limit_s=guests.LIMIT_S)
    return (share / "told").read_text()


def main(arguments: list[str]) -> int:
    """Print what the first steps said."""
    system, trial, version = arguments
    try:
        print(run(Path(system), Path(trial), version), end="")
    except GuestFailed as failure:
        print(failure, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
