"""An arm in plane stress by finite elements (scikit-fem), with large displacements.

Quadratic quadrilaterals along the arm; strains are Green's, stresses of Piola and Kirchhoff.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from torsio_hardware.beams import Bent
from torsio_hardware.flexure import Flexure, rotation

POISSON = 0.38  # of PLA and PETG, 0.35 to 0.4; in slender arms of plane stress it hardly counts
_STEPS = 30
_SETTLED = 1e-7


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


def twist(
    flexure: Flexure,
    modulus_pa: float,
    twists_rad: Sequence[float],
    *,
    along: int = 80,
    across: int = 3,
) -> Bent:
    """Twist a flexure; twists grow from near 0. The strain is not told: corners have no bound.

    Raises `ArithmeticError` if the elements find no rest, `ModuleNotFoundError` without scikit-fem.
    """
    torques = [
        _turn_arm(flexure.grid(along, across, mirrored=side), modulus_pa, twists_rad)
        for side in flexure.sides
    ]
    total = flexure.arms * flexure.width_m * np.mean(torques, axis=0)
    twists = np.asarray(twists_rad, dtype=float)
    return Bent(twists, total, np.full(len(twists), np.nan))
