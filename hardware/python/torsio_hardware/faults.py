"""Twenty things that go wrong as one wires and screws: what each does to the emulated knob.

Three need a word. Swapped encoder wires are the device's own sign, turned round behind the maker's
back. A missing pull-down no firmware can see, so a meter has to: its reading is made up. A hub that
slips passes little of the brake's torque on, so it is a brake with a quarter of its torque.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from torsio.printed.plant import Belt, PlantParams

NOBODY = "neither: no firmware sees it"


@dataclass(frozen=True)
class Fault:
    """Something wrong with a knob."""

    name: str
    words: str  # the maker's mistake
    finding: str  # of first power's first step that shows it
    also: tuple[str, ...] = ()  # other findings that it may show itself by
    alone: str = ""  # of `torsio doctor`, or else `calibrate`, without the steps; empty: the same
    electrics: dict[str, float] = field(default_factory=dict)  # factors; True sets a switch
    plant: dict[str, Any] = field(default_factory=dict)  # values in place of the right ones
    softer: float = 1.0  # factor of the spring's stiffness
    happen: Callable[[Any], object] = lambda world: None  # to the world round the open knob
    pull_down_kohm: float = 4.3  # of the enable line: 4.7, beside 100 of each bridge
    reversed_encoder: bool = False  # A and B are swapped

    def __post_init__(self) -> None:
        """Let the step name it too, unless told otherwise."""
        object.__setattr__(self, "alone", self.alone or self.finding)

    def change(self, plant: PlantParams) -> PlantParams:
        """Build the fault into a knob."""
        parts: Any = plant.electrics
        electrics = {
            name: factor if factor is True else factor * getattr(parts, name)
            for name, factor in self.electrics.items()
        }
        stiffness = self.softer * plant.shaft_stiffness_nm_per_rad
        return replace(
            plant,
            electrics=replace(parts, **electrics),
            shaft_stiffness_nm_per_rad=stiffness,
            **self.plant,
        )


FAULTS = (
    Fault("motor_swapped", "the motor's two wires are swapped", "motor:backwards",
          electrics={"motor_reversed": True}, alone="calibrate:reversed"),
    Fault("encoder_swapped", "the encoder's A and B are swapped", "encoder:backwards",
          reversed_encoder=True, alone="calibrate:reversed"),
    Fault("encoder_off", "the encoder's cable is off, or has no supply", "encoder:still",
          happen=lambda world: world.freeze_encoder(frozen=True), alone="calibrate:still"),
    Fault("encoder_noisy", "the encoder's cable has no shield and lies by the motor's",
          "brake:volts", plant={"encoder_noise_counts": 4.0}, also=("calibrate:noisy",),
          alone="calibrate:noisy"),
    Fault("encoder_lines", "an encoder of 1,000 lines in place of 2,048", "encoder:counts",
          plant={"counts_per_rev": 4000}, alone="calibrate:winding"),
    Fault("stop_open", "the emergency stop's contact is not connected", "doctor:emergency_stop",
          happen=lambda world: world.set_emergency_stop(pressed=True)),
    Fault("bridge_fault", "the bridge's fault wire touches ground", "doctor:actuator",
          happen=lambda world: world.set_actuator_fault(present=True)),
    Fault("supply_24v", "a supply of 24 V in place of 12", "supply:volts",
          electrics={"supply_v": 2.0}, alone="doctor:supply"),
    Fault("supply_off", "the supply's fuse is blown", "supply:volts",
          electrics={"supply_v": 1e-3}, alone="doctor:supply"),
    Fault("pull_down_missing", "the pull-down of the enable line is missing", "link:pull_down",
          pull_down_kohm=50.0, alone=NOBODY),
    Fault("sensor_off", "the current sensor has no supply", "doctor:current_sensor",
          happen=lambda world: world.set_current_sensor("dead")),
    Fault("sensor_stuck", "the motor's current does not pass through the sensor",
          "motor:winding", happen=lambda world: world.set_current_sensor("stuck"),
          also=("calibrate:winding",), alone="calibrate:winding"),
    Fault("motor_contact", "a bad crimp in the motor's line, of 2 ohm", "calibrate:winding_values",
          electrics={"winding_resistance_ohm": 1.8}, also=("calibrate:winding", "confirm:winding")),
    Fault("brake_off", "the brake's coil is not connected", "calibrate:does_not_hold",
          electrics={"coil_resistance_ohm": 1e4}),
    Fault("brake_coil_24v", "a brake for 24 V, of four times the resistance",
          "calibrate:does_not_hold",
          electrics={"coil_resistance_ohm": 4.0, "coil_torque_constant_nm_per_a": 2.0}),
    Fault("brake_drags", "the brake is mounted askew and drags with 8 mN m", "calibrate:drag",
          plant={"brake_drag_nm": 8e-3}, also=("motor:still",)),
    Fault("belt_loose", "the belt is loose and stretches", "calibrate:shaft_soft",
          plant={"belt": Belt(stiffness_nm_per_rad=1.5)}),
    Fault("hub_slips", "the spring's hub slips on the shaft at 30 mN m", "calibrate:does_not_hold",
          electrics={"coil_torque_constant_nm_per_a": 0.25}),
    Fault("spring_soft", "the spring's walls are 0.08 mm too thin: 25 % softer",
          "calibrate:spring_off", softer=0.75, also=("calibrate:shaft_soft",)),
    Fault("knob_rubs", "the knob rubs on the frame with 40 mN m", "motor:still",
          plant={"knob_coulomb_nm": 40e-3}, also=("calibrate:drag",), alone="calibrate:drag"),
)  # fmt: skip


NONE = Fault("", "no fault", "")


def named(name: str) -> Fault:
    """Look a fault up; `NONE` of no name. Raises `ValueError` if there is none of that name."""
    known = {fault.name: fault for fault in FAULTS}
    if not name:
        return NONE
    if name not in known:
        raise ValueError(f"no fault {name!r}; known are {', '.join(known)}")
    return known[name]
