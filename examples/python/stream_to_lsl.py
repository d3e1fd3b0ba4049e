"""A Lab Streaming Layer stream of the knob, beside EEG, eye trackers and whatever else has one.

The samples carry the device's own time stamps, moved to LSL's clock by one offset, so that their
distances are the device's. Needs `pip install pylsl`.
"""

from __future__ import annotations

import sys

import pylsl

import torsio

CHANNELS = {
    "angle_rad": "rad",
    "desired_torque_nm": "N m",
    "spring_torque_nm": "N m",
    "motor_command_nm": "N m",
}
HAND = torsio.ImpedanceHand(
    intended_angle_rad=[(0.0, 0.0), (1.0, 0.2)],
    stiffness_nm_per_rad=0.5,
    damping_nm_s_per_rad=4e-3,
    inertia_kg_m2=1e-4,
)


def outlet(serial_number: str, rate_hz: float) -> pylsl.StreamOutlet:
    """Announce the stream and say what its channels are."""
    info = pylsl.StreamInfo(
        "torsio", "Haptics", len(CHANNELS), rate_hz, pylsl.cf_double64, f"torsio-{serial_number}"
    )
    channels = info.desc().append_child("channels")
    for label, unit in CHANNELS.items():
        channel = channels.append_child("channel")
        channel.append_child_value("label", label)
        channel.append_child_value("unit", unit)
    return pylsl.StreamOutlet(info)


def main(device: str = "emulated", duration_s: str = "2", rate_hz: str = "1000") -> None:
    """Play a wall, and stream what happens at it for a while."""
    # In real time, as a plugged-in knob is.
    emulator = torsio.EmulatorOptions(paced=True) if device == "emulated" else None
    with torsio.open(device, emulator=emulator) as knob:
        knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.0))
        knob.arm()
        if knob.is_emulated:  # a real one is turned by you
            knob.emulator.set_hand(HAND)
        stream = outlet(knob.info.serial, knob.start_telemetry(float(rate_hz)))
        before_s = pylsl.local_clock()
        begin_s = knob.clock().time_s
        # The device answered between the two; half a millisecond is what a cable takes.
        offset_s = (before_s + pylsl.local_clock()) / 2 - begin_s
        sent = 0
        time_s = begin_s
        while time_s < begin_s + float(duration_s):
            for sample in knob.read():
                time_s = float(sample["time_s"])
                stream.push_sample([float(sample[name]) for name in CHANNELS], time_s + offset_s)
                sent += 1
    print(f"{sent} samples of {', '.join(CHANNELS)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
