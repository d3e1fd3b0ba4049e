/// @file
/// The emulated knob: the device's own firmware code against simulated physics, for programs and
/// tests without hardware.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "torsio/config.hpp"
#include "torsio/export.hpp"

namespace torsio {

/// One corner of a piecewise-linear function of time. The first value holds before the first knot,
/// the last one after the last. Two knots at the same time make a jump.
struct Knot {
  double time_s;
  double value;
};
using Profile = std::vector<Knot>;

/// Nobody touches the knob.
struct NoHand {};

/// A torque on the knob that does not depend on its motion.
struct TorqueHand {
  Profile torque_nm{};
};

/// A hand that holds the knob and means to move it along a path:
/// `torque = stiffness (intended - angle) + damping (intended' - speed)`, with the hand's own
/// inertia fixed to the knob.
struct ImpedanceHand {
  double inertia_kg_m2 = 0.0;
  double stiffness_nm_per_rad = 0.0;
  double damping_nm_s_per_rad = 0.0;
  Profile intended_angle_rad{{0.0, 0.0}};  ///< without jumps
};

/// The knob follows the path whatever torque that takes.
struct PrescribedMotion {
  Profile angle_rad{};  ///< without jumps
};

using Hand = std::variant<NoHand, TorqueHand, ImpedanceHand, PrescribedMotion>;

/// Part of a plant: the shaft spring is stiffer, or softer, beyond a knee of twist on both sides.
struct ShaftHardening {
  double knee_rad = 0.015;        ///< > 0
  double stiffness_factor = 2.0;  ///< > 0; stiffness beyond the knee over stiffness before it
};

/// Part: magnetic hysteresis of the brake, a play between its command and its torque.
struct BrakeHysteresis {
  double half_width_nm = 5.5e-3;  ///< >= 0
};

/// Part: a belt that stretches, between the spring's pulley and the brake.
struct Belt {
  double stiffness_nm_per_rad = 60.0;  ///< > 0
  double damping_nm_s_per_rad = 1e-3;  ///< >= 0
  double pulley_inertia_kg_m2 = 1e-5;  ///< > 0; the share of brake_inertia_kg_m2 before the belt
};

/// Part: cogging of the motor, a torque on the knob that repeats along the turn.
struct Cogging {
  int periods_per_rev = 0;  ///< >= 1
  /// At equal distances over one period from angle 0, straight lines in between; 2 to 64.
  std::vector<double> torque_nm{};
};

enum class EncoderRounding : std::uint8_t { floor, nearest };

/// Motor, knob, shaft spring, brake and encoder; docs/theory.md has the equations. Torques are seen
/// at the knob. The defaults are the reference actuator. Parts that are not named cost nothing; the
/// lags of motor and brake are always carried.
struct PlantParams {
  double knob_inertia_kg_m2 = 6e-5;  ///< motor and knob, > 0
  double knob_viscous_nm_s_per_rad = 2.6e-5;
  double knob_coulomb_nm = 6e-3;
  double brake_inertia_kg_m2 = 4e-5;  ///< pulleys and brake, > 0
  double brake_viscous_nm_s_per_rad = 2e-6;
  double brake_drag_nm = 2e-3;                ///< of the released brake
  double shaft_stiffness_nm_per_rad = 2.873;  ///< 0: the shaft is cut
  double shaft_damping_nm_s_per_rad = 2e-4;
  double brake_time_constant_s = 60e-3;
  double motor_time_constant_s = 0.1e-3;
  double motor_limit_nm = 85e-3;
  double brake_limit_nm = 110e-3;
  std::uint32_t counts_per_rev = 8192;  ///< of the encoder
  EncoderRounding encoder_rounding = EncoderRounding::floor;
  double encoder_phase_counts = 0.0;  ///< where in a count angle 0 lies
  double encoder_noise_counts = 0.0;  ///< standard deviation, >= 0; 0 leaves the noise out

  /// Part: spring and brake. false takes knob and brake for one rigid body and the brake as never
  /// engaged, which is what a law or a scene that needs no brake can do with; it saves about half
  /// of the plant's time. The parts below, but for cogging, need it.
  bool spring_and_brake = true;
  std::optional<ShaftHardening> shaft_hardening{};
  std::optional<BrakeHysteresis> brake_hysteresis{};
  std::optional<Belt> belt{};
  std::optional<Cogging> cogging{};
};

/// The device configuration that describes `plant`: a device that was calibrated perfectly.
[[nodiscard]] TORSIO_EXPORT ActuatorConfig matching_config(const PlantParams& plant);

struct EmulatorOptions {
  std::uint64_t seed = 0;           ///< of everything random: encoder noise, damaged reports
  double control_rate_hz = 1000.0;  ///< 1,000 to 20,000
  PlantParams plant{};
  Hand hand = NoHand{};
  std::string serial{};  ///< at most 16 ASCII characters; empty: derived from the device's name
  /// Configuration at power-up in place of what the device has stored, or of its defaults.
  std::optional<ActuatorConfig> actuator{};
  std::optional<ControlConfig> control{};
  std::optional<GameConfig> game{};
  /// false: time is virtual and passes only inside calls that wait, as fast as it can be computed;
  /// the same calls with the same seed give the same bytes. true: time is the wall clock's, as
  /// with hardware.
  bool paced = false;
  /// Relative error of the simulated motion that is good enough, >= 1e-9. If given, steps are exact
  /// unless a hand holds or leads the knob and cheaper ones keep the tolerance and pay; see
  /// Emulator::fidelity(). Otherwise every step is exact.
  std::optional<double> tolerance{};
  bool log_truth = false;  ///< record what no sensor sees, once a tick; see Emulator::take_truth()
};

/// What no sensor of the device sees, at the start of a control tick. Torques are on the knob.
struct TruthSample {
  double time_s;
  double angle_rad;          ///< of the knob
  double brake_angle_rad;    ///< of the far side of the shaft spring
  double speed_rad_s;        ///< of the knob
  double spring_torque_nm;   ///< of the shaft spring
  double brake_torque_nm;    ///< what the brake transmits, drag included
  double brake_capacity_nm;  ///< what it could transmit, drag included, >= 0
  double motor_torque_nm;    ///< after the motor's lag
  double hand_torque_nm;
};

/// How the motion is simulated, and how well.
struct Fidelity {
  double tolerance;        ///< that was asked for; 0: none
  std::string method;      ///< in use now: "exact", "trapezoid" or "semi_implicit"
  double step_s;           ///< in use now
  double estimated_error;  ///< relative, of knob angle and spring torque; 0 without a tolerance
  std::uint64_t steps_exact;
  std::uint64_t steps_trapezoid;
  std::uint64_t steps_semi_implicit;
  std::uint64_t steps_checked;  ///< of all, that were taken exactly as well to estimate the error
  double relative_cost;         ///< of all work, checks included, over that of exact steps alone
};

/// Damage to reports on the way, as probabilities per report.
struct LinkFaults {
  double drop_output = 0.0;  ///< host to device
  double corrupt_output = 0.0;
  double drop_input = 0.0;  ///< device to host
  double corrupt_input = 0.0;
};

/// The world round an emulated knob. Belongs to the Knob and lives as long as it does; may be used
/// from any thread. After close() its calls throw Closed.
class TORSIO_EXPORT Emulator {
 public:
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;
  virtual ~Emulator() = default;

  /// The hand takes over at the next control tick, which is time 0 of its profiles.
  /// @throws InvalidArgument that names the field; the old hand then stays
  virtual void set_hand(const Hand& hand) = 0;

  /// Device time.
  [[nodiscard]] virtual double time_s() const = 0;

  /// Lets time pass, like Knob::sleep().
  virtual void advance(double duration_s) = 0;

  /// The log since the last call; empty unless EmulatorOptions::log_truth.
  [[nodiscard]] virtual std::vector<TruthSample> take_truth() = 0;

  /// What was chosen to keep EmulatorOptions::tolerance, and the error that is estimated.
  [[nodiscard]] virtual Fidelity fidelity() const = 0;

  // The game interface, for the tests of those who talk to it: reports as bytes, each beginning
  // with its id; docs/games.md has them all. They take effect at the next control tick.
  virtual void game_write(std::span<const std::uint8_t> report) = 0;
  /// The next input report; empty if there is nothing new.
  [[nodiscard]] virtual std::vector<std::uint8_t> game_read() = 0;
  /// @returns false if the device stalls the request
  [[nodiscard]] virtual bool game_set_feature(std::span<const std::uint8_t> report) = 0;
  /// A feature report; empty if the device stalls the request.
  [[nodiscard]] virtual std::vector<std::uint8_t> game_get_feature(std::uint8_t id) = 0;
  /// Presses exactly these buttons of the game controller, bit 0 the first.
  virtual void set_game_buttons(std::uint8_t pressed) = 0;

  /// Pulls the plug. As with hardware the knob must be opened again.
  virtual void unplug() = 0;

  // Faults of the device's world.
  virtual void set_emergency_stop(bool pressed) = 0;
  virtual void set_actuator_fault(bool present) = 0;
  virtual void freeze_encoder(bool frozen) = 0;        ///< the counter stands still
  virtual void jump_encoder(std::int32_t counts) = 0;  ///< the counter is wrong from now on
  virtual void skip_ticks(
      std::uint32_t count) = 0;  ///< the control loop comes that many ticks late
  virtual void set_link_faults(const LinkFaults& faults) = 0;
  /// The next save loses power after so many bytes of its slot: the device vanishes.
  virtual void cut_power_in_next_save(std::uint32_t bytes) = 0;

 protected:
  Emulator() = default;
};

}  // namespace torsio
