"""An arm by finite elements of two programs, with large displacements.

scikit-fem: quadratic quadrilaterals in plane stress; strains are Green's, stresses of Piola and
Kirchhoff. CalculiX: bricks in three dimensions. With `thin` they are a film on a plane, with a free
face: plane stress. Free of the plane, a film buckles. Otherwise they have the arm's true width and
are held at both ends as by hub and rim: a plate, a little stiffer.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from torsio_hardware.flexure import Flexure, rotation

POISSON = 0.38  # of PLA and PETG, 0.35 to 0.4; in slender arms of plane stress it hardly counts
_STEPS = 30
_SETTLED = 1e-7
_MM = 1e3  # the deck is in mm, N and MPa
# Of a quadratic brick: corners, then the middles of its edges, as steps of (along, across, up).
_BRICK = (
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1),
)  # fmt: skip


def _mesh(nodes: Any) -> Any:
    from skfem import MeshQuad

    along, across, _ = nodes.shape
    mesh = MeshQuad.init_tensor(np.arange(along), np.arange(across)).with_boundaries(
        {"hub": lambda x: x[0] == 0, "rim": lambda x: x[0] == along - 1}
    )
    return replace(mesh, doflocs=nodes[tuple(mesh.p.astype(int))].T)


def _forms(modulus_pa: float) -> tuple[Any, Any]:
    """Give the change of the inner forces, and these forces, a metre of width each."""
    from skfem import BilinearForm, LinearForm
    from skfem.helpers import ddot, grad, mul, transpose
    from skfem.models.elasticity import linear_stress

    factor, one = modulus_pa / (1 - POISSON**2), np.eye(2)[:, :, None, None]
    stress = linear_stress(POISSON * factor, 0.5 * (1 - POISSON) * factor)  # in a plane

    def symmetric(tensor: Any) -> Any:
        return 0.5 * (tensor + transpose(tensor))

    def gradients(w: Any) -> tuple[Any, Any]:
        deformed = grad(w["now"]) + one
        return deformed, stress(0.5 * (mul(transpose(deformed), deformed) - one))

    @BilinearForm  # type: ignore[untyped-decorator]
    def change(u: Any, v: Any, w: Any) -> Any:
        deformed, stressed = gradients(w)
        strain = symmetric(mul(transpose(deformed), grad(u)))
        virtual = symmetric(mul(transpose(deformed), grad(v)))
        return ddot(stress(strain), virtual) + ddot(mul(grad(u), stressed), grad(v))

    @LinearForm  # type: ignore[untyped-decorator]
    def force(v: Any, w: Any) -> Any:
        deformed, stressed = gradients(w)
        return ddot(mul(deformed, stressed), grad(v))

    return change, force


def _turn_arm(nodes: Any, modulus_pa: float, twists: Sequence[float]) -> list[float]:
    """Clamp the inner end, turn the outer about the centre; give the torque a metre of width."""
    from skfem import Basis, ElementQuad2, ElementVector, condense, solve

    mesh = _mesh(nodes)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=4)
    change, force = _forms(modulus_pa)
    hub, rim = basis.get_dofs("hub"), basis.get_dofs("rim")
    x_dofs, y_dofs = (rim.all([f"u^{axis}"]) for axis in (1, 2))
    places = basis.doflocs[:, x_dofs]
    assert np.allclose(places, basis.doflocs[:, y_dofs])
    held = np.concatenate([hub.all(), rim.all()])
    now, torques = np.zeros(basis.N), []
    for twist in twists:
        goal = rotation(twist) @ places - places
        for attempt in range(_STEPS):
            step = np.zeros(basis.N)
            if not attempt:
                step[x_dofs], step[y_dofs] = goal[0] - now[x_dofs], goal[1] - now[y_dofs]
            fields = {"now": basis.interpolate(now)}
            inner = force.assemble(basis, **fields)
            free = np.delete(inner, held)
            if attempt and np.abs(free).max() < _SETTLED * np.abs(inner).max():
                break
            system = condense(change.assemble(basis, **fields), -inner, x=step, D=held)
            now += solve(*system)
        else:
            raise ArithmeticError(f"the elements find no rest at a twist of {twist:g} rad")
        x, y = places + goal
        torques.append(float(np.sum(x * inner[y_dofs] - y * inner[x_dofs])))
    return torques


def scikit_fem(
    flexure: Flexure,
    modulus_pa: float,
    twists_rad: Sequence[float],
    *,
    along: int = 80,
    across: int = 3,
) -> Any:
    """Give a flexure's secant stiffness in N m/rad at twists that grow from near 0.

    Raises `ArithmeticError` if the elements find no rest, `ModuleNotFoundError` without scikit-fem.
    """
    torques = [
        _turn_arm(flexure.grid(along, across, mirrored=side), modulus_pa, twists_rad)
        for side in flexure.sides
    ]
    return flexure.arms * flexure.width_m * np.mean(torques, axis=0) / np.asarray(twists_rad)


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
    used = np.unique(bricks).tolist()
    numbers = np.arange(np.prod(shape)).reshape(shape)
    hub, rim = (np.intersect1d(numbers[end], used).tolist() for end in (0, -1))
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{n + 1}, {x[n]:.9e}, {y[n]:.9e}, {z[n]:.9e}" for n in used]
    lines += _arm(bricks, {"HUB": hub, "RIM": rim})
    lines += [
        *("*MATERIAL, NAME=PLASTIC", "*ELASTIC", f"{modulus_pa / 1e6:.9e}, {POISSON}"),
        *("*SOLID SECTION, ELSET=ARM, MATERIAL=PLASTIC", "*BOUNDARY", "HUB, 1, 2"),
    ]
    lower = [f"{n + 1}, 3" for n in used if z[n] == height[0]]
    lines += lower if thin else ["HUB, 3", "RIM, 3"]
    before = {n + 1: np.array((x[n], y[n])) for n in rim}
    places = _turned(before, twists)
    lines += [line for turned in places for line in _step(before, turned)]
    return "\n".join(lines) + "\n", places


def _turned(places: dict[int, Any], twists: Sequence[float]) -> list[dict[int, Any]]:
    return [{n: rotation(twist) @ place for n, place in places.items()} for twist in twists]


def _arm(bricks: list[list[int]], sets: dict[str, list[int]]) -> list[str]:
    """Give the elements, and sets of nodes by name."""
    lines = ["*ELEMENT, TYPE=C3D20R, ELSET=ARM"]
    for number, brick in enumerate(bricks, 1):
        words = [str(number), *(str(n + 1) for n in brick)]
        lines += [", ".join(words[:16]) + ",", ", ".join(words[16:])]
    for name, nodes in sets.items():
        lines += [f"*NSET, NSET={name}", *(f"{n + 1}," for n in nodes)]
    return lines


def _step(before: dict[int, Any], turned: dict[int, Any]) -> list[str]:
    """Move nodes to where they are when turned, and print the forces there."""
    lines = ["*STEP, NLGEOM, INC=200", "*STATIC", "0.5, 1.0, 1e-4, 1.0", "*BOUNDARY"]
    for n, place in turned.items():
        far, high = place - before[n]
        lines += [f"{n}, 1, 1, {far:.12e}", f"{n}, 2, 2, {high:.12e}"]
    return [*lines, "*NODE PRINT, NSET=RIM, FREQUENCY=200", "RF", "*END STEP"]


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

    Raises `RuntimeError` if the command is missing, or its output has an error; its status has not.
    """
    program = shutil.which("ccx")
    if program is None:
        raise RuntimeError("the command ccx is missing: install the Debian package calculix-ccx")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "arm.inp").write_text(deck, encoding="ascii")
        done = subprocess.run(
            [program, "arm"], cwd=folder, capture_output=True, text=True, check=False
        )
        said = done.stdout + done.stderr
        errors = re.findall(r"\*ERROR.*(?:\n.*)?", said)
        if errors or done.returncode or "Job finished" not in said:
            raise RuntimeError("CalculiX: " + " ".join((errors or [said[-400:]])[0].split()))
        return (Path(folder) / "arm.dat").read_text(encoding="ascii")


def calculix(
    flexure: Flexure,
    modulus_pa: float,
    twists_rad: Sequence[float],
    *,
    along: int = 60,
    across: int = 2,
    thin: bool = True,
) -> Any:
    """Give a flexure's secant stiffness in N m/rad; see the module for `thin`.

    Raises `RuntimeError` as `run`.
    """
    width_mm = _MM * (0.1 * flexure.thickness_m if thin else flexure.width_m)
    torques = []
    for side in flexure.sides:
        flat = flexure.grid(2 * along, 2 * across, mirrored=side)
        deck, places = _deck(flat, width_mm, modulus_pa, twists_rad, 1 if thin else 4, thin)
        tables = _forces(run(deck))
        if len(tables) != len(twists_rad):
            raise RuntimeError(f"CalculiX told of {len(tables)} steps, not {len(twists_rad)}")
        torques.append(
            [
                sum(place[n][0] * fy - place[n][1] * fx for n, (fx, fy) in table.items())
                for table, place in zip(tables, places, strict=True)
            ]
        )
    # In N mm, of an arm of this width.
    total = flexure.arms * np.mean(torques, axis=0) * flexure.width_m / width_mm
    return total / np.asarray(twists_rad)
