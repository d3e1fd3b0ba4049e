/// @file
/// The emulated device for a browser: one of them, with functions that JavaScript can call. Reports
/// go through one buffer, the knots of a hand's path through another; durations are doubles, which
/// JavaScript has, and whole nanoseconds.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "conversion/swings.hpp"
#include "emulator/emulated_device.hpp"

namespace {

using torsio::emulator::EmulatedDevice;
using torsio::protocol::ReportBytes;

constexpr std::size_t kMostKnots = 256;

ReportBytes report{};
std::array<double, 2 * kMostKnots> knots{};
std::array<double, 9> truth{};
std::optional<EmulatedDevice> device;
std::vector<ReportBytes> scene;
std::string warning;

torsio::Profile path(std::uint32_t count) {
  torsio::Profile profile;
  for (std::size_t i = 0; i < std::min<std::size_t>(count, kMostKnots); ++i) {
    profile.push_back({.time_s = knots[2 * i], .value = knots[2 * i + 1]});
  }
  return profile;
}

void hold(const torsio::Hand& hand) {
  device->set_hand(torsio::emulator::take_hold(hand, device->next_tick_ns()));
}

}  // namespace

#define EXPORTED(name) extern "C" __attribute__((export_name(#name)))

/// Powers a new device up, at time 0.
/// @param control_period_ns 50,000 to 1,000,000
EXPORTED(start) void start(std::uint32_t seed, std::uint32_t control_period_ns) {
  torsio::emulator::EmulatedDeviceOptions options;
  options.seed = seed;
  options.control_period_ns = control_period_ns;
  options.serial = "BROWSER";
  device.emplace(options);
}

/// The 64 bytes that every report goes through.
EXPORTED(report_buffer) std::uint8_t* report_buffer() { return report.data(); }

/// The pairs (time in s, value) of a hand's path, at most 256.
EXPORTED(knot_buffer) double* knot_buffer() { return knots.data(); }

/// @returns 1, or 0 if the host's queue is full
EXPORTED(write_report) int write_report() { return device->write(report) ? 1 : 0; }

/// @returns 1, or 0 if there is nothing to read
EXPORTED(read_report) int read_report() { return device->read(report) ? 1 : 0; }

/// @returns a status, 0 is ok
EXPORTED(get_feature) int get_feature(std::uint32_t id) {
  return static_cast<int>(device->get_feature(static_cast<std::uint8_t>(id), report));
}

/// @returns a status, 0 is ok
EXPORTED(set_feature) int set_feature() {
  return static_cast<int>(device->set_feature(report).status);
}

/// Keeps the report in the buffer for swing_warning().
EXPORTED(add_to_scene) void add_to_scene() { scene.push_back(report); }

/// Judges what was kept, a scene's reports and the configurations of actuator and control, and
/// forgets it.
/// @returns a sentence that ends with 0; empty if the knob comes to rest
EXPORTED(swing_warning) const char* swing_warning(std::uint32_t control_period_ns) {
  torsio::protocol::ActuatorConfig actuator;
  torsio::protocol::ControlConfig control;
  const auto take = [](const ReportBytes& bytes, auto& config) {
    using Config = std::remove_reference_t<decltype(config)>;
    if (bytes[0] == torsio::protocol::Layout<Config>::id) (void)decode(bytes, config);
  };
  for (const ReportBytes& bytes : scene) {
    take(bytes, actuator);
    take(bytes, control);
  }
  std::atomic<double> rests_nm_per_rad{-1.0};  // parts may be others next time
  warning = torsio::conversion::swing_warning(scene, actuator, control, control_period_ns,
                                              rests_nm_per_rad);
  scene.clear();
  return warning.c_str();
}

EXPORTED(advance) void advance(double duration_ns) {
  device->advance(static_cast<std::int64_t>(duration_ns));
}

EXPORTED(time_ns) double time_ns() { return static_cast<double>(device->time_ns()); }

/// Nobody holds the knob.
EXPORTED(let_go) void let_go() { hold(torsio::NoHand{}); }

/// A hand that means to move the knob along the path in the knots.
EXPORTED(hold_softly)
void hold_softly(double inertia_kg_m2, double stiffness_nm_per_rad, double damping_nm_s_per_rad,
                 std::uint32_t count) {
  hold(torsio::ImpedanceHand{.inertia_kg_m2 = inertia_kg_m2,
                             .stiffness_nm_per_rad = stiffness_nm_per_rad,
                             .damping_nm_s_per_rad = damping_nm_s_per_rad,
                             .intended_angle_rad = path(count)});
}

/// A torque on the knob, along the knots.
EXPORTED(push) void push(std::uint32_t count) {
  hold(torsio::TorqueHand{.torque_nm = path(count)});
}

EXPORTED(set_emergency_stop) void set_emergency_stop(int pressed) {
  device->set_emergency_stop(pressed != 0);
}

/// True values that no sensor sees, now: angles of knob and brake in rad, speed in rad/s, and in N
/// m the torques of spring, brake, brake's capacity, motor and hand.
EXPORTED(take_truth) const double* take_truth() {
  const auto& state = device->plant().state();
  const auto torque = device->plant().truth();
  truth = {state.knob_angle_rad(),  state.brake_angle_rad(), state.knob_speed_rad_s(),
           torque.spring_torque_nm, torque.brake_torque_nm,  torque.brake_capacity_nm,
           torque.motor_torque_nm,  torque.hand_torque_nm,   torque.knob_friction_torque_nm};
  return truth.data();
}
