#include "emulator/closed_loop_options.hpp"

#include <type_traits>

#include "protocol/registry.hpp"

namespace torsio::emulator {
namespace {

template <class Report>
bool decodes(const protocol::ReportBytes& bytes, Report& report) {
  return bytes[0] == protocol::Layout<Report>::id && protocol::decode(bytes, report).ok();
}

}  // namespace

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
