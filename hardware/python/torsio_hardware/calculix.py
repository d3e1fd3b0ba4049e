"""The same arm by CalculiX in three dimensions: a second opinion by another program.

With `thin` the arm is a film with free faces: plane stress. Otherwise it has its true width and is
held at both ends as by hub and rim: a plate, a little stiffer.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from torsio_hardware.beams import Bent
from torsio_hardware.flexure import Flexure, rotation
from torsio_hardware.plane import POISSON

_MM = 1e3  # the deck is in mm, N and MPa
# Of a quadratic brick: corners, then the middles of its edges, as steps of (along, across, up).
_BRICK = (
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1),
)  # fmt: skip


class Failed(RuntimeError):
    """CalculiX is missing, or says that it did not solve."""


def _bricks(shape: tuple[int, int, int]) -> list[list[int]]:
    """Give the 20 grid points of each brick, as flat indices into the grid."""
    corners = np.stack(np.meshgrid(*(np.arange(0, n - 2, 2) for n in shape), indexing="ij"), -1)
    points = corners.reshape(-1, 1, 3) + np.array(_BRICK)
    bricks: list[list[int]] = np.ravel_multi_index(
        tuple(np.moveaxis(points, -1, 0)), shape
    ).tolist()
    return bricks


def _deck(
    flat: Any, width_mm: float, modulus_pa: float, twists: Sequence[float], up: int, thin: bool
) -> tuple[str, Any]:
    """Write the input; also give the rim's nodes by number, and where they are."""
    height = np.linspace(0.0, width_mm, 2 * up + 1)
    shape = (*flat.shape[:2], len(height))
    x, y, z = (
        np.broadcast_to(part, shape).reshape(-1)
        for part in (_MM * flat[:, :, 0, None], _MM * flat[:, :, 1, None], height)
    )
    bricks = _bricks(shape)
    used = {node for brick in bricks for node in brick}
    numbers = np.arange(np.prod(shape)).reshape(shape)
    hub, rim = ([n for n in numbers[end].ravel().tolist() if n in used] for end in (0, -1))
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{n + 1}, {x[n]:.9e}, {y[n]:.9e}, {z[n]:.9e}" for n in sorted(used)]
    lines += ["*ELEMENT, TYPE=C3D20R, ELSET=ARM"]
    for number, brick in enumerate(bricks, 1):
        words = [str(number), *(str(n + 1) for n in brick)]
        lines += [", ".join(words[:16]) + ",", ", ".join(words[16:])]
    for name, nodes in (("HUB", hub), ("RIM", rim)):
        lines += [f"*NSET, NSET={name}", *(f"{n + 1}," for n in nodes)]
    lines += [
        *("*MATERIAL, NAME=PLASTIC", "*ELASTIC", f"{modulus_pa / 1e6:.9e}, {POISSON}"),
        *("*SOLID SECTION, ELSET=ARM, MATERIAL=PLASTIC", "*BOUNDARY", "HUB, 1, 2"),
    ]
    middle = [n for n in hub if z[n] == height[0]]
    lines += [f"{n + 1}, 3" for n in middle] if thin else ["HUB, 3", "RIM, 3"]
    places = []
    for twist in twists:
        lines += ["*STEP, NLGEOM, INC=200", "*STATIC", "0.5, 1.0, 1e-4, 1.0", "*BOUNDARY"]
        turned = {n: rotation(twist) @ (x[n], y[n]) for n in rim}
        for n, (far, high) in turned.items():
            lines += [f"{n + 1}, 1, 1, {far - x[n]:.12e}", f"{n + 1}, 2, 2, {high - y[n]:.12e}"]
        lines += ["*NODE PRINT, NSET=RIM, FREQUENCY=200", "RF", "*END STEP"]
        places.append({n + 1: place for n, place in turned.items()})
    return "\n".join(lines) + "\n", places


def _forces(text: str) -> list[dict[int, tuple[float, float]]]:
    """Read the forces at the rim's nodes, a table for each step."""
    tables: list[dict[int, tuple[float, float]]] = []
    for line in text.splitlines():
        if line.strip().startswith("forces"):
            tables.append({})
        elif tables and (words := line.split()) and len(words) == 4:
            tables[-1][int(words[0])] = (float(words[1]), float(words[2]))
    return tables


def run(deck: str) -> str:
    """Solve a deck; give what it printed into its table file.

    Raises `Failed` if the command is missing, or its output has an error: its exit status is 0
    then too.
    """
    program = shutil.which("ccx")
    if program is None:
        raise Failed("the command ccx is missing: install the Debian package calculix-ccx")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "arm.inp").write_text(deck, encoding="ascii")
        done = subprocess.run(
            [program, "arm"], cwd=folder, capture_output=True, text=True, check=False
        )
        said = done.stdout + done.stderr
        errors = re.findall(r"\*ERROR.*(?:\n.*)?", said)
        if errors or done.returncode or "Job finished" not in said:
            raise Failed("CalculiX: " + " ".join((errors or [said[-400:]])[0].split()))
        return (Path(folder) / "arm.dat").read_text(encoding="ascii")


def twist(
    flexure: Flexure,
    modulus_pa: float,
    twists_rad: Sequence[float],
    *,
    along: int = 60,
    across: int = 2,
    thin: bool = True,
) -> Bent:
    """Twist a flexure; see the module for `thin`. Raises `Failed` as `run`."""
    width_mm = _MM * (0.1 * flexure.thickness_m if thin else flexure.width_m)
    up = 1 if thin else 4
    total = np.zeros(len(twists_rad))
    for side in flexure.sides:
        flat = flexure.grid(2 * along, 2 * across, mirrored=side)
        deck, places = _deck(flat, width_mm, modulus_pa, twists_rad, up, thin)
        tables = _forces(run(deck))
        if len(tables) != len(twists_rad):
            raise Failed(f"CalculiX told of {len(tables)} steps in place of {len(twists_rad)}")
        for step, (table, place) in enumerate(zip(tables, places, strict=True)):
            torque = sum(place[n][0] * fy - place[n][1] * fx for n, (fx, fy) in table.items())
            total[step] += flexure.arms / len(flexure.sides) * torque / _MM
    total *= _MM * flexure.width_m / width_mm
    return Bent(np.asarray(twists_rad, dtype=float), total, np.full(len(total), np.nan))
