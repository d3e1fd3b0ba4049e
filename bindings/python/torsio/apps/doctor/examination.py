"""Findings of `torsio doctor` about an open knob: a function for each matter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict

import torsio
from torsio.apps.doctor.facts import KnobFacts
from torsio.apps.doctor.findings import Finding
from torsio.calibration.free import FREE_LIMIT_RAD_S
from torsio.common.emulated import moves_parts
from torsio.printed.statuses import FAULT_ADVICE
from torsio.printed.told import Limits

__all__ = ["KNOB_CHECKS", "limits_text", "missing"]

# Crystals are good to 100 ppm; twice that is no crystal's error any more.
_DRIFT_LIMIT_PPM = 200.0
# USB takes 1 to 3 ms for a command and its answer.
_SLOW_ROUND_TRIP_S = 10e-3
# Fewer may come from a hand that turns the knob in many scenes (`./dev bench beliefs`).
UNEXPECTED_SWINGS = 6

_HOW_TO_CONFIRM = (
    "set the values of motor, brake and encoder (docs/how-to/first-power.md), then "
    "`torsio config set confirmed=on`, and `torsio calibrate`; or set values_are=stated if you are "
    "sure of the values"
)
_HOW_TO_LIMIT = (
    f"`torsio config set speed_limit_rad_s={FREE_LIMIT_RAD_S:g}`, as `torsio calibrate` needs it: "
    "without a limit nothing stops a knob that runs away"
)

_ON_BUSY_COMPUTER = "; an emulated knob is late where the computer is busy"

_FAULTS_FOUND = {
    "emergency_stop": "the emergency stop is pressed or not connected",
    "over_speed": "the knob turned faster than its limit",
    "encoder": (
        "the encoder's count jumped too far, one of its channels is dead, or both changed at once, "
        "as with a loose plug"
    ),
    "actuator": "the power stage reported an error",
    "current_sensor": (
        "the motor's current sensor does not rest where it can see enough to either side"
    ),
    "winding": "the motor's voltage, its current and the knob's speed did not fit together",
    "temperature": "the motor's winding or the brake's coil got too hot, by the currents they had",
    "supply": "the supply's voltage is not the configured one, as the board measures it",
    "overrun": "ticks were missed, or took nearly the whole control period",
    "numeric": "the control law gave a torque that is not finite",
}


def check_firmware(facts: KnobFacts) -> Finding:
    """Name board and firmware. `open` refuses firmware that this library does not drive."""
    info = facts.info
    return Finding(
        "firmware",
        True,
        f"board {info.board}, firmware {info.firmware_version}, protocol {info.protocol_version} "
        f"(fingerprint 0x{info.fingerprint:08x}); the library is torsio {torsio.__version__}",
        values={
            "board": info.board,
            "firmware_version": info.firmware_version,
            "protocol_version": info.protocol_version,
            "fingerprint": info.fingerprint,
            "library_version": torsio.__version__,
        },
    )


def check_state(facts: KnobFacts) -> Finding:
    """Look for faults."""
    health = facts.after
    values = {"state": health.state, "faults": list(health.faults)}
    if health.state != "fault":
        return Finding("state", True, f"the knob is {health.state}, without a fault", values=values)
    unknown = "a fault that this library does not know"
    found = [_FAULTS_FOUND.get(fault, unknown) for fault in health.faults]
    advice = [FAULT_ADVICE.get(fault, "update the library") for fault in health.faults]
    return Finding(
        "state",
        False,
        "the knob gives no torque: " + "; ".join(found),
        "; ".join(advice) + " (knob.clear_fault())",
        values,
        tuple(fault for fault in health.faults if fault in FAULT_ADVICE),
    )


_RESTARTS = {
    "brown_out": ("its supply was too low for a moment", "use another cable, port or supply"),
    "watchdog": ("its program hung", "report it, with what it was doing"),
    "hard_fault": ("its program failed", "report it, with what it was doing"),
    "stack": ("its program ran out of stack", "report it, with what it was doing"),
}


def check_start(facts: KnobFacts) -> Finding:
    """Look at why the board started."""
    cause = facts.after.reset_cause
    values = {"reset_cause": cause}
    if cause not in _RESTARTS:
        return Finding("start", True, "the board started as it should", values=values)
    text, advice = _RESTARTS[cause]
    return Finding("start", False, f"the board has started anew because {text}", advice, values)


def limits_text(limits: Limits) -> str:
    """Say what a knob gives at most."""
    speed = f"{limits.speed_limit_rad_s:g} rad/s" if limits.speed_limit_rad_s else "any speed"
    motor = f"{1e3 * limits.motor_torque_max_nm:.3g} mN m"
    if limits.motor_torque_continuous_max_nm < limits.motor_torque_max_nm:
        motor += f" ({1e3 * limits.motor_torque_continuous_max_nm:.3g} continuously)"
    return f"motor {motor}, brake {1e3 * limits.brake_torque_max_nm:.3g} mN m, {speed}"


def missing(board: str, limits: Limits) -> tuple[str, str] | None:
    """Say what a knob still lacks and what to do about it; None: nothing."""
    if limits.held_low:
        return (
            "nobody has confirmed the parts of this board, or their values are assumed, so it "
            "gives little"
        ), _HOW_TO_CONFIRM
    if moves_parts(board) and limits.speed_limit_rad_s == 0:
        return "this board has no speed limit", _HOW_TO_LIMIT
    return None


def check_parts(facts: KnobFacts) -> Finding:
    """Look whether the parts are confirmed, and what the board gives at most."""
    values = asdict(facts.limits)
    most = f"it gives at most: {limits_text(facts.limits)}"
    lacks = missing(facts.info.board, facts.limits)
    if lacks is None:
        real = moves_parts(facts.info.board)
        blind = "; it does not measure its supply" if real and not facts.watches_supply else ""
        return Finding("parts", True, most + blind, values=values)
    what, advice = lacks
    return Finding("parts", False, f"{what}; {most}", advice, values)


def check_clock(facts: KnobFacts) -> Finding:
    """Compare the clocks."""
    clock = facts.clock
    text = (
        f"the knob's clock is at {clock.offset_s:+.6f} s against this computer's, and "
        f"{abs(clock.drift_ppm):.0f} ppm {'fast' if clock.drift_ppm > 0 else 'slow'} "
        f"(give or take {clock.uncertainty_ppm:.0f})"
    )
    if abs(clock.drift_ppm) <= _DRIFT_LIMIT_PPM + clock.uncertainty_ppm:
        return Finding("clock", True, text, values=asdict(clock))
    if not moves_parts(facts.info.board):
        return Finding("clock", True, text + _ON_BUSY_COMPUTER, values=asdict(clock))
    return Finding(
        "clock",
        False,
        text + ", more than a crystal can be wrong",
        "if the knob was not restarted meanwhile, its control loop keeps no time: see the ticks",
        asdict(clock),
    )


def check_round_trips(facts: KnobFacts) -> Finding:
    """See how quickly it answers."""
    trips = facts.round_trips
    if trips is None:
        return Finding("round_trip", True, "round trips were not timed: disarm the knob first")
    text = (
        f"it answers after {1e3 * trips.median_s:.2f} ms (median), "
        f"{1e3 * trips.p99_s:.2f} ms (99 of 100)"
    )
    if not moves_parts(facts.info.board):
        slow = trips.median_s > _SLOW_ROUND_TRIP_S
        text += _ON_BUSY_COMPUTER if slow else ""
        return Finding("round_trip", True, text, values=asdict(trips))
    # The library gives a sign of life three times in a watchdog's time.
    if trips.p99_s > facts.watchdog_s / 3:
        problem = f"; so late that the watchdog of {facts.watchdog_s:g} s may disarm the knob"
    elif trips.median_s > _SLOW_ROUND_TRIP_S:
        problem = "; USB needs 1 to 3 ms"
    else:
        return Finding("round_trip", True, text, values=asdict(trips))
    return Finding(
        "round_trip",
        False,
        text + problem,
        "plug the knob into the computer itself, without a hub or other devices on that port, and "
        "look for busy programs; in a virtual machine this may be normal",
        asdict(trips),
    )


def check_losses(facts: KnobFacts) -> Finding:
    """See whether everything arrived."""
    lost = {
        "samples_lost": facts.link.samples_lost,
        "samples_dropped": facts.after.samples_dropped - facts.before.samples_dropped,
        "reports_undecodable": facts.link.reports_undecodable,
        "reports_refused": facts.after.reports_refused - facts.before.reports_refused,
    }
    values = {"samples": facts.samples, **lost}
    words = {
        "samples_lost": "telemetry samples that did not arrive",
        "samples_dropped": "samples that the knob dropped, because nobody fetched them in time",
        "reports_undecodable": "reports that arrived damaged",
        "reports_refused": "reports that the knob refused, maybe damaged on the way",
    }
    bad = [f"{words[name]}: {count}" for name, count in lost.items() if count]
    if not bad:
        return Finding(
            "losses", True, f"{facts.samples} telemetry samples came, none lost", values=values
        )
    return Finding(
        "losses",
        False,
        "; ".join(bad),
        "try another cable and port, without a hub. On a busy computer read telemetry in its own "
        "thread, or at a lower rate",
        values,
    )


def check_ticks(facts: KnobFacts) -> Finding:
    """See whether the control loop keeps its rate."""
    late = facts.after.tick_overruns - facts.before.tick_overruns
    period_s = 1 / facts.info.control_rate_hz
    share = facts.after.tick_time_max_s / period_s
    values = {
        "control_rate_hz": facts.info.control_rate_hz,
        "tick_overruns": late,
        "tick_overruns_since_power_up": facts.after.tick_overruns,
        "tick_time_max_s": facts.after.tick_time_max_s,
    }
    text = (
        f"the control loop runs at {facts.info.control_rate_hz:.0f} Hz; its longest tick took "
        f"{100 * share:.0f} % of its time"
    )
    if late == 0 and share <= 1:
        return Finding("ticks", True, text, values=values)
    return Finding(
        "ticks",
        False,
        f"{text}; ticks that came late just now: {late}",
        "take effects out of the scene; if an empty scene does not help, load the firmware of the "
        "release again, and report it",
        values,
    )


def check_beliefs(facts: KnobFacts) -> Finding:
    """See whether ordinary use has shown that the configured values no longer hold."""
    swings = facts.after.unexpected_swings
    values = {"unexpected_swings": swings}
    if swings < UNEXPECTED_SWINGS:
        text = f"lasting swings that the configured values do not explain: {swings}, few enough"
        return Finding("beliefs", True, text, values=values)
    return Finding(
        "beliefs",
        False,
        f"the knob has swung to and fro {swings} times in scenes that its configured parts can "
        "render; so a configured value may no longer hold",
        "run `torsio calibrate` with nobody touching the knob, and keep what it finds",
        values,
    )


KNOB_CHECKS: tuple[Callable[[KnobFacts], Finding], ...] = (
    check_firmware,
    check_state,
    check_start,
    check_parts,
    check_clock,
    check_round_trips,
    check_losses,
    check_ticks,
    check_beliefs,
)
