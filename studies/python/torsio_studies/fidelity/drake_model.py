"""The same plant in Drake, for the study `fidelity`, where Drake is installed.

Drake's joints have no dry friction. So either shaft carries a disc, and a pad presses on it with a
lever of 1 m and a coefficient of 1: its force is the friction's torque. What is known beforehand is
computed as for MuJoCo, and Drake's own loop runs from begin to end.
"""

from __future__ import annotations

import importlib
import time
from importlib.util import find_spec
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio.printed.plant import PlantParams
from torsio_studies.fidelity.mujoco_model import hand_force, lagged
from torsio_studies.fidelity.truth import HandTorque

Array = npt.NDArray[np.float64]
Choice = tuple[str, int, float | None]
"""Approximation of contact, step in us, and accuracy: None with a fixed step."""

_MASS_KG, _PAD_M, _APART_M = 1e-3, 0.01, 10.0
_NOTHING: Final = [0.0, 0.0, 0.0]
_LEAST_US: Final = {"Tamsi": 5, "Lagged": 20}


def choices(steps_us: tuple[int, ...]) -> list[Choice]:
    """Give what is tried, if Drake is installed."""
    if find_spec("pydrake") is None:
        return []
    fixed: list[Choice] = [
        (name, step, None) for name in _LEAST_US for step in steps_us if step >= _LEAST_US[name]
    ]
    # An integrator with error control, whose inputs are held for a step.
    return fixed + [("cenic", step, one) for step in (20, 100, 1000) for one in (1e-3, 1e-5, 1e-7)]


def _add_shaft(drake: Any, model: Any, name: str, inertia: float, damping: float) -> Any:
    """Add a shaft with its disc and the pad on it; give the shaft's joint."""
    world, height_m = model.world_body().body_frame(), _APART_M * (name == "brake")

    def body(of: str, kg_m2: float) -> Any:
        gyration = drake.UnitInertia(*[kg_m2 / _MASS_KG] * 3)
        return model.AddRigidBody(of, drake.SpatialInertia(_MASS_KG, _NOTHING, gyration))

    shaft, pad = body(name, inertia), body(f"{name} pad", _MASS_KG)
    turn = drake.RevoluteJoint(name, world, shaft.body_frame(), [0, 0, 1], damping=damping)
    slide = drake.PrismaticJoint(f"{name} pad", world, pad.body_frame(), [0, 0, 1])
    turn, slide = model.AddJoint(turn), model.AddJoint(slide)
    for joint in (turn, slide):
        model.AddJointActuator(joint.name(), joint)
    touching = drake.ProximityProperties()
    drake.AddContactMaterial(
        dissipation=0.0, point_stiffness=1e8, friction=drake.CoulombFriction(1.0, 1.0),
        properties=touching,
    )  # fmt: skip
    for owner, shape, place in (
        (shaft, drake.Box(4.0, 4.0, 1.0), [0.0, 0.0, height_m - 0.5]),
        (pad, drake.Sphere(_PAD_M), [1.0, 0.0, height_m + _PAD_M]),
    ):
        at = drake.RigidTransform(place)
        model.RegisterCollisionGeometry(owner, at, shape, owner.name(), touching)
    return turn


def simulate(
    plant: PlantParams,
    hand: HandTorque,
    motor_nm: Array,
    brake_nm: Array,
    *,
    period_s: float,
    choice: Choice,
) -> tuple[Array, float]:
    """Give angles of knob and brake at the periods' ends, shape (n, 2), and the CPU time.

    The angles are NaN if Drake gives up.

    The commands are of shape (n,), each held for `period_s`, which the step of `choice` divides.
    """
    drake = importlib.import_module("pydrake.all")
    contact, step_us, accuracy = choice
    step_s, is_fixed = step_us / 1e6, accuracy is None
    builder = drake.DiagramBuilder()
    model, _ = drake.AddMultibodyPlantSceneGraph(builder, step_s if is_fixed else 0.0)
    model.mutable_gravity_field().set_gravity_vector(_NOTHING)
    inertia = plant.knob_inertia_kg_m2 + hand.inertia_kg_m2
    damping = plant.knob_viscous_nm_s_per_rad + hand.damping_nm_s_per_rad
    knob = _add_shaft(drake, model, "knob", inertia, damping)
    inertia, damping = plant.brake_inertia_kg_m2, plant.brake_viscous_nm_s_per_rad
    brake = _add_shaft(drake, model, "brake", inertia, damping)
    model.AddForceElement(drake.RevoluteSpring(knob, 0.0, hand.stiffness_nm_per_rad))
    model.AddForceElement(
        drake.LinearBushingRollPitchYaw(
            brake.frame_on_child(), knob.frame_on_child(),
            [0.0, 0.0, plant.shaft_stiffness_nm_per_rad],
            [0.0, 0.0, plant.shaft_damping_nm_s_per_rad], _NOTHING, _NOTHING,
        )
    )  # fmt: skip
    if is_fixed:
        kind = getattr(drake.DiscreteContactApproximation, f"k{contact}")
        model.set_discrete_contact_approximation(kind)
    model.Finalize()
    steps, periods = round(period_s / step_s), len(motor_nm)
    begins = np.arange(periods * steps + 1) * step_s
    torque = lagged(motor_nm, plant.motor_time_constant_s, steps, step_s)
    torque += hand_force(hand, (begins[:-1] + 0.5 * step_s).astype(np.float64))
    drag = lagged(brake_nm, plant.brake_time_constant_s, steps, step_s) + plant.brake_drag_nm
    coulomb = np.full_like(torque, -plant.knob_coulomb_nm)
    held = np.array([torque, coulomb, np.zeros_like(torque), -drag])
    # A fixed step takes the value held at its begin. Half a step earlier leaves no doubt which.
    source = drake.PiecewisePolynomial.ZeroOrderHold(
        begins - 0.5 * step_s * is_fixed, np.hstack([held, held[:, -1:]])
    )
    log = builder.AddSystem(drake.VectorLogSink(model.num_multibody_states(), period_s))
    inputs = builder.AddSystem(drake.TrajectorySource(source))
    builder.Connect(inputs.get_output_port(), model.get_actuation_input_port())
    builder.Connect(model.get_state_output_port(), log.get_input_port())
    simulator = drake.Simulator(builder.Build())
    if not is_fixed:
        config = drake.SimulatorConfig(
            integration_scheme=contact, max_step_size=step_s, accuracy=accuracy
        )
        drake.ApplySimulatorConfig(config, simulator)
    simulator.Initialize()
    begin = time.thread_time()
    try:
        simulator.AdvanceTo((periods + 1e-6) * period_s)
    except RuntimeError:  # its solver has not converged
        return np.full((periods, 2), np.nan), time.thread_time() - begin
    cpu_s = time.thread_time() - begin
    angles = log.FindLog(simulator.get_context()).data()
    return angles[[knob.position_start(), brake.position_start()], 1 : periods + 1].T, cpu_s
