// The cost of a shaft's knees in a tick of the law calibrated. It is a program of its own: other
// code would change the compiler's choice of registers.
#include <cstdint>
#include <new>
#include <string_view>

#include "measure.hpp"
#include "scenes.hpp"

namespace {

using namespace torsio;
using mcu::Bench;

alignas(Bench) unsigned char room[sizeof(Bench)];

// The measured ticks are at least so far from here that they stay beyond the knee: those that cross
// it are rare.
constexpr std::uint32_t kRelaxedCount = 100;

volatile float motor_nm;
volatile float brake_nm;

void run(std::string_view name, const protocol::ShaftConfig& shaft) {
  Bench& bench = *new (room) Bench(50'000);
  (void)bench.tick(kRelaxedCount);
  protocol::ActuatorConfig actuator;
  actuator.brake_torque_max_nm = 1;
  actuator.brake_drag_nm = 1;
  actuator.spring_stiffness_nm_per_rad = 0.1F;
  bench.set(actuator);
  protocol::ControlConfig config;
  config.law = protocol::Law::calibrated;
  config.passive_ramp_s = 0;
  config.watchdog_s = 60;
  bench.set(config);
  bench.set(shaft);
  protocol::Wall wall{{1, 0, 0}};
  wall.side = protocol::Side::below;
  wall.angle_turns_q32 = std::int64_t{1} << 30;
  wall.stiffness_nm_per_rad = 0.01F;
  wall.damping_nm_s_per_rad = 1e-4F;
  bench.send(wall);
  bench.send(protocol::Commit{1, 0, 1});
  bench.command(protocol::Op::arm);
  for (int i = 0; i < 300; ++i) (void)bench.tick(kRelaxedCount);
  if (bench.device().state() != protocol::State::armed) mcu::print("not armed\n");
  mcu::measure(name, 1, [&bench](std::uint32_t count) {
    const device::TickOutputs out = bench.tick(count);
    motor_nm = out.motor_command_nm;
    brake_nm = out.brake_command_nm;
  });
}

}  // namespace

int main() {
  protocol::ShaftConfig bent;
  bent.knee_1_rad = 0.01F;
  bent.knee_1_nm_per_rad = 0.15F;
  run("straight shaft", {});
  run("bent shaft", bent);
}
