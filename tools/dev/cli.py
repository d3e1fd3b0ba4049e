"""Reads the command line of ``./dev`` and runs one command."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from tools.dev import benches, building, commands, fresh, running
from tools.dev.running import Failed, UsageError


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong with the arguments."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{self.prog}: {message}")


def _parser(command: str) -> _Parser:
    return _Parser(prog=f"'{command}'", add_help=False, allow_abbrev=False)


def _plain(command: str, function: Callable[[], int]) -> Callable[[Sequence[str]], int]:
    def start(arguments: Sequence[str]) -> int:
        if arguments:
            raise UsageError(f"'{command}' takes no arguments")
        return function()

    return start


def _with_flag(
    command: str, flag: str, function: Callable[[Sequence[str]], int]
) -> Callable[[Sequence[str]], int]:
    def start(arguments: Sequence[str]) -> int:
        parser = _parser(command)
        parser.add_argument(flag, action="store_true")
        parser.parse_args(arguments)
        return function(arguments)

    return start


def _build(arguments: Sequence[str]) -> int:
    known = (*building.PRESETS, "python")
    for preset in arguments:
        if preset not in known:
            raise UsageError(f"unknown preset '{preset}'")
    return commands.build(arguments or ("dev", "python"))


def _udev(arguments: Sequence[str]) -> int:
    parser = _parser("udev")
    parser.add_argument("--remove", action="store_true")
    return commands.udev(remove=parser.parse_args(arguments).remove)


def _fresh(arguments: Sequence[str]) -> int:
    parser = _parser("fresh")
    parser.add_argument("suite")
    parser.add_argument("command", nargs="?", choices=fresh.COMMANDS)
    options, rest = parser.parse_known_args(arguments)
    if rest and options.command is None:
        raise UsageError(f"'fresh': {rest[0]} belongs behind demo or test")
    chosen = [[options.command, *rest]] if options.command else [[name] for name in fresh.COMMANDS]
    return fresh.run_in(options.suite, chosen)


# Those that take everything hand it on to the program that they run.
COMMANDS: dict[str, Callable[[Sequence[str]], int]] = {
    "setup": _plain("setup", commands.setup),
    "build": _build,
    "test": commands.test,
    "check": _with_flag("check", "--fix", commands.check),
    "demo": commands.demo,
    "game": commands.game,
    "hardware": commands.hardware,
    "studio": commands.studio,
    "site": _plain("site", commands.site),
    "bench": benches.bench,
    "mutate": commands.mutate,
    "fuzz": commands.fuzz,
    "determinism": commands.determinism,
    "soak": commands.soak,
    "unplugs": commands.unplugs,
    "faults": commands.faults,
    "firmware": _plain("firmware", commands.firmware),
    "release": commands.release,
    "wheels": commands.wheels,
    "windows": commands.windows,
    "macos": commands.macos,
    "ros": commands.ros,
    "udev": _udev,
    "generate": _with_flag("generate", "--check", commands.generate),
    "fresh": _fresh,
    "clean": _plain("clean", commands.clean),
}


def _end(number: int, _frame: object) -> NoReturn:
    raise SystemExit(128 + number)


def main(arguments: Sequence[str]) -> int:
    """Run one command and return the exit status: 1 if a step fails, 2 for bad arguments."""
    # To be ended is to be interrupted: nothing is left running or mounted.
    signal.signal(signal.SIGTERM, _end)
    signal.signal(signal.SIGHUP, _end)
    name, *rest = arguments or [""]
    try:
        if name not in COMMANDS:
            raise UsageError(f"unknown command '{name}'")
        building.use_compiler_cache()
        return COMMANDS[name](rest)
    except UsageError as error:
        print(f"torsio: error: {error} (see ./dev help)", file=sys.stderr)
        return 2
    except Failed as error:
        print(f"torsio: error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    finally:
        running.stop_all()
