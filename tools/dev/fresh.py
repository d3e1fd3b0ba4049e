"""A bare system of a distribution's release, and README's commands in it.

``debootstrap`` makes the system from the archive that this system's own apt uses, once; each run
begins with a new copy of it. The commands run there as an ordinary user with sudo, in a clone whose
path has a blank and a letter that is not ASCII, in a home closed to others: whatever a user's
machine may have is met here at once.

Mounts of the system are in a name space of their own and go with its last process,
however that ends.
"""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tools import apt
from tools.dev import packages, running
from tools.dev.running import BUILD, TREE, Failed, UsageError, become_root, run_logged, say

COMMANDS = ("demo", "test")
USER = "zoe"
HOME = f"/home/{USER}"  # closed to others, as Debian makes it
# No apostrophe: Ninja 1.11 of Debian 12 takes the name of a header for two there, and compiles
# everything again each time.
PLACE = f"{HOME}/Zoë knob"
# How this machine reaches the network, as far as environment variables tell.
_NETWORK = re.compile(
    r"(\w+_proxy|pip_\w+|npm_config_\w+|ssl_cert_(file|dir)|node_extra_ca_certs"
    r"|(requests|curl)_ca_bundle)",
    re.IGNORECASE,
)
# The same, from the configuration of pip and npm.
_PIP_SETTINGS = (
    *("index-url", "extra-index-url", "find-links", "trusted-host"),
    *("cert", "proxy", "timeout"),
)
_NPM_SETTINGS = ("registry", "proxy", "https-proxy", "cafile", "strict-ssl")
# Runs as root in a mount and process name space of its own: SYSTEM, USER, folders to mount as
# "FROM TO" lines, then the command.
_ENTER = """
set -eu
system=$1 user=$2 folders=$3
shift 3
mount -t proc proc "$system/proc"
mount --rbind /sys "$system/sys"
mount --rbind /dev "$system/dev"
mount -t tmpfs tmpfs "$system/run"
printf %s "$folders" | while IFS='\t' read -r from to; do
  mount --bind -o ro "$from" "$system$to"
done
exec chroot --userspec="$user" "$system" "$@"
"""


@dataclass
class Network:
    """How this machine reaches the network, as another system needs to be told.

    Attributes
    ----------
    variables
        For the environment.
    files
        Certificates: where they will stand, and what is in them.
    folders
        Where they will be mounted, and what they are here.
    """

    variables: dict[str, str] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    folders: dict[str, Path] = field(default_factory=dict)

    def add(self, name: str, value: str) -> None:
        """Add a variable; if it names a file or a folder of this machine, that comes along."""
        path = Path(value)
        number = len(self.files) + len(self.folders)
        if path.is_absolute() and path.is_file():
            value = f"/etc/torsio-fresh/{number}-{path.name}"
            self.files[value] = path.read_bytes()
        elif path.is_absolute() and path.is_dir():
            value = f"/mnt/torsio-fresh-{number}"
            self.folders[value] = path
        self.variables[name] = value


def network(environment: Mapping[str, str], pip: str, npm: Mapping[str, str]) -> Network:
    """Gather how this machine reaches the network.

    Parameters
    ----------
    environment
        Of this process; it has the last word, as it does with pip and npm themselves.
    pip
        Output of ``pip config list``.
    npm
        Settings of npm; ``null`` and ``undefined`` count as empty.
    """
    found: dict[str, str] = {}
    for name, value in re.findall(r"^[\w:.-]*?\.?([\w-]+)='(.*)'$", pip, re.MULTILINE):
        if name in _PIP_SETTINGS:
            found[f"PIP_{name.upper().replace('-', '_')}"] = value
    for name, value in npm.items():
        if value not in ("", "null", "undefined"):
            found[f"npm_config_{name.replace('-', '_')}"] = value
    found |= {name: value for name, value in environment.items() if _NETWORK.fullmatch(name)}
    result = Network()
    for name, value in found.items():
        result.add(name, value)
    return result


def _this_network() -> Network:
    pip = running.output_of("python3", "-m", "pip", "config", "list")
    npm = {}
    if shutil.which("npm"):
        npm = {
            name: running.output_of("npm", "config", "get", name).strip() for name in _NPM_SETTINGS
        }
    return network(os.environ, pip, npm)


def sources(archive: apt.Archive, suite: str, distribution: str) -> str:
    """Return the lines of ``sources.list`` for a suite with its updates."""
    security = archive.security.uri if distribution == "debian" else archive.uri
    components = "main" if distribution == "debian" else "main universe"
    return "".join(
        f"deb {uri} {name} {components}\n"
        for uri, name in (
            (archive.uri, suite),
            (archive.uri, f"{suite}-updates"),
            (security, f"{suite}-security"),
        )
    )


def apt_settings(dump: str) -> str:
    """Return the lines of ``apt-config dump`` that tell of proxies and certificates."""
    lines = re.findall(r'^Acquire::https?(?:::[^ ]+)? "[^"\n]+";$', dump, re.MULTILINE)
    return "".join(f"{line}\n" for line in lines)


def _write(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write files below a folder, for a system's root to be laid over."""
    for name, content in files.items():
        file = folder / name.lstrip("/")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content.encode() if isinstance(content, str) else content)
        file.chmod(0o440 if "sudoers" in name else 0o644)


def clone(folder: Path) -> None:
    """Clone this tree into a folder, and replace its content.

    Raises
    ------
    Failed
        If it is no clone itself.
    """
    if not (TREE / ".git").exists():
        raise Failed("this tree is no clone, so there is nothing to clone")
    if running.output_of("git", "status", "--porcelain"):
        say("the tree has changes that are not committed; they are not in the clone")
    shutil.rmtree(folder, ignore_errors=True)
    run_logged("fresh-clone", ["git", "clone", "--no-hardlinks", TREE, folder])


def make_base(base: Path, suite: str, archive: apt.Archive, as_root: Sequence[str]) -> None:
    """Make a bare system in a folder, unless it is there.

    Raises
    ------
    Failed
        If the archive has not all of it.
    """
    if base.exists():
        return
    say(f"fresh {suite}: making a bare system from {archive.uri}")
    unfinished = base.with_name("unfinished")
    keyring = (f"--keyring={archive.signed_by}",) if archive.signed_by else ()
    options = ("--variant=minbase", "--include=sudo", *keyring)
    run_logged(
        f"fresh-{suite}",
        [*as_root, "rm", "-rf", "--one-file-system", unfinished],
        [*as_root, "/usr/sbin/debootstrap", *options, suite, unfinished, archive.uri],
        [*as_root, "mv", unfinished, base],
    )


def entering(
    system: Path, user: str, folders: Mapping[str, Path], variables: Mapping[str, str]
) -> list[str]:
    """Return the words before a command that root has a user run in a system.

    Parameters
    ----------
    system
        Its root.
    user
        One of its users.
    folders
        Where folders of this machine are mounted there.
    variables
        All that the command finds in its environment.
    """
    mounted = "".join(f"{here}\t{there}\n" for there, here in folders.items())
    enter = ["unshare", "--mount", "--pid", "--fork", "--kill-child"]
    enter += ["sh", "-c", _ENTER, "enter", str(system), user, mounted]
    return [*enter, "env", "-i", *(f"{name}={value}" for name, value in variables.items())]


def run_in(suite: str, commands: Sequence[Sequence[str]]) -> int:
    """Run commands of ``./dev`` in a bare system and return the status of the last one.

    The first that fails is the last one.

    Raises
    ------
    Failed
        If the system cannot be made.
    UsageError
        If there can be no such suite.
    """
    if not re.fullmatch(r"[a-z][a-z0-9.-]*", suite):
        raise UsageError(f"'{suite}' is no suite; Debian's are called trixie, for example")
    packages.begin_set_up(("fresh",))[0].result()
    as_root = become_root("a bare system is made by root", f"./dev fresh {suite}")
    try:
        archive = apt.system_archive()
    except RuntimeError as error:
        raise Failed(f"{error}, so there is nothing to make a system from") from None
    folder = BUILD / "fresh" / suite
    base, system, copy, overlay = (folder / name for name in ("base", "system", "clone", "overlay"))
    folder.mkdir(parents=True, exist_ok=True)
    make_base(base, suite, archive, as_root)

    say(f"fresh {suite}: copying it, with a clone of the tree for its user {USER}")
    clone(copy)
    net = _this_network()
    keep = " ".join(name for name in net.variables if name.lower().endswith("_proxy"))
    sudoers = f"{USER} ALL=(ALL) NOPASSWD: ALL\n"
    if keep:
        sudoers += f'Defaults env_keep += "{keep}"\n'
    shutil.rmtree(overlay, ignore_errors=True)
    _write(
        overlay,
        {
            **net.files,
            "etc/apt/sources.list": sources(archive, suite, apt.os_release("ID")),
            "etc/apt/apt.conf.d/90host": apt_settings(running.output_of("apt-config", "dump")),
            "etc/sudoers.d/torsio": sudoers,
            "etc/hosts": Path("/etc/hosts").read_bytes(),
            "etc/resolv.conf": Path("/etc/resolv.conf").read_bytes(),
        },
    )
    for mount_point in net.folders:
        (overlay / mount_point.lstrip("/")).mkdir(parents=True)
    home = f"{system}{PLACE}"
    run_logged(
        f"fresh-{suite}-copy",
        [*as_root, "rm", "-rf", "--one-file-system", system],
        [*as_root, "cp", "-a", base, system],
        [*as_root, "cp", "-rT", "--preserve=mode", "--remove-destination", overlay, system],
        [*as_root, "chroot", system, "useradd", "--create-home", "--shell", "/bin/bash", USER],
        [*as_root, "cp", "-rT", "--preserve=mode,timestamps", copy, home],
        [*as_root, "chroot", system, "chown", "-R", f"{USER}:", PLACE],
        [*as_root, "chroot", system, "chmod", "0700", HOME],
    )
    return _run_commands(suite, system, net, as_root, commands)


def _run_commands(
    suite: str,
    system: Path,
    net: Network,
    as_root: Sequence[str],
    commands: Sequence[Sequence[str]],
) -> int:
    variables = {
        "HOME": HOME,
        "USER": USER,
        "LOGNAME": USER,
        "PATH": "/usr/local/bin:/usr/bin:/bin",
        "TERM": os.environ.get("TERM", "dumb"),
        **net.variables,
    }
    enter = [*as_root, *entering(system, USER, net.folders, variables)]
    for command in commands:
        line = " ".join(("./dev", *command))
        say(f"fresh {suite}: {line}, as {USER} in '{PLACE}'")
        begin_s = time.monotonic()
        status = running.run(*enter, "sh", "-c", 'cd "$0" && exec ./dev "$@"', PLACE, *command)
        took = f"after {time.monotonic() - begin_s:.0f} s"
        if status != 0:
            say(f"fresh {suite}: {line} failed with status {status} {took}; see {system}{PLACE}")
            return status
        say(f"fresh {suite}: {line} ended well {took}")
    return 0
