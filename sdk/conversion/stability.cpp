#include "conversion/stability.hpp"

#include "core/angle.hpp"
#include "core/stability.hpp"
#include "device/wall_parts.hpp"

namespace torsio::conversion {
namespace {

const char* name(core::StabilityLimit limit) {
  switch (limit) {
    case core::StabilityLimit::rate:
      return "rate";
    case core::StabilityLimit::lag:
      return "lag";
    case core::StabilityLimit::counts:
      return "counts";
  }
  return "";
}

/// The controller's equation has an encoder without steps. But a swing at its edge is only some
/// counts wide. Every count is a step of the torque that comes late as a whole, the later the more
/// volts it needs. Together both limits give less than either, as two springs in series;
/// tests/studies/test_bench_stiffness.py tries it with the boards' electrics.
double with_steps(double stiffness_nm_per_rad, const core::Parts& parts) {
  if (!core::moves_knob(parts.motor_torque_max_nm, parts.knob_coulomb_nm)) {
    return stiffness_nm_per_rad;
  }
  const double whole_motor_in_a_count =
      static_cast<double>(parts.motor_torque_max_nm) / static_cast<double>(parts.rad_per_count);
  return stiffness_nm_per_rad * whole_motor_in_a_count /
         (stiffness_nm_per_rad + whole_motor_in_a_count);
}

}  // namespace

StableStiffness stable_stiffness(const protocol::ActuatorConfig& actuator,
                                 const protocol::ControlConfig& control,
                                 std::uint32_t control_period_ns) {
  const core::Resolution resolution =
      core::make_resolution(actuator.counts_per_rev, control_period_ns);
  const core::Parts parts = device::wall_parts(actuator, control, resolution);
  const core::StableStiffness found = core::stable_stiffness(parts);
  return {with_steps(static_cast<double>(found.stiffness_nm_per_rad), parts),
          name(found.limited_by)};
}

}  // namespace torsio::conversion
