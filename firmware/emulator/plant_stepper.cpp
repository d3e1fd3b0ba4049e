#include "emulator/plant_stepper.hpp"

#include <utility>

namespace torsio::emulator {

std::unique_ptr<Stepper> make_stepper(PlantModel model, const Integration& integration) {
  switch (integration.method) {
    case Method::exact:
      return make_exact_stepper(std::move(model), integration.step_ns);
    case Method::trapezoid:
      return make_theta_stepper(std::move(model), 0.5);
    case Method::semi_implicit:
    default:
      return make_theta_stepper(std::move(model), 1.0);
  }
}

}  // namespace torsio::emulator
