// torsio._torsio.core, second part: the scene. It is given as the reports that carry its effects,
// and prepared for the tick by the device's own code.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "bytes.hpp"
#include "core/scene.hpp"
#include "device/prepare.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "protocol/codec.hpp"
#include "protocol/registry.hpp"
#include "torsio/error.hpp"

namespace torsio::bindings {
namespace {

using Counts = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;

struct StudyScene {
  core::Scene scene;
  core::Resolution resolution;
};

void require(const protocol::Verdict& verdict, std::string_view report) {
  if (verdict.ok()) return;
  throw InvalidArgument(std::string(report) + ": not a report that a device would take (status " +
                        std::to_string(static_cast<int>(verdict.status)) + ", field " +
                        std::to_string(verdict.field) + ")");
}

/// @returns false if the bytes are not this report
template <class Report>
bool put_effect(StudyScene& into, std::span<const std::uint8_t> bytes) {
  using Layout = protocol::Layout<Report>;
  if (bytes.size() != protocol::report_size || bytes[0] != Layout::id) return false;
  Report report{};
  require(protocol::decode(bytes, report), Layout::name);
  require(device::prepare(report, into.resolution, into.scene.effect[report.target.slot]),
          Layout::name);
  return true;
}

bool put_points(StudyScene& into, std::span<const std::uint8_t> bytes) {
  using Layout = protocol::Layout<protocol::CurvePoints>;
  if (bytes.size() != protocol::report_size || bytes[0] != Layout::id) return false;
  protocol::CurvePoints points;
  require(protocol::decode(bytes, points), Layout::name);
  if (points.first_point + points.points > core::kCurvePoolPoints) {
    throw InvalidArgument("curve_points: runs past the end of the pool");
  }
  const auto values = std::span(points.torque_nm).first(points.points);
  std::copy(values.begin(), values.end(), into.scene.curve_torque_nm.begin() + points.first_point);
  return true;
}

std::unique_ptr<StudyScene> make_scene(const py::iterable& reports, std::uint32_t counts_per_rev,
                                       std::uint32_t period_ns) {
  if (counts_per_rev == 0 || period_ns == 0) {
    throw InvalidArgument("counts_per_rev and period_ns must be > 0");
  }
  auto made = std::make_unique<StudyScene>();
  made->resolution = core::make_resolution(counts_per_rev, period_ns);
  for (const py::handle item : reports) {
    const auto bytes = bytes_of(item);
    bool known = put_points(*made, bytes);
    protocol::for_each_report<protocol::EffectReports>(
        [&]<class Report>(std::type_identity<Report>) {
          known = known || put_effect<Report>(*made, bytes);
        });
    if (!known) throw InvalidArgument("not the report of an effect");
  }
  for (std::uint8_t slot = 0; slot < core::kMaxEffects; ++slot) {
    if (std::holds_alternative<std::monostate>(made->scene.effect[slot])) continue;
    made->scene.order[made->scene.active++] = slot;
  }
  return made;
}

py::array_t<float> evaluate_record(const StudyScene& scene, core::SceneState& state,
                                   const core::MotionParams& params, core::MotionState& motion,
                                   const Counts& encoder_count, std::uint64_t first_tick) {
  if (encoder_count.ndim() != 1) throw py::value_error("encoder_count needs one dimension");
  py::array_t<float> torque_nm(encoder_count.size());
  const std::uint32_t* count = encoder_count.data();
  float* torque = torque_nm.mutable_data();
  const Unlocked unlocked;
  for (py::ssize_t i = 0; i < encoder_count.size(); ++i) {
    torque[i] =
        core::evaluate_scene(scene.scene, state, core::track_motion(motion, params, count[i]),
                             scene.resolution, first_tick + static_cast<std::uint64_t>(i));
  }
  return torque_nm;
}

}  // namespace

void bind_scene(py::module_& parent) {
  auto module = parent.attr("core").cast<py::module_>();
  py::class_<StudyScene>(module, "Scene")
      .def(py::init(&make_scene), arg("reports"), py::kw_only(),
           arg("counts_per_rev") = protocol::Identity{}.counts_per_rev,
           arg("period_ns") = protocol::emulated_control_period_ns)
      .def_property_readonly("active",
                             [](const StudyScene& scene) { return int{scene.scene.active}; });
  py::class_<core::SceneState>(module, "SceneState").def(py::init<>());
  module.def(
      "evaluate_scene",
      [](const StudyScene& scene, core::SceneState& state, const core::Motion& motion,
         std::uint64_t tick) {
        return core::evaluate_scene(scene.scene, state, motion, scene.resolution, tick);
      },
      arg("scene"), arg("state"), arg("motion"), arg("tick"),
      "One tick: sum of the effects' torques on the knob, N m.");
  module.def("evaluate_scene_record", &evaluate_record, arg("scene"), arg("state"),
             arg("motion_params"), arg("motion_state"), arg("encoder_count"), py::kw_only(),
             arg("first_tick") = 0,
             "track_motion and evaluate_scene over a record of counts; shape (n,).");
}

}  // namespace torsio::bindings
