#include "torsio/wire.hpp"

#include "config_encoding.hpp"
#include "protocol/codec.hpp"
#include "protocol/effects.hpp"
#include "scene_encoding.hpp"

namespace torsio {

std::vector<WireReport> wire_reports(const Scene& scene, std::uint32_t counts_per_rev,
                                     std::uint32_t control_period_ns) {
  protocol::Identity device;
  device.counts_per_rev = counts_per_rev;
  device.control_period_ns = control_period_ns;
  device.effects = protocol::max_effects;
  device.curve_points = protocol::curve_pool_points;
  const EncodedScene encoded = encode_scene(scene, device);
  std::vector<WireReport> reports;
  for (const EncodedScene::Slot& slot : encoded.slots) reports.push_back(slot.report);
  reports.insert(reports.end(), encoded.pieces.begin(), encoded.pieces.end());
  return reports;
}

WireReport wire_report(const ActuatorConfig& config) { return protocol::encode(to_wire(config)); }
WireReport wire_report(const ControlConfig& config) { return protocol::encode(to_wire(config)); }

}  // namespace torsio
