// Configurations as they travel, those that fit an emulated plant, and refusals of a shaft's.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>

#include "conversion/configuration.hpp"
#include "known_boards.hpp"
#include "protocol/codec.hpp"
#include "torsio/emulator.hpp"
#include "torsio/error.hpp"

using namespace torsio;
using conversion::convert_back;
using conversion::to_wire;

namespace {

constexpr std::uint8_t kPico = 1;
constexpr std::uint8_t kPico2 = 2;

}  // namespace

TEST_CASE("every field of the configuration comes back") {
  const protocol::ActuatorConfig actuator = to_wire(ActuatorConfig{.motor_torque_max_nm = 1,
                                                                   .brake_torque_max_nm = 2,
                                                                   .brake_torque_min_nm = 0.5,
                                                                   .brake_drag_nm = 0.25,
                                                                   .brake_time_constant_s = 4,
                                                                   .spring_stiffness_nm_per_rad = 8,
                                                                   .counts_per_rev = 16,
                                                                   .counter_bits = 24,
                                                                   .encoder_reversed = true});
  CHECK(protocol::encode(to_wire(convert_back<ActuatorConfig>(actuator))) ==
        protocol::encode(actuator));

  const protocol::ControlConfig control = to_wire(ControlConfig{.law = Law::parallel,
                                                                .beta = 0.25,
                                                                .speed_bandwidth_hz = 2,
                                                                .motor_torque_cap_nm = 3,
                                                                .brake_torque_cap_nm = 4,
                                                                .motor_slew_nm_per_s = 5,
                                                                .speed_limit_rad_s = 6,
                                                                .watchdog_s = 7,
                                                                .passive_ramp_s = 8,
                                                                .passive_brake_nm = 9,
                                                                .autonomous = true});
  CHECK(protocol::encode(to_wire(convert_back<ControlConfig>(control))) ==
        protocol::encode(control));
}

TEST_CASE("every field of the board's configuration comes back") {
  const protocol::BoardConfig board = to_wire(BoardConfig{.supply_v = 24,
                                                          .motor_torque_constant_nm_per_a = 0.5,
                                                          .motor_current_max_a = 3,
                                                          .motor_resistance_ohm = 4,
                                                          .motor_inductance_h = 0.25,
                                                          .current_bandwidth_hz = 5,
                                                          .current_sense_v_per_a = 6,
                                                          .brake_torque_constant_nm_per_a = 7,
                                                          .brake_current_max_a = 8,
                                                          .brake_resistance_ohm = 9,
                                                          .motor_reversed = true,
                                                          .supply_sense_ratio = 16,
                                                          .encoder_pin = 3,
                                                          .motor_pin = 14,
                                                          .brake_pin = 16,
                                                          .enable_pin = 18,
                                                          .emergency_stop_pin = 19,
                                                          .driver_fault_pin = 20,
                                                          .current_sense_pin = 28,
                                                          .supply_sense_pin = 27,
                                                          .light_pin = 29});
  CHECK(protocol::encode(to_wire(convert_back<BoardConfig>(board))) == protocol::encode(board));
  CHECK(to_wire(convert_back<BoardConfig>(board), wiring_rule(kPico2)).motor_pin == 14);
  CHECK_THROWS_WITH_AS(to_wire(convert_back<BoardConfig>(board), wiring_rule(kPico)),
                       doctest::Contains("motor_pin is 14: the next pin"), InvalidArgument);
}

TEST_CASE("the emulated plant is the reference actuator by default, and its configuration fits") {
  const PlantParams plant;
  CHECK(plant.knob_inertia_kg_m2 == 6e-5);
  CHECK(plant.knob_viscous_nm_s_per_rad == 2.6e-5);
  CHECK(plant.knob_coulomb_nm == 6e-3);
  CHECK(plant.brake_inertia_kg_m2 == 4e-5);
  CHECK(plant.brake_viscous_nm_s_per_rad == 2e-6);
  CHECK(plant.brake_drag_nm == 2e-3);
  CHECK(plant.shaft_stiffness_nm_per_rad == 2.873);
  CHECK(plant.shaft_damping_nm_s_per_rad == 2e-4);
  CHECK(plant.brake_time_constant_s == 60e-3);
  CHECK(plant.motor_time_constant_s == 44e-6);
  CHECK(plant.motor_limit_nm == 85e-3);
  CHECK(plant.brake_limit_nm == 110e-3);
  CHECK(protocol::encode(to_wire(matching_config(plant))) ==
        protocol::encode(protocol::ActuatorConfig{}));
}

TEST_CASE("a plant with a simple current loop has a Pico's lag") {
  PlantParams plant;
  plant.electrics = Electrics{};
  CHECK(matching_config(plant).motor_time_constant_s == 44e-6);
  plant.electrics->predictive = false;
  CHECK(matching_config(plant).motor_time_constant_s == 0.16e-3);
}

TEST_CASE("a shaft's curve must grow, and a refusal says where it does not") {
  const auto refusal = [](const ShaftConfig& config) {
    try {
      (void)to_wire(config);
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal({}) == "accepted");
  CHECK(refusal({.knee_1_rad = 0.02,
                 .knee_1_nm_per_rad = 3,
                 .knee_2_rad = 0.03,
                 .knee_2_nm_per_rad = 1}) == "accepted");
  CHECK(refusal({.knee_1_rad = 0.02}) ==
        "knee_1_nm_per_rad is 0: the torque must grow beyond a knee");
  CHECK(refusal({.knee_1_rad = 0.02,
                 .knee_1_nm_per_rad = 3,
                 .knee_2_rad = 0.02,
                 .knee_2_nm_per_rad = 4}) ==
        "knee_2_rad is 0.02, not beyond the knee before it, which is at 0.02");
  CHECK(refusal({.knee_3_rad = 0.02, .knee_3_nm_per_rad = 3}) ==
        "knee_3_rad is 0.02, but there is no knee before it: give knee_2_rad first");
  PlantParams plant;
  CHECK(matching_shaft(plant).knee_1_rad == 0.0);
  plant.shaft_hardening = ShaftHardening{.knee_rad = 0.01, .stiffness_factor = 3.0};
  CHECK(matching_shaft(plant).knee_1_rad == 0.01);
  CHECK(matching_shaft(plant).knee_1_nm_per_rad == doctest::Approx(3.0 * 2.873));
}
