"""Every wire of a knob, and two pictures of them: the harness, and the board from above."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator

from torsio_hardware.drawing import page
from torsio_hardware.knob import Knob

# Where a Pico has its pins, by what is printed beside them: 1 to 20 below, 21 to 40 above, with
# the USB socket at the left.
_GPIO = {
    **{gp: gp + 1 + (gp + 2) // 4 for gp in range(16)},
    **{gp: gp + 5 + (gp - 14) // 4 for gp in range(16, 23)},
    **{26: 31, 27: 32, 28: 34},
}
PICO = {f"board GP{gp}": pin for gp, pin in _GPIO.items()} | {"board 3V3": 36, "board VBUS": 40}
# Holes of the perfboard, 2.54 mm apart, as columns and rows; and what stands on them.
HOLES = (35, 25)
MODULES = {
    "Pico": (1, 1, 20, 8),
    "motor bridge": (8, 13, 15, 20),
    "brake bridge": (18, 13, 25, 20),
    "current sensor": (28, 12, 34, 20),
    "dividers": (3, 12, 6, 16),
    "encoder": (3, 18, 6, 20),
    "2200 uF": (12, 21, 16, 23),
    "emergency stop": (28, 3, 31, 11),
    "clamp": (22, 22, 25, 23),
    "divider": (27, 21, 30, 23),
    "supply": (31, 22, 34, 24),
}
_TERMINALS = {
    **{"encoder VCC": (3, 18), "encoder A": (4, 18), "encoder B": (5, 18), "2200 uF +": (16, 23)},
    **{"dividers OUT_A": (4, 12), "dividers IN_A": (4, 14)},
    **{"dividers OUT_B": (5, 12), "dividers IN_B": (5, 14)},
    **{"stop contact 1": (28, 9), "stop contact 2": (28, 10), "stop contact 2 out": (28, 11)},
    **{"divider OUT": (27, 21), "divider top": (30, 21), "supply +": (31, 24), "clamp +": (25, 23)},
    **{"current sensor OUT": (32, 12), "current sensor VCC": (33, 12)},
    **{"motor bridge PMODE": (8, 17), "brake bridge PMODE": (25, 15)},
}
_BRIDGE = {"IN1": (1, 0), "IN2": (2, 0), "SLEEP": (4, 0), "FAULT": (5, 0), "VM": (2, 7)}
for _name in ("motor bridge", "brake bridge"):
    _left, _top, *_ = MODULES[_name]
    for _pin, (_x, _y) in _BRIDGE.items():
        _TERMINALS[f"{_name} {_pin}"] = (_left + _x, _top + _y)
# Of each, where it meets the ground at the supply.
GROUNDS = {
    **{"Pico": (8, 8), "motor bridge": (8, 20), "brake bridge": (18, 20), "encoder": (6, 18)},
    **{"dividers": (3, 14), "emergency stop": (31, 9), "current sensor": (28, 20)},
    **{"clamp": (22, 23), "divider": (27, 23), "supply": (34, 24), "2200 uF": (12, 23)},
}
# Solder a resistor from each of these to ground; one holds both bridges' enable.
PULLED_DOWN = (
    *("motor bridge IN1", "motor bridge IN2", "brake bridge IN1", "brake bridge IN2"),
    "motor bridge SLEEP",
)
_GROUND_ROW = 10.6
_PITCH = 20  # of a picture's units
_LEGEND = (
    "Join all black dots with the supply's ground. Numbers: wires of the harness.",
    "4.7 kohm to each marked input; dividers: 1 kohm inside, 1.8 kohm outside.",
)
_COLOURS = {"PWM": "#c60", "signal": "#159", "power": "#b22"}


def wiring(knob: Knob) -> list[tuple[str, str, str, str]]:
    """Give every wire: from, to, its kind, and what it carries; pins as configured."""
    pin = {name: f"board GP{number}" for name, number in knob.pins.items()}
    second = {name: f"board GP{number + 1}" for name, number in knob.pins.items()}
    fault, coil = pin["driver_fault_pin"], f"{knob.number('brake_current_max_a'):g} A"
    return [
        (pin["encoder_pin"], "dividers OUT_A", "signal", "3.2 V; 1 kohm to IN, 1.8 to ground"),
        (second["encoder_pin"], "dividers OUT_B", "signal", "3.2 V; 1 kohm to IN, 1.8 to ground"),
        ("dividers IN_A", "encoder A", "signal", "5 V"),
        ("dividers IN_B", "encoder B", "signal", "5 V"),
        (pin["motor_pin"], "motor bridge IN1", "PWM", "4.7 kohm to ground"),
        (second["motor_pin"], "motor bridge IN2", "PWM", "4.7 kohm to ground"),
        (pin["brake_pin"], "brake bridge IN1", "PWM", "4.7 kohm to ground"),
        (second["brake_pin"], "brake bridge IN2", "PWM", "4.7 kohm to ground"),
        (pin["emergency_stop_pin"], "stop contact 1", "signal", "to ground, opens when pressed"),
        (pin["enable_pin"], "stop contact 2", "signal", "enable; opens when pressed"),
        ("stop contact 2 out", "motor bridge SLEEP", "signal", "enable, 4.7 kohm to ground"),
        ("stop contact 2 out", "brake bridge SLEEP", "signal", "enable"),
        (fault, "motor bridge FAULT", "signal", "low on an error"),
        (fault, "brake bridge FAULT", "signal", "low on an error"),
        ("board 3V3", "motor bridge PMODE", "power", "3.3 V: two inputs"),
        ("board 3V3", "brake bridge PMODE", "power", "3.3 V: two inputs"),
        (pin["current_sense_pin"], "current sensor OUT", "signal", "1.65 V at no current; 0.2 V/A"),
        (pin["supply_sense_pin"], "divider OUT", "signal", "supply over 11"),
        ("board 3V3", "current sensor VCC", "power", "3.3 V, REF1 too; REF2 to ground"),
        ("board VBUS", "encoder VCC", "power", "5 V, 20 mA"),
        ("supply +", "motor bridge VM", "power", "12 V, 4 A, fuse"),
        ("supply +", "2200 uF +", "power", "12 V; 2200 uF to ground"),
        ("supply +", "brake bridge VM", "power", "12 V"),
        ("supply +", "divider top", "power", "12 V"),
        ("supply +", "clamp +", "power", "1.2 A from 13.0 V on, to ground"),
        ("supply ground", "all grounds, one point", "power", "4 A"),
        ("motor bridge OUT1", "choke, sensor, motor +", "power", "2 A"),
        ("motor bridge OUT2", "motor -", "power", "2 A"),
        ("brake bridge OUT1", "brake coil", "power", coil),
        ("brake bridge OUT2", "brake coil", "power", coil),
    ]


def _line(points: Iterable[tuple[float, float]], colour: str) -> str:
    words = " ".join(f"{x:g},{y:g}" for x, y in points)
    return f'<polyline points="{words}" stroke="{colour}"/>'


def harness_svg(knob: Knob) -> str:
    """Draw the harness: a line for each wire, with what it carries."""
    wires, shapes = wiring(knob), []
    for n, (begin, end, kind, carries) in enumerate(wires):
        y = 40 + 26 * n
        shapes += [
            f'<rect x="20" y="{y - 14}" width="140" height="20"/><text x="26" y="{y}">{begin}'
            f"</text>{_line([(160, y - 4), (500, y - 4)], _COLOURS[kind])}"
            f'<text class="small" x="175" y="{y - 8}">{n + 1}: {kind}, {carries}</text>'
            f'<rect x="500" y="{y - 14}" width="180" height="20"/>'
            f'<text x="506" y="{y}">{end}</text>'
        ]
    return page(700, 40 + 26 * len(wires), shapes)


def place(end: str) -> tuple[int, int] | None:
    """Return the hole in which a wire's end is soldered; None for what is not on the board."""
    if end in PICO:
        pin = PICO[end]
        return (pin, 8) if pin <= 20 else (41 - pin, 1)
    return _TERMINALS.get(end)


def _way(begin: tuple[int, int], end: tuple[int, int], lane: int) -> list[tuple[float, float]]:
    """Lead a wire round the modules: others are straight."""
    if end[1] < 11:
        return [begin, (begin[0], end[1]), end]
    if begin[1] > 1:
        return [begin, (end[0], begin[1]), end] if begin[1] > 10 else [begin, end]
    above, side = 0.4 - 0.3 * lane, end[0] if end[0] > 20 else -0.2 - 0.1 * lane
    return [begin, (begin[0], above), (side, above), (side, end[1]), end]


def _at(column: float, row: float) -> tuple[float, float]:
    """Give the place of a hole in the picture."""
    return (column + 1) * _PITCH, (row + 2) * _PITCH


def board_svg(knob: Knob) -> str:
    """Draw the perfboard from above: modules, resistors, and the wires between them."""
    holes = [_at(column, row) for column in range(HOLES[0]) for row in range(HOLES[1])]
    shapes = [f'<circle cx="{x:g}" cy="{y:g}" r="2" class="dot"/>' for x, y in holes]
    shapes += [*_modules(), *_resistors(), *_wires(knob)]
    for n, words in enumerate(_LEGEND):
        x, y = _at(0, HOLES[1] + n)
        shapes += [f'<text x="{x:g}" y="{y:g}">{words}</text>']
    return page((HOLES[0] + 1) * _PITCH, (HOLES[1] + 6) * _PITCH, shapes)


def _modules() -> Iterator[str]:
    for name, (left, top, right, bottom) in MODULES.items():
        (x, y), (far, low) = _at(left - 0.4, top - 0.4), _at(right + 0.4, bottom + 0.4)
        yield (
            f'<rect x="{x:g}" y="{y:g}" width="{far - x:g}" height="{low - y:g}" '
            'style="fill-opacity:.85"/>'
        )
        for n, word in enumerate(reversed(name.split())):
            yield (
                f'<text x="{(x + far) / 2:g}" y="{min(low - 5, y + 110) - 13 * n:g}" '
                f'text-anchor="middle">{word}</text>'
            )


def _resistors() -> Iterator[str]:
    """Draw them with their wires, and a ring round each hole at ground."""
    yield _line([_at(8, 8), _at(8, _GROUND_ROW), _at(23.5, _GROUND_ROW)], "#000")
    pulled = [_TERMINALS[end] for end in PULLED_DOWN]
    resistors = [((x + 0.35, _GROUND_ROW), (x + 0.35, y), (x, y)) for x, y in pulled]
    resistors += [((x, 14), (x, 12), (to, 12)) for x, to in ((3, 4), (4, 4), (5, 5), (6, 5))]
    for points in resistors:
        (x, y), (_, far), _ = on = [_at(*point) for point in points]
        yield _line(on, "#000")
        yield f'<rect x="{x - 4:g}" y="{(y + far) / 2 - 11:g}" width="8" height="22"/>'
    for x, y in (_at(*hole) for hole in (*GROUNDS.values(), (6, 14))):
        yield f'<circle cx="{x:g}" cy="{y:g}" r="5"/>'


def _wires(knob: Knob) -> Iterator[str]:
    """Draw the wires between the modules, with their numbers at both ends."""
    lane = 0
    labels = defaultdict[tuple[tuple[int, int], str, str], list[str]](list)
    for n, (begin, end, kind, _) in enumerate(wiring(knob)):
        first, last = place(begin), place(end)
        if first is not None and last is not None:
            lane += first[1] == 1
            yield _line((_at(*point) for point in _way(first, last, lane)), _COLOURS[kind])
            for hole, label in ((first, begin), (last, end)):
                terminal = "" if label in MODULES else label.split()[-1]
                labels[hole, terminal, kind].append(str(n + 1))
    for (hole, label, kind), numbers in labels.items():
        x, y = _at(*hole)
        yield (
            f'<circle cx="{x:g}" cy="{y:g}" r="4" style="fill:{_COLOURS[kind]}"/>'
            f'<text class="small" transform="translate({x + 3:g} {y + 7:g}) rotate(50)">'
            f"{label} {'+'.join(numbers)}</text>"
        )
