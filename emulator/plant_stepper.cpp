#include "emulator/plant_stepper.hpp"

#include <stdexcept>
#include <utility>

namespace torsio::emulator {

std::unique_ptr<Stepper> make_stepper(PlantModel model, const Integration& integration) {
  switch (integration.method) {
    case Method::exact:
      return make_exact_stepper(std::move(model), integration.step_ns);
    case Method::trapezoid:
      return make_theta_stepper(std::move(model), 0.5);
    case Method::semi_implicit:
      return make_theta_stepper(std::move(model), 1.0);
    case Method::regularised:
      return make_regularised_stepper(std::move(model), integration.regularisation_rad_s);
  }
  throw std::invalid_argument("plant: unknown integration.method");
}

}  // namespace torsio::emulator
