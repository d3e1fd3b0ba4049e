"""Bad calls of the C interface: NULL, wrong sizes, wrong values, and what is said of them."""

from __future__ import annotations

import ctypes
import re
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.c import layouts
from tests.c.calling import HEADER, N, made, said

RESULTS = [f for f in HEADER.functions.values() if f.result == "torsio_result"]


@pytest.mark.parametrize("function", RESULTS, ids=lambda function: function.name)
def test_null_everywhere_is_refused_with_a_sentence(
    lib: ctypes.CDLL, function: layouts.Function
) -> None:
    zeros: list[Any] = []
    for parameter in function.parameters:
        if "*" in parameter:
            zeros.append(None)
        elif parameter.startswith("double"):
            zeros.append(ctypes.c_double(0.0))
        elif parameter == "size_t item_size":
            zeros.append(ctypes.c_size_t(0))
        else:
            zeros.append(0)
    assert getattr(lib, function.name)(*zeros) == N["TORSIO_INVALID_ARGUMENT"]
    assert re.search(r"is NULL|item_size is 0", said(lib)), said(lib)


def test_functions_without_a_result_take_null(lib: ctypes.CDLL) -> None:
    for function in HEADER.functions.values():
        if function.result == "torsio_result" or not any("*" in p for p in function.parameters):
            continue
        nothing = getattr(lib, function.name)(*[None] * len(function.parameters))
        assert not nothing, function.name


SIZED = sorted(n for n, s in HEADER.structures.items() if s._fields_[0][0] == "struct_size")


def taking(name: str) -> Iterator[tuple[layouts.Function, int]]:
    """Give the functions that take a pointer to a structure, and at which place."""
    for function in RESULTS:
        for place, parameter in enumerate(function.parameters):
            if re.match(rf"(const )?{name} ?\*", parameter) and not function.name.endswith("_init"):
                yield function, place


@pytest.mark.parametrize("name", SIZED)
def test_structure_of_a_wrong_size_is_refused_and_unchanged(
    lib: ctypes.CDLL, knob: ctypes.c_void_p, scene: ctypes.c_void_p, name: str
) -> None:
    for function, place in taking(name):
        structure = HEADER.structures[name]()
        ctypes.memset(ctypes.byref(structure), 0x55, ctypes.sizeof(structure))
        before = bytes(structure)
        first = knob if function.parameters[0].startswith("torsio_knob") else scene
        arguments: list[Any] = [first, *[None] * (len(function.parameters) - 1)]
        handle = ctypes.c_void_p()
        if function.name == "torsio_knob_open":
            arguments = [b"emulated", None, ctypes.byref(handle)]
        if function.name == "torsio_knob_next_event":
            arguments[1] = ctypes.c_double(0.0)
        arguments[place] = ctypes.byref(structure)
        assert getattr(lib, function.name)(*arguments) == N["TORSIO_INVALID_ARGUMENT"]
        assert re.search(rf"struct_size is {0x55555555}, .*call {name}_init\(\)", said(lib))
        assert bytes(structure) == before
        assert handle.value is None


def _wall(lib: ctypes.CDLL, knob: Any, scene: Any, **fields: Any) -> int:
    wall = made(lib, "torsio_wall", **fields)
    added: int = lib.torsio_scene_add_wall(scene, ctypes.byref(wall))
    played: int = lib.torsio_knob_play(knob, scene)
    return added or played


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda lib, knob, scene: _wall(lib, knob, scene, side=2), r"side is 2, .*0 to 1"),
        (lambda lib, knob, scene: _wall(lib, knob, scene, side=256), r"side is 256, .*0 to 1"),
        (
            lambda lib, knob, scene: _wall(lib, knob, scene, stiffness_nm_per_rad=-1.0),
            r"stiffness_nm_per_rad .*-1",
        ),
        (
            lambda lib, knob, scene: _wall(lib, knob, scene, angle_rad=float("nan")),
            r"angle_rad",
        ),
        (
            lambda lib, knob, scene: lib.torsio_scene_add_curve(
                scene, ctypes.byref(made(lib, "torsio_curve", torque_nm_count=3))
            ),
            r"torque_nm is NULL, and torque_nm_count is 3",
        ),
        (
            lambda lib, knob, scene: lib.torsio_scene_add_curve(
                scene,
                ctypes.byref(made(lib, "torsio_curve", torque_nm=1, torque_nm_count=2**60)),
            ),
            r"torque_nm_count is \d+; at most",
        ),
        (
            lambda lib, knob, scene: lib.torsio_knob_wait_for(knob, 9, ctypes.c_double(0.0)),
            r"state is 9",
        ),
        (
            lambda lib, knob, scene: lib.torsio_knob_sleep(knob, ctypes.c_double(-1.0)),
            r"-1",
        ),
    ],
)
def test_bad_value_is_refused_by_name(
    lib: ctypes.CDLL,
    knob: ctypes.c_void_p,
    scene: ctypes.c_void_p,
    call: Callable[..., int],
    sentence: str,
) -> None:
    assert call(lib, knob, scene) == N["TORSIO_INVALID_ARGUMENT"]
    assert re.search(sentence, said(lib)), said(lib)


def test_array_of_wrong_items_is_refused(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    samples, count = (ctypes.c_uint8 * 640)(), ctypes.c_size_t(5)
    read = lib.torsio_knob_read
    tail = (ctypes.c_double(0.0), ctypes.byref(count))
    wrong = read(knob, samples, ctypes.c_size_t(8), ctypes.c_size_t(72), *tail)
    assert wrong == N["TORSIO_INVALID_ARGUMENT"]
    assert "item_size is 72, and this library's has 56 bytes" in said(lib)
    assert count.value == 5


def test_unknown_selector_is_not_found(lib: ctypes.CDLL) -> None:
    handle = ctypes.c_void_p(17)
    found = lib.torsio_knob_open(b"/dev/none", None, ctypes.byref(handle))
    assert found == N["TORSIO_DEVICE_NOT_FOUND"]
    assert "/dev/none" in said(lib)
    assert handle.value == 17  # left alone


def test_error_belongs_to_its_thread(lib: ctypes.CDLL) -> None:
    assert lib.torsio_scene_clear(None) == N["TORSIO_INVALID_ARGUMENT"]
    here, there = said(lib), []
    other = threading.Thread(target=lambda: there.append(said(lib)))
    other.start()
    other.join()
    assert "scene is NULL" in here
    assert there == [""]
