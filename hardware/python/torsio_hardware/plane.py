"""An arm in plane stress by finite elements (scikit-fem), with large displacements.

Quadratic quadrilaterals along the arm; strains are Green's, stresses of Piola and Kirchhoff.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from torsio_hardware.beams import Bent
from torsio_hardware.flexure import Flexure

POISSON = 0.38  # of PLA and PETG, 0.35 to 0.4; in slender arms of plane stress it hardly counts
_STEPS = 30
_SETTLED = 1e-7


def grid(flexure: Flexure, along: int, across: int, *, mirrored: bool = False) -> Any:
    """Give the nodes of an arm's grid, in m; shape (along + 1, across + 1, 2)."""
    line = flexure.centre_line(along + 1, mirrored=mirrored)
    # The ends are cut square to the arm, as a beam is clamped.
    fine = flexure.centre_line(20 * along + 1, mirrored=mirrored)
    slope = np.gradient(fine, axis=0)[::20]
    slope /= np.linalg.norm(slope, axis=1)[:, None]
    normal = np.stack([-slope[:, 1], slope[:, 0]], axis=1)
    share = np.linspace(-0.5, 0.5, across + 1) * flexure.thickness_m
    return line[:, None, :] + share[None, :, None] * normal[:, None, :]


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

    factor = modulus_pa / (1 - POISSON**2)
    one = np.eye(2)[:, :, None, None]

    def stress(strain: Any) -> Any:
        trace = strain[0, 0] + strain[1, 1]
        return factor * (POISSON * trace * one + (1 - POISSON) * strain)

    def symmetric(tensor: Any) -> Any:
        return 0.5 * (tensor + transpose(tensor))

    def gradients(w: Any) -> tuple[Any, Any]:
        slope = grad(w["now"])
        deformed = slope + one
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
        cosine, sine = np.cos(twist), np.sin(twist)
        goal = np.array([[cosine, -sine], [sine, cosine]]) @ places - places
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


def twist(
    flexure: Flexure,
    modulus_pa: float,
    twists_rad: Sequence[float],
    *,
    along: int = 80,
    across: int = 3,
) -> Bent:
    """Twist a flexure; twists grow from near 0. The strain is not told: corners have no bound.

    Raises
    ------
    ArithmeticError
        If the elements find no rest.
    ModuleNotFoundError
        Without scikit-fem.
    """
    sides = (False, True) if flexure.family == "meander" else (False,)
    torques = [
        _turn_arm(grid(flexure, along, across, mirrored=side), modulus_pa, twists_rad)
        for side in sides
    ]
    total = flexure.arms / len(sides) * flexure.width_m * np.sum(torques, axis=0)
    twists = np.asarray(twists_rad, dtype=float)
    return Bent(twists, total, np.full(len(twists), np.nan))
