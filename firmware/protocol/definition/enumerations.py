"""Every enumeration and every set of bits that host and device share.

The number of a value is its place, so a new one goes to the end. Names are words for people and do not
enter the fingerprint.
"""

from __future__ import annotations

from tools.definition.model import Bits, Value, enumeration

TOGGLE = enumeration("Toggle", "", "off", "on", public=False)

# --- effects -------------------------------------------------------------------------------------

SIDE = enumeration("Side", "On which side of its surface a wall is solid.", "above", "below")
WAVEFORM = enumeration(
    "Waveform",
    "Shape of a periodic torque.",
    "sine", "square", "triangle", "sawtooth_up", "sawtooth_down",
)  # fmt: skip
DETENT_PROFILE = enumeration(
    "DetentProfile",
    "Torque from one notch to the next: -T sin(2 pi u) at u pitches from a notch; -2 T u within half "
    "a pitch; or linear within the width, beyond it T toward the notch.",
    "sine", "linear", "click",
)  # fmt: skip
GRAIN = enumeration(
    "Grain",
    "Shape of a texture's grains; noise draws a value for each and joins them smoothly.",
    "sine", "square", "triangle", "noise",
)  # fmt: skip
ENDS = enumeration("Ends", "A curve's torque outside its span.", "hold", "repeat")

# --- configuration -------------------------------------------------------------------------------

LAW = enumeration(
    "Law",
    "How the desired torque is shared between motor and brake; docs/explanation/theory.md.",
    Value("paper", "the printed law, as it must be read"),
    Value("compensated", "the motor fills in what the brake does not hold, with its drag counted"),
    Value("parallel", "fixed shares without the sensor: it sticks, and is here to show that"),
    Value("motor_only", "no brake"),
    Value("calibrated", "as compensated, with a stiffness that is bounded by the parts"),
)

BASIS = enumeration(
    "Basis",
    "On what the values of actuator and shaft are based.",
    Value("assumed", "on data sheets, or a value was changed since"),
    Value("stated", "on the word of a user who answers for them"),
    Value("measured", "on a calibration"),
)

PERSONALITY = enumeration(
    "Personality",
    "The second interface, as the computer sees it.",
    Value("game_controller", "a joystick's axis with force feedback"),
    Value("dial", "a wheel of the desktop, with detents"),
)
DIAL_USE = enumeration(
    "DialUse",
    "Effect of a dial: clockwise, to larger angles, is down, right or louder.",
    Value("wheel", "scrolls, in 120 steps a detent where the system can"),
    Value("pan", "scrolls sideways, as finely"),
    Value("volume", "a key press for each detent"),
    Value("radial", "turns Windows' radial controller; the first button is the controller's"),
    Value("wheel_or_pan", "scrolls; sideways while the first button is pressed"),
    Value("wheel_or_volume", "scrolls; presses the keys while the first button is pressed"),
    Value("volume_or_wheel", "presses the keys; scrolls while the first button is pressed"),
)

CENTRE = enumeration(
    "Centre",
    "Where angle 0 comes from.",
    Value("power_up", "the knob's place at power-up, or at the last zero; there is no index"),
    Value("awaits_index", "the same, until a slow turn has passed the index twice"),
    Value("index", "the encoder's index: a save keeps angle 0 over power cycles"),
)

# --- what the device says ------------------------------------------------------------------------

STATE = enumeration(
    "State",
    "Whether the device makes torque.",
    Value("disarmed", "no torque"),
    Value("armed", "the scene acts"),
    Value("fault", "no torque until the fault is cleared"),
    Value("disconnected", "the device is unplugged, or does not answer any more", host_only=True),
)
OWNER = enumeration(
    "Owner", "Owner of the actuator: none unless it is armed.", "none", "sdk", "game", "dial"
)
GAME_EFFECT_KIND = enumeration(
    "GameEffectKind",
    "Kind of a game's effect.",
    "none", "constant", "ramp", "square", "sine", "triangle", "sawtooth_up", "sawtooth_down",
    "spring", "damper", "inertia", "friction",
)  # fmt: skip
GAME_EFFECT_STATE = enumeration(
    "GameEffectState",
    "Whether a game's effect plays.",
    Value("stopped", "never started, stopped by the game, or at its end"),
    Value("playing", "it plays, or waits for its delay"),
    Value("set_aside", "ended by the device: the game's next update brings it back"),
)
OP = enumeration(
    "Op",
    "Command: what the host asks the device to do.",
    Value("keep_alive", "nothing but a sign of life, not acknowledged"),
    Value("arm"),
    Value("disarm"),
    Value("stop", "disarm and empty the scene"),
    Value("zero", "this position becomes angle 0; only while disarmed"),
    Value("relax", "the shaft's spring is known to be relaxed now; only while disarmed"),
    Value("save", "keep the configuration; only while disarmed"),
    Value("load_defaults", "configuration of a new device; only while disarmed"),
    Value("clear_fault"),
    Value("bootloader", "wait for new firmware, nobody can arm after it; only while disarmed"),
    public=False,
)
DISARM_REASON = enumeration(
    "DisarmReason",
    "Why the torque went.",
    Value("order", "a program called disarm() or stop()"),
    Value("watchdog", "the host was silent for too long, or the bus was lost"),
    Value("deadline_missed", "a streamed local model outlived its deadline"),
    Value("fault", "a fault was latched"),
    Value("game_idle", "a game had the actuator and has nothing more to play"),
    Value("disconnected", "the device was unplugged or lost its power"),
    Value("unknown", "the device's message was lost on the way"),
    Value("excitation_over", "the time of an excitation was over and no next one had come"),
    Value("excitation_stopped", "an excitation left its bounds of travel or speed"),
    Value("dial_idle", "the dial had the actuator and nobody turns it"),
)
RESET_CAUSE = enumeration(
    "ResetCause",
    "Why the device started.",
    Value("unknown", "the board cannot tell"),
    Value("power", "it was switched on"),
    Value("brown_out", "its supply was too low for a moment"),
    Value("reset_pin", "somebody pressed reset"),
    Value("watchdog", "the main loop or the control interrupt hung"),
    Value("hard_fault", "the program did what the processor refuses"),
    Value("stack", "the program needed more stack than there is"),
)
EVENT_KIND = enumeration(
    "EventKind",
    "Kind of an event.",
    Value("state_changed", "by an order, a fault or the end of a soft stop"),
    Value("watchdog", "the host was silent for too long"),
    Value("deadline_missed", "a streamed local model outlived its deadline"),
    Value("owner_changed", "somebody else has the actuator now"),
    Value("excitation_over", "the time of an excitation was over"),
    Value("excitation_stopped", "an excitation left its bounds of travel or speed"),
    open=True,
    public=False,
)

STATUS = enumeration(
    "Status",
    "Why a report was refused. The device sends the code, the library turns it into a sentence.",
    Value("ok", "accepted", "accepted"),
    Value(
        "bad_length",
        "not exactly 64 bytes",
        "the report has the wrong length; it was damaged on the way",
    ),
    Value(
        "bad_padding",
        "bytes behind the last field are not zero: a newer layout, or garbage",
        "the report has bytes too many; it was damaged on the way",
    ),
    Value(
        "unknown_report",
        "no report of this id in this direction",
        "the device does not know this report",
    ),
    Value("not_finite", "a number is not finite", "a value is not a finite number"),
    Value(
        "out_of_range",
        "a value is outside the range given below, or beyond what this encoder or rate can do",
        "a value is outside the range that docs/reference/protocol.md gives",
    ),
    Value(
        "inconsistent",
        "each field is in range, but not together",
        "the values do not fit each other",
    ),
    Value("bad_axis", "the device has no such axis", "the device has no such axis"),
    Value(
        "empty_slot",
        "a commit names a slot that was never written",
        "the scene names a slot that was never written",
    ),
    Value(
        "not_armed", "only while armed", "the device must be armed for this: call arm() first"
    ),
    Value(
        "not_disarmed",
        "only while disarmed",
        "the device must be disarmed for this: call disarm() first",
    ),
    Value(
        "fault_latched",
        "a fault must be cleared first",
        "a fault is latched: faults() names it, clear_fault() clears it once its cause is gone",
    ),
    Value(
        "fault_persists",
        "the cause of the fault is still there",
        "the cause of the fault is still there: faults() names it",
    ),
    Value(
        "stale",
        "older than what the device already has",
        "the device already has something newer",
    ),
    Value(
        "busy", "cannot be taken now; try again", "the device has no room for it now: send it again"
    ),
    Value("not_owner", "somebody else owns the actuator", "somebody else owns the actuator now"),
    Value("unsupported", "this board cannot do it", "this board cannot do it"),
    open=True,
    public=False,
)  # fmt: skip

FAULT = Bits(
    "fault",
    "u16",
    (
        Value(
            "emergency_stop",
            "the input is open or pressed",
            "release it, or close its contact to ground, then clear the fault",
        ),
        Value(
            "over_speed",
            "faster than speed_limit_rad_s",
            "look for a scene that is too stiff or too little damped, then clear the "
            "fault; the limit is speed_limit_rad_s of the control configuration",
        ),
        Value(
            "encoder",
            "a jump, a dead channel, or two changes at once",
            "check the encoder's cable and supply, then clear the fault",
        ),
        Value(
            "actuator",
            "the power stage reports an error",
            "check supply, motor cable, temperature, and the current sensor with its wire, then "
            "clear the fault",
        ),
        Value(
            "overrun",
            "ticks were missed or took too long",
            "clear the fault; if it comes back the scene is too much for the board: play "
            "fewer effects",
        ),
        Value(
            "numeric",
            "the control law gave no finite torque",
            "stop, clear the fault, and look for extreme values in scene and configuration",
        ),
        Value(
            "current_sensor",
            "its zero leaves no room for the trip level",
            "check the sensor's supply and wire; then current_sense_v_per_a and "
            "motor_current_max_a of the board configuration: the sensor must see one and a half "
            "times that current",
        ),
        Value(
            "winding",
            "voltage, current and speed do not fit together",
            "check the current sensor, the motor's wires, the supply and the encoder's "
            "cable, then resistance, torque constant and signs in the configuration; "
            "clear the fault",
        ),
        Value(
            "temperature",
            "the motor's winding or the brake's coil is too hot, computed from its current",
            "let it cool down, then look for an unwanted current; compare "
            "motor_current_continuous_a, brake_continuous_percent and ambient_c of the board "
            "configuration with the parts; clear the fault",
        ),
        Value(
            "supply",
            "the measured voltage of the supply is not the configured one",
            "switch the supply on and measure it; then compare supply_v, supply_sense_ratio and "
            "the divider's wire with the board configuration. A fault while nobody was armed "
            "goes by itself; clear any other",
        ),
    ),
    "Faults, latched until cleared: bits of every `faults` field.",
)
FLAG = Bits(
    "flag",
    "u8",
    (
        Value("motor_saturated", "the motor gives all it can"),
        Value("brake_saturated", "the brake holds all it can"),
        Value("local_model", "a streamed local model is in force"),
        Value("passive", "fading out after silence or a deadline"),
        Value("game", "a game has the actuator"),
        Value("bounded", "less than the scene asks, so that the knob does not buzz"),
    ),
    "Bits of telemetry's `flags`; the two lowest are the state.",
    first=2,
)
