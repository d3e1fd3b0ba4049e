"""The world round a board: motor, knob, brake and hand, in lockstep with its PWM.

A board that is coupled to a world gives it, once a PWM period, what its bridges do, and gets the
motor's current as the period begins and the encoder's edges at their times within it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from torsio.emulator import Circuit, Encoder, Plant
from torsio.printed.config import BoardConfig
from torsio.printed.hands import Hand
from torsio.printed.plant import Electrics, PlantParams

# Of a measurement, before the middle of the bridge's pulse. Assumed and not seen: a world moves by
# whole periods. tests/cpp/device/test_power_stage.cpp has the order to the chip.
LEAD_S = 1e-6
PERIOD_NS = 25_000  # PWM of the bridges
ROW_NS = 1_000_000  # from one row of a record to the next


class World:
    """The C++ plant and its electrics, driven by a board's pins.

    A bridge that is switched on or off is so from the next period on. An edge is where a straight
    line between the knob's angles at both ends of a period has it.
    """

    def __init__(self, params: PlantParams | None = None, *, seed: int = 1) -> None:
        self.params = params or PlantParams(electrics=Electrics())
        assert self.params.electrics is not None
        self._electrics = self.params.electrics
        self.plant = Plant(self.params, step_ns=PERIOD_NS)
        self.circuit = Circuit(self.plant)
        self._encoder = Encoder(
            counts_per_rev=self.params.counts_per_rev, rounding=self.params.encoder_rounding
        )
        self._random = np.random.default_rng(seed)
        self._angle = 0.0
        self._count = self._counts(0.0)
        self.periods = 0
        self.rows: list[dict[str, Any]] = []

    @property
    def time_s(self) -> float:
        """Seconds since the board was coupled."""
        return 1e-9 * PERIOD_NS * self.periods

    def set_hand(self, hand: Hand) -> None:
        """Let another hand take over; its times are this world's."""
        self.plant.set_hand(hand)

    def pass_period(
        self, motor_share: float, brake_share: float, enabled: bool
    ) -> tuple[float, list[float]]:
        """Let a period pass.

        Returns
        -------
        tuple
            What the motor's current is as the period begins, if one takes the sensor's volts for
            those of the sensor that a board is told of, and the encoder's edges: the time of each
            within the period in ns, negative for one backwards.
        """
        electrics = self._electrics
        after_middle_s = electrics.sample_offset_s - LEAD_S
        sensed_v = electrics.sensor_v_per_a * self.circuit.current_a(after_middle_s)
        sensed_v += electrics.sensor_noise_v * self._random.normal()
        current_a = sensed_v / BoardConfig().current_sense_v_per_a
        if self.periods * PERIOD_NS % ROW_NS == 0:
            self.rows.append(self.plant.state)
        self.circuit.advance(
            PERIOD_NS, motor_share=motor_share, brake_share=brake_share, enabled=enabled
        )
        self.periods += 1
        begin, self._angle = self._angle, self.plant.angle_rad
        return current_a, self._edges(begin, self._angle)

    def _edges(self, begin: float, end: float) -> list[float]:
        before, self._count = self._count, self._counts(end)
        step = 1 if self._count > before else -1
        found = []
        crossed = range(before, self._count, step)
        for n, count in enumerate(crossed, 1):
            # The border that is crossed lies at the beginning of the higher of both counts.
            border = 2 * math.pi * (count + (step > 0)) / self.params.counts_per_rev
            share = (border - begin) / (end - begin) if end != begin else 0.0
            if self.params.encoder_noise_counts:  # the line tells nothing: at equal distances
                share = n / (len(crossed) + 1)
            found.append(step * max(1.0, min(1.0, share) * PERIOD_NS))
        return found

    def _counts(self, angle: float) -> int:
        noise = self.params.encoder_noise_counts
        if noise:
            angle += 2 * math.pi * noise * self._random.normal() / self.params.counts_per_rev
        count = self._encoder.sample(angle)
        return count - (1 << 32) if count >> 31 else count

    def record(self) -> Any:
        """Give the rows so far, one a millisecond, as columns by name."""
        return columns(self.rows)


def columns(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Turn rows into an array for each name."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
