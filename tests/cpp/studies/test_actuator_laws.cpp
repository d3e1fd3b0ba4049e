// The arrangement and the law of every rival actuator against the equations of
// docs/results/actuators.md, worked out by hand.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "actuators/actuator.hpp"

namespace {

using namespace torsio::studies::actuators;

constexpr double kCountRad = 2.0 * std::numbers::pi / 8192.0;
constexpr double kFortyCountsNm = 40.0 * kCountRad * 1.0;  // of the soft spring, 1 N m/rad
constexpr double kCountNm = kCountRad * 2.873;             // of the stiff spring, 2.873 N m/rad
// 20 mN m, held for 1 ms by a brake of 60 ms.
const double kAfterOneTickNm = 0.02 * -std::expm1(-1.0 / 60.0);
const double kHandover = -std::expm1(-1e-3 / 0.1);

struct Tick {
  Senses senses;
  MachineCommand expected;
};

Senses at(std::int64_t knob_counts, double desired_nm, std::int64_t far_counts = 0) {
  return {knob_counts, far_counts, 0.0, desired_nm};
}

Senses pushed(double hand_nm, double desired_nm) { return {0, 0, hand_nm, desired_nm}; }

MachineCommand motor(double torque_nm) {
  MachineCommand command;
  command.motor_command_nm = torque_nm;
  return command;
}

MachineCommand both(double motor_nm, double forward_nm, double backward_nm, double source = 0.0) {
  MachineCommand command = motor(motor_nm);
  command.brake_forward_command_nm = forward_nm;
  command.brake_backward_command_nm = backward_nm;
  command.source_speed_rad_s = source;
  return command;
}

void check(Kind kind, const std::vector<Tick>& ticks, const Environment& environment = {}) {
  LawOf law(kind, Parts{}, environment, 8192, 1'000'000);
  CAPTURE(std::string(name_of(kind)));
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    CAPTURE(i);
    const MachineCommand found = law(ticks[i].senses);
    const MachineCommand& expected = ticks[i].expected;
    CHECK(found.motor_command_nm ==
          doctest::Approx(expected.motor_command_nm).scale(0.01).epsilon(1e-6));
    CHECK(found.brake_forward_command_nm ==
          doctest::Approx(expected.brake_forward_command_nm).scale(0.01).epsilon(1e-6));
    CHECK(found.brake_backward_command_nm ==
          doctest::Approx(expected.brake_backward_command_nm).scale(0.01).epsilon(1e-6));
    CHECK(found.source_speed_rad_s == expected.source_speed_rad_s);
  }
}

}  // namespace

TEST_CASE("actuator law: a motor alone gives what is wanted") {
  check(Kind::motor_only, {{at(0, 0.0), motor(0.0)}, {at(5, -0.04), motor(-0.04)}});
}

TEST_CASE("actuator law: a brake alone holds while the knob's last motion was into the wall") {
  check(Kind::brake_only, {
                              {at(0, -0.04), both(0, 0, 0)},  // it has not moved yet
                              {at(1, -0.04), both(0, 0, 0)},  // one count is no motion
                              {at(2, -0.04), both(0, 0.04, 0.04)},
                              {at(1, -0.04), both(0, 0.04, 0.04)},
                              {at(0, -0.04), both(0, 0, 0)},
                              {at(0, 0.04), both(0, 0.04, 0.04)},  // against this it presses
                          });
}

TEST_CASE("actuator law (a): the motor gives what the brake's half does not yet") {
  check(Kind::parallel, {
                            {at(0, 0.0), motor(0.0)},
                            {at(2, -0.04), both(-0.04, 0.02, 0.02)},
                            {at(3, -0.04), both(-0.04 + kAfterOneTickNm, 0.02, 0.02)},
                            {at(1, -0.04), motor(-0.04)},
                        });
}

TEST_CASE("actuator law (b): the brake takes part while the hand pushes harder than the wall") {
  // 3 mN m harder, in whichever direction; motion does not matter.
  check(Kind::parallel_torque_sensor, {
                                          {pushed(0.0431, -0.04), both(-0.04, 0.02, 0.02)},
                                          {pushed(0.0429, -0.04), motor(-0.04)},
                                          {pushed(-0.06, -0.04), motor(-0.04)},
                                          {pushed(0.06, 0.04), motor(0.04)},
                                      });
  check(Kind::parallel_torque_sensor,
        {
            {pushed(-0.0431, 0.04), both(0.04, 0.02, 0.02)},
            {pushed(-0.0431, 0.04), both(0.04 - kAfterOneTickNm, 0.02, 0.02)},
        });
}

TEST_CASE("actuator law (c): the motor adds what the spring's torque lacks") {
  // Td + (Td - Ts); the spring pulls the knob back where that is ahead of the far shaft.
  check(Kind::series_elastic_motor, {
                                        {at(50, -0.04, 10), motor(-0.08 + kFortyCountsNm)},
                                        {at(10, -0.04, 50), motor(-0.08 - kFortyCountsNm)},
                                        {at(10, 0.0, 10), motor(0.0)},
                                    });
}

TEST_CASE("actuator law (c): the brake holds while its spring pulls the way that is wanted") {
  check(Kind::series_elastic_brake, {
                                        {at(50, -0.04, 10), both(0, 0.04, 0.04)},
                                        {at(10, -0.04, 50), both(0, 0, 0)},
                                        {at(10, 0.04, 50), both(0, 0.04, 0.04)},
                                    });
}

TEST_CASE("actuator law (d): the clutch takes all, and its source turns the way that is wanted") {
  check(Kind::differential_clutch, {
                                       {at(0, -0.04), both(0, 0.04, 0.04, -30.0)},
                                       {at(9, 0.03), both(0, 0.03, 0.03, 30.0)},
                                       {at(0, 0.0), both(0, 0, 0)},
                                   });
}

TEST_CASE("actuator law (e): the motor gives what spring and brake do not") {
  check(Kind::soft_spring, {
                               {at(50, -0.04, 10), both(-0.04 + kFortyCountsNm, 0.04, 0.04)},
                               {at(10, -0.04, 50), motor(-0.04)},
                               {at(50, 0.0, 10), motor(kFortyCountsNm)},  // against the drag
                           });
}

TEST_CASE("actuator law (f): this device's own, on the sensor's torque") {
  // Far inside a soft wall, where it asks for 40 mN m whatever the knob does.
  const Environment deep{.stiffness_nm_per_rad = 4e-5, .angle_rad = -1000.0};
  const MachineCommand at_rest = both(-0.04, 0.02, 0.02);
  const MachineCommand pressed = both(-0.04 + kCountNm, 0.02, 0.02);
  // Once the brake holds: one count in, and two back. The sensor goes from -1 to +1 count.
  std::vector<Tick> ticks(40, {at(0, 0.0), at_rest});
  ticks.push_back({at(1, 0.0), pressed});
  ticks.push_back({at(-1, 0.0), motor(-0.04)});
  check(Kind::soft_sensor_paper, ticks, deep);
  ticks.back().expected = motor(-0.04 - kCountNm);
  check(Kind::soft_sensor_compensated, ticks, deep);
  check(Kind::soft_sensor_calibrated, ticks, deep);
}

TEST_CASE("actuator law (f): a part that this device would refuse is refused") {
  Parts parts;
  parts.beta = 2.0;
  CHECK_THROWS_AS(LawOf(Kind::soft_sensor_paper, parts, {}, 8192, 1'000'000),
                  std::invalid_argument);
}

TEST_CASE("actuator law: of two one-way brakes that works which resists motion into the wall") {
  check(Kind::one_way_brakes, {
                                  {at(0, 0.0), motor(0.0)},
                                  {at(2, -0.04), both(-0.04, 0.02, 0)},
                                  {at(3, -0.04), both(-0.04 + kAfterOneTickNm, 0.02, 0)},
                                  {at(1, -0.04), motor(-0.04)},
                              });
  check(Kind::one_way_brakes, {{at(0, 0.0), motor(0.0)}, {at(-2, 0.04), both(0.04, 0, 0.02)}});
}

TEST_CASE("actuator law: the brake answers first, and the motor takes over by and by") {
  const double first = 0.04 * kHandover;
  const double second = first + (0.04 - first) * kHandover;
  check(Kind::transfer_function, {
                                     {at(0, 0.0), motor(0.0)},
                                     {at(2, -0.04), both(-first, 0.04 - first, 0.04 - first)},
                                     {at(3, -0.04), both(-second, 0.04 - second, 0.04 - second)},
                                     {at(1, -0.04), motor(-0.04)},  // the way out is the motor's
                                 });
}

TEST_CASE("actuator: every arrangement has its parts where the page says") {
  struct Row {
    Kind kind;
    double knob_kg_m2, knob_coulomb_nm, far_kg_m2, spring_nm_per_rad;
    Seat motor, brake;
    double brake_s = 60e-3;
  };
  // Knob 2e-5 kg m2 and 1 mN m, rotor 4e-5 and 5 mN m, brake 4e-5.
  const std::vector<Row> rows{
      {Kind::motor_only, 6e-5, 6e-3, 0, 0, Seat::knob, Seat::nowhere},
      {Kind::brake_only, 6e-5, 1e-3, 0, 0, Seat::nowhere, Seat::knob},
      {Kind::parallel, 10e-5, 6e-3, 0, 0, Seat::knob, Seat::knob},
      {Kind::parallel_torque_sensor, 10e-5, 6e-3, 0, 0, Seat::knob, Seat::knob},
      {Kind::series_elastic_motor, 2e-5, 1e-3, 4e-5, 1.0, Seat::far_shaft, Seat::nowhere},
      {Kind::series_elastic_brake, 2e-5, 1e-3, 4e-5, 1.0, Seat::nowhere, Seat::far_shaft},
      {Kind::differential_clutch, 2e-5, 1e-3, 4e-5, 2.873, Seat::nowhere, Seat::far_shaft, 5e-3},
      {Kind::soft_spring, 6e-5, 6e-3, 4e-5, 1.0, Seat::knob, Seat::far_shaft},
      {Kind::soft_sensor_paper, 6e-5, 6e-3, 4e-5, 2.873, Seat::knob, Seat::far_shaft},
      {Kind::soft_sensor_compensated, 6e-5, 6e-3, 4e-5, 2.873, Seat::knob, Seat::far_shaft},
      {Kind::soft_sensor_calibrated, 6e-5, 6e-3, 4e-5, 2.873, Seat::knob, Seat::far_shaft},
      {Kind::one_way_brakes, 10e-5, 6e-3, 0, 0, Seat::knob, Seat::knob},
      {Kind::transfer_function, 10e-5, 6e-3, 0, 0, Seat::knob, Seat::knob},
  };
  REQUIRE(rows.size() == kKinds);
  for (const Row& row : rows) {
    CAPTURE(std::string(name_of(row.kind)));
    const MachineParams machine = machine_params(row.kind, Parts{});
    CHECK(machine.knob.inertia_kg_m2 == doctest::Approx(row.knob_kg_m2));
    CHECK(machine.knob.coulomb_nm == doctest::Approx(row.knob_coulomb_nm));
    CHECK(machine.has_far_shaft == (row.far_kg_m2 > 0.0));
    if (machine.has_far_shaft) {
      CHECK(machine.far_shaft.inertia_kg_m2 == doctest::Approx(row.far_kg_m2));
      CHECK(machine.stiffness_nm_per_rad == row.spring_nm_per_rad);
    }
    CHECK(machine.motor == row.motor);
    CHECK(machine.brake == row.brake);
    CHECK(machine.brake_time_constant_s == row.brake_s);
  }
}
