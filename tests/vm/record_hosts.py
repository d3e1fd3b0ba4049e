"""Write ``tests/golden/hosts.json``: the reports that real hosts make of a game's effects.

Boots virtual machines with what ``./dev test games`` has fetched and made. The tests that play the
reports back are ``tests/python/test_game_hosts.py``: a short form of those in the machines.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys

from tests.vm import guests
from tests.vm.machine import Machine

FILE = guests.TREE / "tests/golden/hosts.json"
HOSTS = {"wine": guests.KERNELS / "6.1", "linux": guests.NEWEST_KERNELS / "sid"}


def record(host: str) -> dict[str, object]:
    """Return one host's reports, by the names of the effects."""
    share = guests.share(f"record-{host}")
    share.mkdir(parents=True, exist_ok=True)
    run = shlex.join([sys.executable, "-m", "tests.vm.guest.recording", host])
    command = f"""\
export HOME=/tmp PATH=/usr/sbin:/usr/bin:/sbin:/bin
cd {shlex.quote(str(guests.TREE))} && {run} >/torsio-share/reports
"""
    Machine(HOSTS[host], share).run(command, limit_s=guests.LIMIT_S)
    found: dict[str, object] = json.loads((share / "reports").read_text())
    return found


def main() -> None:
    """Record all hosts anew."""
    wine = subprocess.run(["wine", "--version"], capture_output=True, text=True, check=True)
    found = {host: record(host) for host in HOSTS}
    found["wine"]["version"] = wine.stdout.strip()
    FILE.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
