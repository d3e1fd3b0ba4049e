"""The plant's motion enclosed: every number is a ball that provably holds the true one.

Between events the equations are linear, so a matrix exponential in ball arithmetic (Arb, by
python-flint) moves the state. An event is where a linear function of the state becomes 0. The first
zero is proven: before it the function's enclosure is positive, its derivative has one sign there,
and Newton's method in intervals narrows it. Parameters and commands are the exact values of their
64-bit numbers.

No ball is judged by its middle. If it holds 0, the piece of time is split; if that does not help,
or at a jump, the plant is undecided. A function of which an event is the first zero is 0 there in
truth, and the others are not negative.
"""

from __future__ import annotations

import sys
from functools import cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from flint import arb, arb_mat, ctx

from torsio.printed.plant import PlantParams
from torsio_studies.enclosure.flows import (
    COLUMNS,
    Centred,
    Mode,
    Row,
    Stay,
    UndecidedError,
    both,
    matrix_of,
    since_before,
)
from torsio_studies.fidelity.truth import HandTorque

__all__ = ["DIGITS", "Enclosure", "UndecidedError", "enclose"]

DIGITS: Final = 50
_A, _P, _B, _WA, _WP, _WB, _TM, _TB, _I, _F, _S, _CM, _CB, _ONE, _T = range(15)
_HALVINGS: Final = 60
_OF_A_LEAP: Final = 50  # pieces of time that take as long to look at


class TooLongError(ArithmeticError):
    """There are more pieces of time to look at than wanted."""


def _sum(*terms: tuple[Any, Row]) -> Row:
    """Give a sum of multiples of linear functions."""
    total: Row = {}
    for factor, row in terms:
        for column, value in row.items():
            total[column] = total.get(column, arb(0)) + factor * value
    return total


class Enclosure:
    """A plant from rest at angle 0, under commands and a hand's torque.

    Attributes
    ----------
    state
        Angles and speeds of knob, pulley and brake, the torques, the brake's current, and what is
        held: a column.
    events
        Events so far, by name, in order.
    """

    def __init__(self, plant: PlantParams, hand: HandTorque, *, digits: int) -> None:
        """Take the parameters as they are; compute with so many digits."""
        ctx.dps = digits
        self.plant, self.hand = plant, hand
        self.state, self.centred = arb_mat(COLUMNS, 1), Centred(COLUMNS)
        self._set(_ONE, arb(1))
        self.friction = [0, 0]
        self.play = 0  # 1: the brake's torque goes up with its current, -1: down, 0: it stays
        self.bend = 1 if plant.shaft_hardening else None
        self.cog = 0 if plant.cogging else None
        self.events: list[str] = []
        self.most_pieces, self._pieces = sys.maxsize, 0
        self._time_s = self._span_s = arb(0)
        self._modes = cache(self._mode)
        self._powers = cache(self._power)

    def advance(self, end_s: float, motor_command_nm: float, brake_command_nm: float) -> None:
        """Go on to a time while these commands, or shares of the supply, are held."""
        motor, command = self._targets(motor_command_nm, brake_command_nm)
        # Under the same command the current does not turn.
        if self.play and not (command - self.state[_CB, 0]).is_zero():
            self.play *= not self._is_surely(self.play * (self.state[_I, 0] - command))
        self._set(_CM, motor)
        self._set(_CB, command)
        now_s = float(self._time_s.mid())
        while now_s < end_s:
            force, slope, piece_end_s = self._hand_at(now_s)
            self._set(_F, force)
            self._set(_S, slope)
            until_s = min(end_s, piece_end_s)
            self._go(arb(until_s) - arb(now_s))
            now_s = until_s
        if not all(one.is_finite() for (one,) in self.state.tolist()):
            raise UndecidedError("a ball has grown without bounds")
        self._time_s = arb(end_s)

    def _set(self, place: int, value: Any) -> None:
        """Set what is known of the state from outside."""
        self.state[place, 0] = value
        self.centred.set(place, value)

    def values(self) -> tuple[Any, ...]:
        """Give the balls of the knob's angle and of the brake's; with electrics the current's."""
        angles = self.state[_A, 0], self.state[_B, 0]
        if (parts := self.plant.electrics) is None:
            return angles
        return *angles, self.state[_TM, 0] / arb(parts.torque_constant_nm_per_a)

    def _targets(self, motor: float, brake: float) -> tuple[Any, Any]:
        """Give where the torques of motor and brake go."""
        plant = self.plant
        if (parts := plant.electrics) is None:
            limit_nm = plant.motor_limit_nm
            motor = min(max(motor, -limit_nm), limit_nm)
            return arb(motor), arb(min(max(brake, 0.0), plant.brake_limit_nm))
        motor_nm = arb(parts.torque_constant_nm_per_a) / arb(parts.winding_resistance_ohm)
        brake_nm = arb(parts.coil_torque_constant_nm_per_a) / arb(parts.coil_resistance_ohm)
        volts = arb(parts.supply_v)
        return arb(motor) * volts * motor_nm, arb(brake) * volts * brake_nm

    def _rates(self) -> tuple[Any, Any, Any]:
        """Give one over the lags of motor and brake, and the torque by the knob's speed."""
        plant = self.plant
        if (parts := plant.electrics) is None:
            return (
                1 / arb(plant.motor_time_constant_s),
                1 / arb(plant.brake_time_constant_s),
                arb(0),
            )
        ohm, constant = arb(parts.winding_resistance_ohm), arb(parts.torque_constant_nm_per_a)
        coil = arb(parts.coil_resistance_ohm) / arb(parts.coil_inductance_h)
        return ohm / arb(parts.winding_inductance_h), coil, constant * constant / ohm

    def _hand_at(self, now_s: float) -> tuple[Any, Any, float]:
        """Give force and slope, exactly, as `HandTorque.piece` gives them rounded."""
        times, values, hand = self.hand.corners_s, self.hand.values, self.hand
        after = int(np.searchsorted(times, now_s, side="right"))
        slope = arb(0)
        value = arb(float(values[max(after - 1, 0)]))
        end_s = float(times[after]) if after < len(times) else float("inf")
        if 0 < after < len(times):
            begin_s = arb(float(times[after - 1]))
            slope = (arb(float(values[after])) - value) / (arb(end_s) - begin_s)
            value += slope * (arb(now_s) - begin_s)
        if hand.stiffness_nm_per_rad == hand.damping_nm_s_per_rad == 0.0:
            return value, slope, end_s
        stiffness, damping = arb(hand.stiffness_nm_per_rad), arb(hand.damping_nm_s_per_rad)
        return stiffness * value + damping * slope, stiffness * slope, end_s

    # The equations -------------------------------------------------------------------------

    def _key(self) -> tuple[Any, ...]:
        return (*self.friction, self.play, self.bend, self.cog)

    def _shaft(self, bend: int | None) -> Row:
        """Give the torque of the spring: what it takes from the knob."""
        plant = self.plant
        other, other_speed = (_P, _WP) if plant.belt else (_B, _WB)
        stiffness, rest = arb(plant.shaft_stiffness_nm_per_rad), arb(0)
        if plant.shaft_hardening and bend != 1:
            factor = arb(plant.shaft_hardening.stiffness_factor)
            rest = (1 if bend == 2 else -1) * arb(plant.shaft_hardening.knee_rad) * (1 - 1 / factor)
            stiffness *= factor
        damping = arb(plant.shaft_damping_nm_s_per_rad)
        return {
            _A: stiffness, other: -stiffness, _ONE: -stiffness * rest,
            _WA: damping, other_speed: -damping,
        }  # fmt: skip

    def _cogging(self, cog: int | None) -> Row:
        if self.plant.cogging is None or cog is None:
            return {}
        wave = [arb(one) for one in self.plant.cogging.torque_nm]
        begin, end = wave[cog % len(wave)], wave[(cog + 1) % len(wave)]
        slope = (end - begin) / self._piece_rad()
        return {_A: slope, _ONE: begin - slope * cog * self._piece_rad()}

    def _piece_rad(self) -> Any:
        cogging = self.plant.cogging
        assert cogging is not None
        return 2 * arb.pi() / (cogging.periods_per_rev * len(tuple(cogging.torque_nm)))

    def _demands(self, bend: int | None, cog: int | None) -> tuple[Row, Row, Row]:
        """Give the torques on knob, pulley and brake, without friction."""
        plant, hand = self.plant, self.hand
        shaft = self._shaft(bend)
        losses = arb(plant.knob_viscous_nm_s_per_rad) + arb(hand.damping_nm_s_per_rad)
        knob = _sum(
            (1, {_F: arb(1), _TM: arb(1), _A: -arb(hand.stiffness_nm_per_rad), _WA: -losses}),
            (1, self._cogging(cog)), (-1, shaft),
        )  # fmt: skip
        brake_losses = {_WB: -arb(plant.brake_viscous_nm_s_per_rad)}
        if plant.belt is None:
            return knob, {}, _sum((1, shaft), (1, brake_losses))
        stiffness = arb(plant.belt.stiffness_nm_per_rad)
        damping = arb(plant.belt.damping_nm_s_per_rad)
        belt = {_P: stiffness, _B: -stiffness, _WP: damping, _WB: -damping}
        return knob, _sum((1, shaft), (-1, belt)), _sum((1, belt), (1, brake_losses))

    def _capacities(self) -> tuple[Row, Row]:
        plant = self.plant
        return {_ONE: arb(plant.knob_coulomb_nm)}, {_TB: arb(1), _ONE: arb(plant.brake_drag_nm)}

    def _mode(self, key: tuple[Any, ...]) -> Mode:
        """Give the equations of a mode."""
        *friction, play, bend, cog = key
        plant = self.plant
        demands = self._demands(bend, cog)
        capacities = self._capacities()
        pulley = arb(plant.belt.pulley_inertia_kg_m2) if plant.belt else arb(1)
        inertia = (
            arb(plant.knob_inertia_kg_m2) + arb(self.hand.inertia_kg_m2),
            arb(plant.brake_inertia_kg_m2) - (pulley if plant.belt else 0),
        )
        rows: list[Row] = [{} for _ in range(COLUMNS)]
        stays: list[tuple[str, Row]] = []
        ends = (("knob", _A, _WA, demands[0]), ("brake", _B, _WB, demands[2]))
        for end, (name, angle, speed, demand) in enumerate(ends):
            way = friction[end]
            if way:
                rows[angle] = {speed: arb(1)}
                left = _sum((1, demand), (-way, capacities[end]))
                rows[speed] = _sum((1 / inertia[end], left))
                stays.append((f"{name} stops", {speed: arb(way)}))
            else:
                for sign in (1, -1):
                    held = _sum((1, capacities[end]), (-sign, demand))
                    stays.append((f"{name} starts", held))
        if plant.belt:
            rows[_P], rows[_WP] = {_WP: arb(1)}, _sum((1 / pulley, demands[1]))
        motor_rate, rate, back_emf = self._rates()
        rows[_TM] = {_CM: motor_rate, _TM: -motor_rate, _WA: -motor_rate * back_emf}
        rows[_TB] = {_CB: rate, _TB: -rate}
        if plant.brake_hysteresis:
            rows[_I] = {_CB: rate, _I: -rate}
            rows[_TB] = rows[_I] if play else {}
        rows[_F], rows[_T] = {_S: arb(1)}, {_ONE: arb(1)}
        stays += self._bounds(play, bend, cog)
        return Mode(matrix_of(rows), stays)

    def _bounds(self, play: int, bend: int | None, cog: int | None) -> list[tuple[str, Row]]:
        """Give what keeps the brake in its play, the shaft between knees, the knob on a cog."""
        found: list[tuple[str, Row]] = []
        if self.plant.brake_hysteresis and not play:
            half = arb(self.plant.brake_hysteresis.half_width_nm)
            found += [("play", {_I: -arb(way), _TB: arb(way), _ONE: half}) for way in (1, -1)]
        if self.plant.shaft_hardening and bend is not None:
            knee = arb(self.plant.shaft_hardening.knee_rad)
            twist = {_A: arb(1), (_P if self.plant.belt else _B): arb(-1)}
            sides = ((-1, 1), (1, 1)) if bend == 1 else ((1, -1),) if bend == 2 else ((-1, -1),)
            found += [("knee", _sum((way, twist), (of, {_ONE: knee}))) for way, of in sides]
        if cog is not None:
            piece = self._piece_rad()
            found.append(("cogging", {_A: arb(1), _ONE: -cog * piece}))
            found.append(("cogging", {_A: arb(-1), _ONE: (cog + 1) * piece}))
        return found

    # The proof -----------------------------------------------------------------------------

    def _power(self, key: tuple[Any, ...], level: int) -> tuple[Any, Any]:
        """Give the flow over 2^-level s, and the flow of all times within."""
        mode, width = self._modes(key), arb(2.0**-level)
        within = mode.within(width, level - mode.level)
        if level < mode.level:
            finer = self._powers(key, level + 1)[0]
            return finer * finer, within
        return (mode.matrix * width).exp(), within

    def _span(self, width: Any, level: int | None, depth: int) -> tuple[Any, Any]:
        """Give the state at the end of a piece of time, and all states in it."""
        mode = self._modes(self._key())
        if level is not None:
            flow, within = self._powers(self._key(), level)
            end = flow * self.state
        else:
            end, within = mode.moved(self.state, width), mode.within(width, depth)
        # Exact if it is: a hand's torque may come to just the friction at a period's end.
        end[_F, 0] = self.state[_F, 0] + self.state[_S, 0] * width
        # What a state adds to its begin: large terms that cancel each other stay narrow.
        return end, self.state + mode.matrix * (within * self.state) * since_before(width)

    def _go(self, left: Any) -> None:
        """Go on for a time in which nothing jumps."""
        self._span_s = left
        self._set(_T, arb(0))
        self._let_go()
        name = ""
        while True:
            found = self._first(left, name)
            if found is None:
                return
            at, name, number = found
            left = left - at
            self._switch(name, number)

    def _let_go(self) -> None:
        """Release a shaft at rest if the torque exceeds its friction."""
        demands, capacities = self._demands(self.bend, self.cog), self._capacities()
        for end, demand in ((0, demands[0]), (1, demands[2])):
            for sign in (1, -1):
                over = _sum((sign, demand), (-1, capacities[end]))
                if not self.friction[end] and self._is_surely(self._value(matrix_of([over]))):
                    self.friction[end] = sign
        self._leave_corner()

    def _leave_corner(self) -> None:
        """Take the piece of cogging that a knob goes into which starts on a corner, backwards."""
        if self.cog is not None and self.friction[0] < 0:
            corner = {_A: arb(1), _ONE: -self.cog * self._piece_rad()}
            self.cog -= not self._is_surely(self._value(matrix_of([corner])))

    @staticmethod
    def _is_surely(value: Any) -> bool:
        """Say whether a value is positive; a ball that holds 0 and more decides nothing."""
        if value > 0 or value <= 0:
            return bool(value > 0)
        raise UndecidedError("a function is too near 0 where a command or a hand jumps")

    def _value(self, function: Any) -> Any:
        return (function * self.state)[0, 0]

    def _first(self, left: Any, after: str) -> tuple[Any, str, int] | None:
        """Move the state to the first event, or to the end; give when, and what it is."""
        mode, gone = self._modes(self._key()), arb(0)
        todo: list[tuple[Any, int | None, int]] = [(left, None, 0)]
        while todo:
            self._pieces += 1
            if self._pieces > self.most_pieces:
                raise TooLongError
            width, level, depth = todo.pop()
            is_last = not todo
            if level is None and arb(2.0**-mode.level) < width:
                todo += [(width - arb(2.0**-mode.level), None, 0), (None, mode.level, 0)]
                continue
            width = arb(2.0**-level) if level is not None else width
            end, inside = self._span(width, level, depth)
            falling = []
            for number, stay in enumerate(mode.stays):
                verdict = stay.looks(self.state, inside, end, after, is_last=is_last)
                if verdict == "?":
                    break
                if verdict == "one":
                    falling.append(number)
            else:
                if falling:
                    return self._event(gone, width, inside, falling)
                self.state, gone, after = end, gone + width, ""
                continue
            if depth > _HALVINGS:
                raise UndecidedError("a function touches 0")
            half = arb((width / 2).mid())  # only the last piece's end is a ball
            level = None if level is None else level + 1
            todo += [(width - half, level, depth + 1), (half, level, depth + 1)]
        # How much time was left after an event differs for each state; the end does not.
        ends = self._span_s - self.centred.middle[_T, 0]
        middle = (mode.matrix * ends).exp() * self.centred.middle
        self._leap(mode, middle, mode.flow(left), Stay("end", {_T: arb(-1)}, mode.matrix))
        return None

    def _event(
        self, gone: Any, width: Any, inside: Any, falling: list[int]
    ) -> tuple[Any, str, int]:
        """Move the state to the first zero of functions that fall in a piece of time."""
        mode = self._modes(self._key())
        flow = (mode.matrix * gone).exp()
        begin, middle = both(self.state, flow * self.centred.box()), flow * self.centred.middle
        roots = [(mode.stays[one].root(mode, begin, inside, width), one) for one in falling]
        root, number = min(roots, key=lambda one: float(one[0].mid()))
        stay = mode.stays[number]
        if any(not root < other for other, place in roots if place != number):
            raise UndecidedError(f"{stay.name} and another event at the same time")
        self.state = mode.moved(begin, root)
        at = stay.root(mode, middle, inside, width)
        middle = mode.moved(middle, at)
        self._leap(mode, middle, mode.flow(root) * flow, stay)
        return gone + root, stay.name, number

    def _leap(self, mode: Mode, middle: Any, flow: Any, stay: Stay) -> None:
        """Go on with the middle and the box about it, from which the balls come."""
        self._pieces += _OF_A_LEAP
        self.centred.leap(mode, middle, flow, stay, self.state)
        self.state = self.centred.box()

    def _switch(self, name: str, number: int) -> None:
        """Go over to the mode after an event."""
        self.events.append(name)
        end = 1 if name.startswith("brake") else 0
        stays = self._modes(self._key()).stays
        way = stays[number].derivatives[0]
        if name.endswith("starts"):
            held_other = stays[number - 1].name == name
            self.friction[end] = -1 if held_other else 1
            self._leave_corner()
        elif name.endswith("stops"):
            self._set((_WA, _WB)[end], arb(0))
            self.friction[end] = 0
            self._let_go()
        elif name == "play":
            self.play = 1 if way[0, _I] < 0 else -1
        elif name == "cogging":
            assert self.cog is not None
            self.cog += 1 if way[0, _A] < 0 else -1
        else:
            self.bend = (2 if way[0, _A] < 0 else 0) if self.bend == 1 else 1


def enclose(
    plant: PlantParams,
    hand: HandTorque,
    motor_nm: npt.NDArray[np.float64],
    brake_nm: npt.NDArray[np.float64],
    *,
    period_s: float,
    digits: int,
    most_pieces: int | None = None,
) -> tuple[list[tuple[Any, ...]], Enclosure, list[int]]:
    """Give the balls of `values` at the ends of the periods, the run, and the events up to each.

    Of `digits` some are lost on the way; the balls say how many are left.
    """
    run = Enclosure(plant, hand, digits=digits)
    balls, counts = [], []
    run.most_pieces = most_pieces or sys.maxsize
    for number, (motor, brake) in enumerate(zip(motor_nm, brake_nm, strict=True)):
        try:
            run.advance((number + 1) * period_s, float(motor), float(brake))
        except TooLongError:
            break
        balls.append(run.values())
        counts.append(len(run.events))
    return balls, run, counts
