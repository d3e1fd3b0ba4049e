/// @file
/// An emulated knob: its parts, its hand, its inputs, and values that only the simulation knows.
///
/// Printed from the field lists in emulator/definition/ by `./dev generate`; change those instead.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

namespace torsio {

/// One corner of a piecewise-linear function of time. The first value holds before the first knot,
/// the last one after the last. Two knots at the same time make a jump.
struct Knot {
  double time_s;  ///< since the hand took over
  double value;   ///< of the function then
};

/// A piecewise-linear function of time: its corners in the order of their times.
using Profile = std::vector<Knot>;

/// Time since the hand took over in s, the knob's true angle in rad and its speed in rad/s, to the
/// torque on the knob in N m, -100 to 100.
using HandFunction = std::function<double(double time_s, double angle_rad, double speed_rad_s)>;

/// Nobody touches the knob.
struct NoHand {};

/// A torque on the knob that does not depend on its motion, such as a weight on a string.
struct TorqueHand {
  Profile torque_nm{{0.0, 0.0}};  ///< two knots at the same time make a jump
};

/// A hand that holds the knob and means to move it along a path: `torque = stiffness (intended -
/// angle) + damping (intended' - speed)`, with the hand's own inertia fixed to the knob.
struct ImpedanceHand {
  double inertia_kg_m2 = 0.0;  ///< of the hand; 0 to 10
  /// must be given; of the hand; 0 to 1e6
  double stiffness_nm_per_rad = std::numeric_limits<double>::quiet_NaN();
  double damping_nm_s_per_rad = 0.0;       ///< of the hand; 0 to 1000
  Profile intended_angle_rad{{0.0, 0.0}};  ///< without jumps
};

/// The knob follows the path whatever torque that takes.
struct PrescribedMotion {
  Profile angle_rad{{0.0, 0.0}};  ///< without jumps
};

/// A hand whose torque is a function of the knob's motion, such as a controller or a person's
/// model. The function is asked when the hand takes over and then once a period. It must not use
/// the knob that it holds.
struct FeedbackHand {
  HandFunction torque_nm{};  ///< the torque on the knob; held until it is asked again
  double period_s = 0.001;   ///< from one asking to the next; 1e-5 to 1
};

/// The hand on an emulated knob.
using Hand = std::variant<NoHand, TorqueHand, ImpedanceHand, PrescribedMotion, FeedbackHand>;

/// The count of an angle between two counts.
enum class EncoderRounding : std::uint8_t { floor, nearest };

/// Pulse of an encoder's index: right, never there, two in a turn, or amid sparks.
enum class IndexPulse : std::uint8_t { works, missing, doubled, noisy };

/// State of a current sensor.
enum class CurrentSensorState : std::uint8_t { works, dead, stuck, saturated };

/// Kind of input to an emulated device. In brackets: its bytes; numbers are little endian.
enum class InputKind : std::uint8_t {
  stored,          ///< content of the storage from now on (both slots)
  power,           ///< (0 or 1)
  connected,       ///< the bus (0 or 1)
  output,          ///< a report that has arrived (64 bytes)
  feature,         ///< a report (any length)
  game_output,     ///< a report of the game interface (any length)
  game_feature,    ///< the same (any length)
  buttons,         ///< pressed ones (a bit each)
  emergency_stop,  ///< (0 or 1)
  actuator_fault,  ///< (0 or 1)
  power_faults,    ///< which, as bits of the faults; 0: the one of the actuator (32 bits)
  missed_ticks,    ///< before the next one (32 bits)
  power_cut,       ///< in the next save, after so many bytes (32 bits)
  counts,          ///< of the encoder, one control tick for each (32 bits each)
  index,           ///< of the encoder (0 or 1)
};

/// Part of a plant: the shaft spring is stiffer, or softer, beyond a knee of twist on both sides.
struct ShaftHardening {
  double knee_rad = 0.015;        ///< the spring is linear up to here; > 0
  double stiffness_factor = 2.0;  ///< stiffness beyond the knee over stiffness before it; > 0
};

/// Part of a plant: magnetic hysteresis of the brake, a play between its current, which has the
/// lag, and its torque.
struct BrakeHysteresis {
  double half_width_nm = 0.0055;  ///< of the play; the default is 5 % of the brake's limit; >= 0
};

/// Part of a plant: a belt that stretches, between the spring's pulley and the brake.
struct Belt {
  double stiffness_nm_per_rad = 60.0;   ///< of the belt; > 0
  double damping_nm_s_per_rad = 0.001;  ///< of the belt; >= 0
  /// the share of brake_inertia_kg_m2 that lies before the belt; > 0
  double pulley_inertia_kg_m2 = 1e-5;
};

/// Part of a plant: cogging of the motor, a torque on the knob that repeats along the turn.
struct Cogging {
  int periods_per_rev = 0;  ///< must be given; of the torque; 1 to 65535
  /// 2 to 64 torques at equal distances over one period, from angle 0; straight lines between
  std::vector<double> torque_nm{};
};

/// Part of a plant: windings, bridges, supply and current sensor. With it the emulated device runs
/// the board's own power stage; without it motor and brake are the lags that are given.
struct Electrics {
  double winding_resistance_ohm = 2.5;   ///< of the motor, at 25 degrees; > 0
  double winding_inductance_h = 0.0015;  ///< of the motor; > 0
  /// of the motor, at the knob; V s/rad of back EMF as well; > 0
  double torque_constant_nm_per_a = 0.05;
  bool motor_reversed = false;  ///< a current into the first pin turns the knob to smaller angles
  double coil_resistance_ohm = 40.0;            ///< of the brake; > 0
  double coil_inductance_h = 2.4;               ///< of the brake; > 0
  double coil_torque_constant_nm_per_a = 0.44;  ///< of the brake, on the pulley; > 0
  double supply_v = 12.0;                       ///< without load; > 0
  double supply_resistance_ohm = 0.1;           ///< of the supply; it takes no current back; >= 0
  double supply_capacitance_f = 0.0022;         ///< behind that; > 0
  /// the supply's voltage over what a board with supply_sense_pin measures of it; > 0
  double supply_divider_ratio = 11.0;
  double ambient_c = 25.0;                ///< of the air; everything begins there; -100 to 300
  double winding_heat_j_per_k = 12.0;     ///< heat capacity of the motor's winding; > 0
  double winding_to_rotor_k_per_w = 4.0;  ///< from there to the rotor; > 0
  double rotor_heat_j_per_k = 60.0;       ///< heat capacity of the rotor; > 0
  double rotor_to_air_k_per_w = 8.0;      ///< from there to the air; > 0
  double coil_heat_j_per_k = 40.0;        ///< heat capacity of the brake's coil; > 0
  double coil_to_air_k_per_w = 20.0;      ///< from there to the air; > 0
  int pwm_steps = 1875;                   ///< of a bridge's full share; 1 to 65535
  /// of the current loop, rounded to a whole part of the control period, which 0 is; 0 to 0.001
  double current_period_s = 2.5e-5;
  /// from a measurement to the voltage that answers it; at most a period of the current loop; 1e-6
  /// to 0.001
  double output_delay_s = 2.5e-5;
  bool predictive = true;  ///< the current loop of the RP2350; false: the one of the RP2040
  /// from the beginning of a measurement until it takes the current; boards begin 1 us before the
  /// middle of the bridge's pulse; 0 to 1e-5
  double sample_offset_s = 1e-6;
  double sensor_v_per_a = 0.2;    ///< of the current sensor; > 0
  double sensor_zero_v = 1.65;    ///< its output without current; -10 to 10
  double sensor_noise_v = 0.001;  ///< standard deviation; >= 0
  double sensor_range_v = 3.3;    ///< of its converter, from 0; > 0
  int sensor_bits = 12;           ///< of its converter; 1 to 24
  /// dead: 0 V; stuck: at its zero; saturated: at the end of its range
  CurrentSensorState sensor_state = CurrentSensorState::works;
};

/// Motor, knob, shaft spring, brake and encoder of an emulated knob. Torques are at the knob. The
/// defaults are the reference actuator; docs/explanation/theory.md has the equations. Parts that
/// are not named cost nothing; the lags of motor and brake are always carried.
struct PlantParams {
  double knob_inertia_kg_m2 = 6e-5;           ///< motor and knob; > 0
  double knob_viscous_nm_s_per_rad = 2.6e-5;  ///< viscous friction there; >= 0
  double knob_coulomb_nm = 0.006;             ///< dry friction there; >= 0
  double brake_inertia_kg_m2 = 4e-5;          ///< pulleys and brake; > 0
  double brake_viscous_nm_s_per_rad = 2e-6;   ///< viscous friction there; >= 0
  double brake_drag_nm = 0.002;               ///< drag of the released brake; >= 0
  double shaft_stiffness_nm_per_rad = 2.873;  ///< 0: the shaft is cut; >= 0
  double shaft_damping_nm_s_per_rad = 2e-4;   ///< of the shaft; >= 0
  double brake_time_constant_s = 0.06;        ///< from command to torque; 0: no lag; >= 0
  double motor_time_constant_s = 4.4e-5;      ///< from command to torque; 0: no lag; >= 0
  double motor_limit_nm = 0.085;              ///< commands are clipped to it, both ways; >= 0
  double brake_limit_nm = 0.11;               ///< commands are clipped to it; >= 0
  std::uint32_t counts_per_rev = 8192;        ///< of the encoder; 1 to 16777216
  EncoderRounding encoder_rounding = EncoderRounding::floor;  ///< how the encoder counts
  /// the pulse at the encoder's count 0, for a device with encoder_index_pin
  IndexPulse encoder_index = IndexPulse::works;
  double encoder_phase_counts = 0.0;  ///< where in a count angle 0 lies
  double encoder_noise_counts = 0.0;  ///< standard deviation; 0 leaves the noise out; >= 0
  /// part: spring and brake. Without it knob and brake are one rigid body and the brake never
  /// engages. This suits the law motor_only and saves about a third of the plant's time. All parts
  /// below except cogging need it
  bool spring_and_brake = true;
  std::optional<ShaftHardening> shaft_hardening{};    ///< part: the spring has knees
  std::optional<BrakeHysteresis> brake_hysteresis{};  ///< part: play in the brake
  std::optional<Belt> belt{};                         ///< part: the belt stretches
  std::optional<Cogging> cogging{};                   ///< part: the motor cogs
  std::optional<Electrics> electrics{};               ///< part: windings, bridges, supply, sensor
};

/// Damage to reports on the cable of an emulated knob, as probabilities for each report.
struct LinkFaults {
  double drop_output = 0.0;     ///< host to device; 0 to 1
  double corrupt_output = 0.0;  ///< a bit of it is another; 0 to 1
  double drop_input = 0.0;      ///< device to host; 0 to 1
  double corrupt_input = 0.0;   ///< a bit of it is another; 0 to 1
};

/// True values of an emulated knob at the start of a control tick. Torques on the knob.
struct TruthSample {
  double time_s;             ///< device time
  double angle_rad;          ///< of the knob
  double brake_angle_rad;    ///< of the far side of the shaft spring
  double speed_rad_s;        ///< of the knob
  double spring_torque_nm;   ///< of the shaft spring
  double brake_torque_nm;    ///< torque that the brake transmits, drag included
  double brake_capacity_nm;  ///< most that it could transmit, drag included, >= 0
  double motor_torque_nm;    ///< after the motor's lag
  double hand_torque_nm;     ///< of the hand on the knob
};

/// True electric values of an emulated knob, now.
struct ElectricsState {
  double motor_current_a = 0.0;  ///< positive turns the knob to larger angles
  double coil_current_a = 0.0;   ///< of the brake
  double supply_v = 0.0;         ///< at the bridges
  double winding_c = 0.0;        ///< temperature of the motor's winding
  double rotor_c = 0.0;          ///< of its rotor
  double coil_c = 0.0;           ///< of the brake's coil
};

/// Something that entered an emulated device, so that it can run again.
struct DeviceInput {
  std::uint64_t tick = 0;  ///< control ticks that had run before it, since the first power-up
  InputKind kind = InputKind::stored;  ///< its kind
  /// its content: a report, or as its kind has it; of counts one control tick for each, in 32 bits,
  /// little endian
  std::vector<std::uint8_t> bytes{};
};

/// Serial number of an emulated or virtual knob that is told no other.
inline constexpr std::string_view kEmulatedSerial = "EMULATED";

}  // namespace torsio
