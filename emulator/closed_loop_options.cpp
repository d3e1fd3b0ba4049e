#include "emulator/closed_loop_options.hpp"

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "emulator/plant/ranges.hpp"
#include "protocol/registry.hpp"

namespace torsio::emulator {
namespace {

template <class Report>
bool decodes(const protocol::ReportBytes& bytes, Report& report) {
  return bytes[0] == protocol::Layout<Report>::id && protocol::decode(bytes, report).ok();
}

}  // namespace

PlantState state_of(const InitialState& initial) {
  require_ranges(initial, "initial: ");
  PlantState state;
  state.time_ns = static_cast<std::int64_t>(std::llround(1e9 * initial.time_s));
  state.knob_angle = Angle::from_rad(initial.angle_rad);
  state.knob_angle.revolutions += initial.revolutions;
  state.speed_rad_s.fill(initial.speed_rad_s);
  state.twist_rad[0] = initial.twist_rad;
  state.motor_torque_nm = initial.motor_torque_nm;
  state.brake_magnetic_nm = initial.brake_magnetic_nm;
  state.brake_target_nm = initial.brake_magnetic_nm;
  state.brake_coil_nm = initial.brake_magnetic_nm;
  return state;
}

bool take_report(const protocol::ReportBytes& bytes, ClosedLoopOptions& options) {
  if (decodes(bytes, options.actuator) || decodes(bytes, options.control) ||
      decodes(bytes, options.shaft)) {
    return true;
  }
  if (protocol::CurvePoints points; decodes(bytes, points)) {
    options.curve_torque_nm.insert(options.curve_torque_nm.end(), points.torque_nm.begin(),
                                   points.torque_nm.begin() + points.points);
    return true;
  }
  bool taken = false;
  protocol::for_each_report<protocol::EffectReports>([&]<class Report>(std::type_identity<Report>) {
    if (Report report; decodes(bytes, report)) {
      options.scene.emplace_back(report);
      taken = true;
    }
  });
  return taken;
}

}  // namespace torsio::emulator
