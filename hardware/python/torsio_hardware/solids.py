"""The printed parts of the reference knob as solids, by build123d; lengths in mm here.

The axis of motor and knob is z; z = 0 is the top of the plate. The brake stands beside the motor,
and a belt joins both pulleys. Motor and brake hang below the plate in clamps of their diameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from build123d import (
    Box,
    Circle,
    Cylinder,
    GeomType,
    GridLocations,
    PolarLocations,
    Polyline,
    Pos,
    Rot,
    SlotCenterToCenter,
    extrude,
    make_face,
)

from torsio_hardware.flexure import Flexure
from torsio_hardware.layout import (
    BELT_MM,
    BORE_MM,
    CENTRES_MM,
    LAND_MM,
    RIM_MM,
    SCREWS_MM,
    SLEEVE_MM,
    TEETH,
)

_INTO_M = 0.3e-3  # so far an arm reaches into hub and rim, so that they are one
_PLATE = (196.0, 90.0, 6.0)
_LEG_MM, _LEG_HEIGHT_MM = 14.0, 95.0
_SPRING_Z, _DRUM_Z, _TEETH_MM = 16.0, 3.0, 8.0
_BEARING = (19.0, 5.0)  # outside and width of a 61800
# A wall as heavy as the reference knob: a light knob swings in walls that are not even stiff.
_KNOB_MM, _KNOB_HEIGHT_MM, _WALL_MM = 74.6, 24.0, 6.7
_FIT_MM = 0.15  # between what turns and what stands, and for press fits the other way
# Of a groove for a tooth GT2: half its width at each depth, from the land to the ground.
_GROOVE = ((0.75, 0.0), (0.6, 0.13), (0.55, 0.34), (0.45, 0.54), (0.25, 0.71), (0.0, 0.764))
_STOP_MM = 41.9  # from the axis to the end stop's middle
_SLACK_MM = 3.0  # the way of the brake along the plate, to tighten the belt


def _hole(radius: float, height: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return Pos(x, y, z + height / 2) * Cylinder(radius, height)


def spring(flexure: Flexure, points: int = 60) -> Any:
    """Give the spring as one solid, its lower face at z = 0; arms of so many straight pieces."""
    flat: Any = Circle(RIM_MM) - Circle(1e3 * flexure.rim_radius_m)
    flat += Circle(1e3 * flexure.hub_radius_m)
    for edge in flexure.outlines(points, _INTO_M):
        flat += make_face(Polyline(*map(tuple, 1e3 * edge), close=True))
    flat -= Circle(BORE_MM + 2.0)  # sits on the sleeve's neck
    flat -= [Pos(x, y) * Circle(radius) for radius, x, y in SCREWS_MM]
    return extrude(flat, 1e3 * flexure.width_m)


def _sleeve(spring_height: float) -> Any:
    """From the motor's shaft up to the knob; the spring's hub is clamped on its neck."""
    top = _SPRING_Z + spring_height
    body = _hole(SLEEVE_MM, _SPRING_Z - 1.0, z=1.0)
    body += _hole(BORE_MM + 2.0 - _FIT_MM / 2, spring_height + 8.0, z=_SPRING_Z)
    body -= _hole(BORE_MM, top + 8.0)
    return body - Pos(0, 0, top + 5) * Rot(0, 90, 0) * Cylinder(1.25, 20)


def _toothed(height: float) -> Any:
    """Give a pulley of the belt, its lower face at z = 0."""
    half = [(LAND_MM - depth, side) for side, depth in _GROOVE]
    other = [(x, -y) for x, y in reversed(half[:-1])]
    # The mouth begins a little outside, so that nothing is left of the land there.
    edge = [(LAND_MM + 0.2, _GROOVE[0][0]), *half, *other, (LAND_MM + 0.2, -_GROOVE[0][0])]
    groove = make_face(Polyline(*edge, close=True))
    grooves = [Rot(0, 0, 360 * n / TEETH) * groove for n in range(TEETH)]
    return extrude(Circle(LAND_MM) - grooves, height)


def _drum() -> Any:
    """Pulley of the spring: teeth below, bearings inside, a flange for the spring's rim above.

    It is printed on its flange.
    """
    flange_z = _SPRING_Z - 3.0
    body = Pos(0, 0, _DRUM_Z) * _toothed(flange_z - _DRUM_Z)
    body += _hole(RIM_MM, 3.0, z=flange_z)
    body -= _hole(_BEARING[0] / 2, _SPRING_Z, z=_DRUM_Z)
    return body - [_hole(radius - 0.2, 4.0, x, y, flange_z) for radius, x, y in SCREWS_MM]


def _brake_pulley(bore: float) -> Any:
    """Give a pulley whose flange keeps the belt from below; the drum's keeps it from above."""
    body = Pos(0, 0, _DRUM_Z) * _toothed(_TEETH_MM + 4.0)
    body += _hole(LAND_MM + 2.0, 1.0, z=_DRUM_Z - 1.0)
    body -= _hole(bore / 2, 30.0)
    return body - Pos(0, 0, _DRUM_Z + _TEETH_MM + 2) * Rot(0, 90, 0) * Cylinder(1.25, 60)


def _knob(spring_height: float) -> Any:
    """Give a cup over the spring, with a hub for the sleeve and a tab for the end stop."""
    bottom = _SPRING_Z - 2.0
    body = _hole(_KNOB_MM / 2, _KNOB_HEIGHT_MM, z=bottom)
    body -= _hole(_KNOB_MM / 2 - _WALL_MM, _KNOB_HEIGHT_MM - 3.0, z=bottom)
    hub_z = _SPRING_Z + spring_height + 1.0
    body += _hole(9.0, bottom + _KNOB_HEIGHT_MM - hub_z, z=hub_z)
    body -= _hole(BORE_MM + 2.0 + _FIT_MM / 2, 8.0, z=hub_z - 0.5)
    body += Pos(_KNOB_MM / 2 + 1.5, 0, bottom + 4) * Box(5, 5, 8)
    # A key reaches the hub's set screw through the wall.
    return body - Pos(0, 0, hub_z + 4) * Rot(0, 90, 0) * Cylinder(1.25, 80)


def _plate(motor_mm: float, brake_mm: float) -> Any:
    length, width, thick = _PLATE
    body: Any = Pos(CENTRES_MM / 2, 0, -thick / 2) * Box(length, width, thick)
    body -= _hole(11.0, thick, z=-thick)
    body -= _hole(13.0, thick, CENTRES_MM, 0, -thick)
    screw = _hole(1.7, thick, z=-thick)
    body -= [*(_legs() * screw), *(_ears(motor_mm) * screw), Pos(-_STOP_MM, 0) * screw]
    # The ears stand askew, and all slots lie along the plate.
    slot = extrude(SlotCenterToCenter(2 * _SLACK_MM, 3.4), thick)
    return body - [
        Pos(CENTRES_MM, 0, -thick) * Pos(*ear.position) * slot for ear in _ears(brake_mm)
    ]


def _stop() -> Any:
    """Give the end stop: a post that a screw from below holds, taken off to calibrate."""
    return Pos(-_STOP_MM, 0, 11) * Box(8, 12, 22) - _hole(1.3, 14.0, -_STOP_MM)


def _legs() -> Any:
    length, width, _ = _PLATE
    return Pos(CENTRES_MM / 2, 0) * GridLocations(length - 18, width - 18, 2, 2)


def _ears(diameter: float) -> Any:
    return PolarLocations(diameter / 2 + 11.0, 4, 45)


def _clamp(diameter: float) -> Any:
    """Give a split ring round a motor's or brake's body, with ears; its top is z = 0."""
    body = _hole(diameter / 2 + 6.0, 22.0, z=-22.0)
    body += _ears(diameter) * _hole(6.0, 6.0, z=-6.0)
    body += _ears(diameter) * (Pos(-4.0, 0, -3.0) * Box(8.0, 10.0, 6.0))
    body += Pos(diameter / 2 + 8, 0, -14) * Box(10, 12, 12)
    body -= _hole(diameter / 2 + _FIT_MM / 2, 22.0, z=-22.0)
    body -= Pos(diameter / 2 + 8, 0, -11) * Box(24, 2, 22)
    body -= Pos(diameter / 2 + 9, 0, -14) * Rot(90, 0, 0) * Cylinder(1.7, 40)
    return body - _ears(diameter) * _hole(1.7, 8.0, z=-7.0)


@dataclass(frozen=True)
class Placed:
    """A part at its place."""

    name: str
    solid: Any  # where it is when all is screwed
    is_printed: bool  # False: an envelope of what is bought
    lift_mm: float  # so far the exploded picture lifts it
    step: int  # of the assembly, in which it comes
    print_turn: float = 0.0  # degrees about x by which it lies on the printer's bed


def assembly(
    flexure: Flexure, motor_mm: float = 30.0, brake_mm: float = 47.0, *, points: int = 60
) -> list[Placed]:
    """Give all parts at their places, for a motor and a brake of these diameters."""
    height = 1e3 * flexure.width_m
    under = -_PLATE[2]
    bearings = [
        _hole(_BEARING[0] / 2, _BEARING[1], z=z) - _hole(SLEEVE_MM, _BEARING[1], z=z)
        for z in (_DRUM_Z, _SPRING_Z - 3.0 - 2.0)
    ]
    motor = _hole(motor_mm / 2, 68.0, z=under - 68.0) + _hole(BORE_MM, 15.7, z=under)
    brake = Pos(CENTRES_MM, 0, 0) * (
        _hole(brake_mm / 2, 38.0, z=under - 38.0) + _hole(3.0, 22.0, z=under)
    )
    found = [
        Placed("plate", _plate(motor_mm, brake_mm), True, 0.0, 1),
        Placed("motor clamp", Pos(0, 0, under) * _clamp(motor_mm), True, -60.0, 2, 180.0),
        Placed("motor", motor, False, -110.0, 2),
        Placed("encoder", _hole(14.0, 10.0, z=under - 78.5), False, -135.0, 2),
        Placed("brake clamp", Pos(CENTRES_MM, 0, under) * _clamp(brake_mm), True, -60.0, 3, 180.0),
        Placed("brake", brake, False, -110.0, 3),
        Placed("sleeve", _sleeve(height), True, 30.0, 4),
        *(Placed(f"bearing {n + 1}", of, False, 65.0 + 12 * n, 5) for n, of in enumerate(bearings)),
        Placed("drum", _drum(), True, 130.0, 5, 180.0),
        Placed("spring", Pos(0, 0, _SPRING_Z) * spring(flexure, points), True, 165.0, 6),
        Placed("brake pulley", Pos(CENTRES_MM, 0, 0) * _brake_pulley(6.0), True, 60.0, 7),
        Placed("belt", _belt(), False, 100.0, 7),
        Placed("knob", _knob(height), True, 215.0, 8, 180.0),
        Placed("end stop", _stop(), True, 30.0, 9),
    ]
    leg = _hole(_LEG_MM / 2, _LEG_HEIGHT_MM, z=under - _LEG_HEIGHT_MM)
    leg -= _hole(1.3, 14.0, z=under - 14.0)
    legs = enumerate(_legs() * leg, 1)
    return found + [Placed(f"leg {n}", placed, True, -40.0, 1) for n, placed in legs]


def _belt() -> Any:
    """Give a band round both pulleys."""
    inside, outside = (SlotCenterToCenter(CENTRES_MM, 2 * (LAND_MM + of)) for of in (0.0, BELT_MM))
    return Pos(CENTRES_MM / 2, 0, _DRUM_Z + 1.0) * extrude(outside - inside, 6.0)


def printed(placed: Placed) -> Any:
    """Turn a part as it lies on the printer's bed, its lowest point at z = 0."""
    turned = Rot(placed.print_turn, 0, 0) * placed.solid
    return Pos(0, 0, -turned.bounding_box().min.Z) * turned


def overhang_mm2(body: Any) -> float:
    """Return the area of flat faces that hang in the air, the bed's aside: they need support."""
    flat = [face for face in body.faces() if face.geom_type == GeomType.PLANE]
    hanging = (face for face in flat if face.normal_at().Z < -0.75 and face.center().Z > 0.05)
    return float(sum(face.area for face in hanging))
