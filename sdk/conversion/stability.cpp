#include "conversion/stability.hpp"

#include "core/angle.hpp"
#include "core/stability.hpp"
#include "device/parts.hpp"

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

}  // namespace

StableStiffness stable_stiffness(const protocol::ActuatorConfig& actuator,
                                 const protocol::ControlConfig& control,
                                 std::uint32_t control_period_ns) {
  const core::Resolution resolution =
      core::make_resolution(actuator.counts_per_rev, control_period_ns);
  const core::StableStiffness found =
      core::stable_stiffness(device::parts(actuator, control, resolution));
  return {static_cast<double>(found.stiffness_nm_per_rad), name(found.limited_by)};
}

}  // namespace torsio::conversion
