#include "steppers/steppers.hpp"

#include <cstdint>
#include <stdexcept>
#include <utility>

#include "narrow/exact/stepper.hpp"

namespace torsio::studies {

namespace {

void refuse_electrics(const emulator::PlantModel& model) {
  if (model.back_emf_nm_s_per_rad == 0.0) return;
  throw std::invalid_argument(
      "plant: this stepper knows no electrics; leave them out, or take the exact stepper");
}

}  // namespace

emulator::MakeStepper stepper_by_name(const std::string& name) {
  if (name == "trapezoid" || name == "semi_implicit") {
    const double theta = name == "trapezoid" ? 0.5 : 1.0;
    return [theta](emulator::PlantModel model, std::int64_t) {
      refuse_electrics(model);
      return make_theta_stepper(std::move(model), theta);
    };
  }
  if (name == "regularised") {
    return [](emulator::PlantModel model, std::int64_t) {
      refuse_electrics(model);
      return make_regularised_stepper(std::move(model), kSmoothingRadS);
    };
  }
  if (name == "exact_single") return emulator::narrow::make_exact_stepper;
  throw std::invalid_argument(
      "a stepper is 'exact_single', 'trapezoid', 'semi_implicit' or 'regularised', not '" + name +
      "'");
}

}  // namespace torsio::studies
