"""SDL 3 as games use it, through the library that the package tcod brings (SDL_haptic.h).

Effects have SDL 2's bytes, see `sdl`; some kinds have another number.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.vm.guest.sdl import SdlError

CONSTANT, SINE, SQUARE, TRIANGLE, SAW_UP, SAW_DOWN, RAMP = (1 << n for n in range(7))
SPRING, DAMPER, INERTIA, FRICTION, LEFT_RIGHT = (1 << n for n in range(7, 12))
GAIN = 1 << 16

# Where a force comes from: polar in hundredths of a degree from north, Cartesian to east and south.
_POLAR, _CARTESIAN, _STEERING_AXIS = 0, 1, 3
_JOYSTICK_AND_HAPTIC = 0x200 | 0x1000
_POINTER, _INT, _BOOL = ctypes.c_void_p, ctypes.c_int, ctypes.c_bool
_NUMBER = ctypes.c_uint32


def polar(degrees: float) -> bytes:
    """Return an SDL_HapticDirection, and so below."""
    return struct.pack("<B3x3i", _POLAR, round(100 * degrees), 0, 0)


def cartesian(x: int, y: int) -> bytes:
    return struct.pack("<B3x3i", _CARTESIAN, x, y, 0)


def steering_axis() -> bytes:
    return struct.pack("<B3x3i", _STEERING_AXIS, 0, 0, 0)


WEST = polar(270)


def turned(effect: bytes, direction: bytes) -> bytes:
    """Return an effect with another direction."""
    return effect[:4] + direction + effect[4 + len(direction) :]


def left_right(large: int, small: int, length_ms: int) -> bytes:
    return struct.pack("<H2xIHH", LEFT_RIGHT, length_ms, large, small)


def library_file() -> Path:
    """Return the library's file."""
    files = importlib.metadata.files("tcod") or []
    (found,) = [Path(str(file.locate())) for file in files if file.name.startswith("libSDL3")]
    return found


class Sdl3:
    """SDL without a window, and its first joystick with its forces."""

    def __init__(self) -> None:
        os.environ["SDL_VIDEO_DRIVER"] = "dummy"
        os.environ["SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS"] = "1"
        self._library = ctypes.CDLL(str(library_file()))
        self.call("Init", _BOOL, (_NUMBER, _JOYSTICK_AND_HAPTIC))
        count = ctypes.c_int()
        found = self.call("GetJoysticks", _POINTER, (_POINTER, ctypes.addressof(count)))
        first = ctypes.cast(found, ctypes.POINTER(_NUMBER))[0]
        assert count.value == 1
        self.joystick = self.call("OpenJoystick", _POINTER, (_NUMBER, first))
        self.haptic = self.call("OpenHapticFromJoystick", _POINTER, (_POINTER, self.joystick))

    def close(self) -> None:
        """End SDL, which stops all forces."""
        self.call("CloseHaptic", None, (_POINTER, self.haptic))
        self.call("CloseJoystick", None, (_POINTER, self.joystick))
        self.call("Quit", None)

    @property
    def version(self) -> tuple[int, int]:
        number = int(self.call("GetVersion", _INT))
        return number // 1_000_000, number // 1_000 % 1_000

    @property
    def name(self) -> str:
        return str(self.call("GetJoystickName", ctypes.c_char_p, self._joystick()).decode())

    @property
    def parts(self) -> tuple[int, int, int]:
        """Numbers of axes, of buttons, and of axes with forces."""
        return (
            int(self.call("GetNumJoystickAxes", _INT, self._joystick())),
            int(self.call("GetNumJoystickButtons", _INT, self._joystick())),
            int(self.call("GetNumHapticAxes", _INT, self._haptic())),
        )

    @property
    def can(self) -> int:
        """Bits of the device's abilities."""
        return int(self.call("GetHapticFeatures", _NUMBER, self._haptic()))

    @property
    def effects(self) -> int:
        """How many the device holds."""
        return int(self.call("GetMaxHapticEffects", _INT, self._haptic()))

    def axis(self) -> int:
        """Return where the first axis is now, -32768 to 32767."""
        self.call("UpdateJoysticks", None)
        return int(self.call("GetJoystickAxis", ctypes.c_int16, self._joystick(), (_INT, 0)))

    def set_gain(self, percent: int) -> None:
        self.call("SetHapticGain", _BOOL, self._haptic(), (_INT, percent))

    def new(self, effect: bytes) -> int:
        """Upload an effect and return its number."""
        return int(self.call("CreateHapticEffect", _INT, self._haptic(), _effect(effect)))

    def run(self, number: int, times: int = 1) -> None:
        self.call("RunHapticEffect", _BOOL, self._haptic(), (_INT, number), (_NUMBER, times))

    def update(self, number: int, effect: bytes) -> None:
        self.call("UpdateHapticEffect", _BOOL, self._haptic(), (_INT, number), _effect(effect))

    def stop(self, number: int) -> None:
        self.call("StopHapticEffect", _BOOL, self._haptic(), (_INT, number))

    def destroy(self, number: int) -> None:
        self.call("DestroyHapticEffect", None, self._haptic(), (_INT, number))

    def rumble(self, low: int, high: int, length_ms: int) -> None:
        """Shake the whole joystick, as gamepads do, without its haptic device."""
        strengths = [(ctypes.c_uint16, strength) for strength in (low, high)]
        self.call("RumbleJoystick", _BOOL, self._joystick(), *strengths, (_NUMBER, length_ms))

    def call(self, function: str, result: Any, *arguments: tuple[Any, Any]) -> Any:
        """Call a function with typed arguments.

        Raises `SdlError` on false, on less than 0, and on null.
        """
        called: Callable[..., Any] = self._library[f"SDL_{function}"]
        called.argtypes = [kind for kind, _ in arguments]  # type: ignore[attr-defined]
        called.restype = result  # type: ignore[attr-defined]
        answer = called(*(value for _, value in arguments))
        if (result is _INT and answer < 0) or (result in (_POINTER, _BOOL) and not answer):
            self._library.SDL_GetError.restype = ctypes.c_char_p
            raise SdlError(f"{function}: {self._library.SDL_GetError().decode()}")
        return answer

    def _joystick(self) -> tuple[Any, Any]:
        return _POINTER, self.joystick

    def _haptic(self) -> tuple[Any, Any]:
        return _POINTER, self.haptic


def _effect(effect: bytes) -> tuple[Any, bytes]:
    return ctypes.c_char_p, effect.ljust(128, b"\0")  # as large as the union of all kinds
