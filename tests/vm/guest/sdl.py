"""SDL 2 as games use it, through its own library (SDL_joystick.h, SDL_haptic.h)."""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Callable
from typing import Any

# Kinds of effects; also their bits in the device's features.
CONSTANT, SINE, LEFT_RIGHT, TRIANGLE, SAW_UP, SAW_DOWN, RAMP = (1 << n for n in range(7))
SPRING, DAMPER, INERTIA, FRICTION = (1 << n for n in range(7, 11))
GAIN = 1 << 12

_JOYSTICK_AND_HAPTIC = 0x200 | 0x1000
_FROM_THE_WEST = struct.pack("<B3x3i", 0, 27_000, 0, 0)  # polar, hundredths of a degree
_NO_ENVELOPE = bytes(8)
_POINTER, _INT = ctypes.c_void_p, ctypes.c_int


class SdlError(Exception):
    """SDL's own error."""


def _head(kind: int, length_ms: int) -> bytes:
    return struct.pack("<H2x", kind) + _FROM_THE_WEST + struct.pack("<IHHH", length_ms, 0, 0, 0)


def constant(level: int, length_ms: int) -> bytes:
    """Return an SDL_HapticEffect, and so below."""
    return _head(CONSTANT, length_ms) + struct.pack("<h", level) + _NO_ENVELOPE


def ramp(start: int, end: int, length_ms: int) -> bytes:
    return _head(RAMP, length_ms) + struct.pack("<2h", start, end) + _NO_ENVELOPE


def periodic(kind: int, magnitude: int, period_ms: int, length_ms: int) -> bytes:
    return _head(kind, length_ms) + struct.pack("<HhhH", period_ms, magnitude, 0, 0) + _NO_ENVELOPE


def condition(kind: int, coefficient: int, length_ms: int) -> bytes:
    sides = [65_535] * 6 + [coefficient] * 6 + [0] * 6
    return _head(kind, length_ms) + struct.pack("<6H6h3H3h", *sides)


def left_right(large: int, small: int, length_ms: int) -> bytes:
    return struct.pack("<H2xIHH", LEFT_RIGHT, length_ms, large, small)


def _effect(effect: bytes) -> tuple[Any, bytes]:
    return ctypes.c_char_p, effect.ljust(128, b"\0")  # as large as the union of all kinds


class Sdl:
    """SDL without a window, and its first joystick with its forces."""

    def __init__(self) -> None:
        os.environ["SDL_VIDEODRIVER"] = "dummy"
        os.environ["SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS"] = "1"
        self._library = ctypes.CDLL("libSDL2-2.0.so.0")
        self._call("Init", _INT, (ctypes.c_uint32, _JOYSTICK_AND_HAPTIC))
        self.joystick = self._call("JoystickOpen", _POINTER, (_INT, 0))
        self.haptic = self._call("HapticOpenFromJoystick", _POINTER, (_POINTER, self.joystick))

    def close(self) -> None:
        """End SDL, which stops all forces."""
        self._call("HapticClose", None, (_POINTER, self.haptic))
        self._call("JoystickClose", None, (_POINTER, self.joystick))
        self._call("Quit", None)

    @property
    def name(self) -> str:
        return str(self._call("JoystickName", ctypes.c_char_p, (_POINTER, self.joystick)).decode())

    @property
    def parts(self) -> tuple[int, int]:
        """Numbers of axes and of buttons."""
        return self._number("JoystickNumAxes"), self._number("JoystickNumButtons")

    @property
    def is_haptic(self) -> bool:
        return self._number("JoystickIsHaptic") == 1

    @property
    def can(self) -> int:
        """Bits of the device's abilities."""
        return int(self._call("HapticQuery", ctypes.c_uint, (_POINTER, self.haptic)))

    @property
    def effects(self) -> int:
        """How many the device holds."""
        return int(self._call("HapticNumEffects", _INT, (_POINTER, self.haptic)))

    def axis(self) -> int:
        """Return where the first axis is now, -32768 to 32767."""
        self._call("JoystickUpdate", None)
        return int(
            self._call("JoystickGetAxis", ctypes.c_int16, (_POINTER, self.joystick), (_INT, 0))
        )

    def button(self, number: int) -> bool:
        """Tell whether a button is pressed."""
        self._call("JoystickUpdate", None)
        return bool(
            self._call(
                "JoystickGetButton", ctypes.c_uint8, (_POINTER, self.joystick), (_INT, number)
            )
        )

    def set_gain(self, percent: int) -> None:
        self._haptic("SetGain", percent)

    def new(self, effect: bytes) -> int:
        """Upload an effect and return its number."""
        return int(self._call("HapticNewEffect", _INT, (_POINTER, self.haptic), _effect(effect)))

    def run(self, number: int) -> None:
        self._call(
            "HapticRunEffect",
            _INT,
            *((_POINTER, self.haptic), (_INT, number), (ctypes.c_uint32, 1)),
        )

    def update(self, number: int, effect: bytes) -> None:
        self._call(
            "HapticUpdateEffect",
            _INT,
            *((_POINTER, self.haptic), (_INT, number), _effect(effect)),
        )

    def stop(self, number: int) -> None:
        self._haptic("StopEffect", number)

    def destroy(self, number: int) -> None:
        self._call("HapticDestroyEffect", None, (_POINTER, self.haptic), (_INT, number))

    def _number(self, function: str) -> int:
        return int(self._call(function, _INT, (_POINTER, self.joystick)))

    def _haptic(self, function: str, argument: int) -> int:
        return int(self._call(f"Haptic{function}", _INT, (_POINTER, self.haptic), (_INT, argument)))

    def _call(self, function: str, result: Any, *arguments: tuple[Any, Any]) -> Any:
        """Call a function with typed arguments. Raises `SdlError` on less than 0 and on null."""
        called: Callable[..., Any] = self._library[f"SDL_{function}"]
        called.argtypes = [kind for kind, _ in arguments]  # type: ignore[attr-defined]
        called.restype = result  # type: ignore[attr-defined]
        answer = called(*(value for _, value in arguments))
        if (result is _INT and answer < 0) or (result is _POINTER and not answer):
            self._library.SDL_GetError.restype = ctypes.c_char_p
            raise SdlError(f"{function}: {self._library.SDL_GetError().decode()}")
        return answer
