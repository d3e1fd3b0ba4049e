// As bench.cpp, for the control law alone: encoder count to torques, without the device around it.
#include <cstdint>

#include "core/controller.hpp"
#include "device/config.hpp"
#include "measure.hpp"

namespace {

using namespace torsio;

core::ControllerState state;
core::Scene scene;
core::ControllerParams params;
volatile float motor_nm;

}  // namespace

int main() {
  params = device::make_loop_config({}, 50'000).controller;
  for (std::uint8_t slot = 0; slot < core::kMaxEffects; ++slot) {
    scene.effect[slot] = core::Wall{core::make_origin(0, 8192), -1.0F, 0.01F, 1e-4F};
    scene.order[slot] = slot;
  }
  const auto tick = [](std::uint32_t count) {
    const core::Plan plan{{&scene}, core::Pipeline::plain};
    motor_nm = core::control(state, params, plan, count).motor_command_nm;
  };
  for (const unsigned effects : {0U, 1U, 2U, 16U}) {
    scene.active = static_cast<std::uint8_t>(effects);
    mcu::measure("control law, walls", effects, tick);
  }
}
