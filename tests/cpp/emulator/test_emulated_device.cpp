// The emulated device as a whole: repeatable, indifferent to how time is cut, and faulty on demand.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "emulator/emulated_device.hpp"
#include "protocol/axis_samples.hpp"
#include "protocol/registry.hpp"

namespace device = torsio::device;
namespace protocol = torsio::protocol;
using namespace torsio::emulator;
using protocol::ReportBytes;

namespace {

constexpr std::int64_t kMs = 1'000'000;

template <class Report>
void send(EmulatedDevice& device, const Report& report) {
  REQUIRE(device.write(protocol::encode(report)));
}

void command(EmulatedDevice& device, protocol::Op op, std::uint16_t sequence = 1) {
  send(device, protocol::Command{sequence, 0, op});
}

std::vector<ReportBytes> read_all(EmulatedDevice& device) {
  std::vector<ReportBytes> reports;
  ReportBytes report;
  while (device.read(report)) reports.push_back(report);
  return reports;
}

template <class Report>
std::vector<Report> only(const std::vector<ReportBytes>& reports) {
  std::vector<Report> found;
  Report report{};
  for (const ReportBytes& bytes : reports) {
    if (protocol::decode(bytes, report).ok()) found.push_back(report);
  }
  return found;
}

template <class Report>
Report feature(const EmulatedDevice& device) {
  ReportBytes bytes;
  REQUIRE(device.get_feature(protocol::Layout<Report>::id, bytes) == protocol::Status::ok);
  Report report{};
  REQUIRE(protocol::decode(bytes, report).ok());
  return report;
}

/// Pushes into a wall with everything random switched on, and returns every byte the host saw.
std::vector<ReportBytes> push_into_wall(std::uint64_t seed, std::int64_t cut_ns) {
  EmulatedDevice device({.seed = seed,
                         .control_period_ns = 100'000,
                         .encoder = {.noise_counts = 0.5},
                         .hand = TorqueHand{Profile({{0, 0.0}, {50 * kMs, 0.06}})}});
  device.set_link_faults({.drop_input = 0.05, .corrupt_input = 0.05});
  command(device, protocol::Op::arm);
  send(device, protocol::Wall{.target = {2, 0, 0}, .stiffness_nm_per_rad = 1.0F});
  send(device, protocol::Commit{3, 0, 1});
  send(device, protocol::Stream{4, 0, 10});
  std::vector<ReportBytes> reports;
  for (std::int64_t left = 100 * kMs; left > 0; left -= cut_ns) {
    device.advance(std::min(left, cut_ns));
    for (const ReportBytes& report : read_all(device)) reports.push_back(report);
  }
  return reports;
}

}  // namespace

TEST_CASE("emulated device gives the same bytes for the same seed and others for another") {
  const auto reference = push_into_wall(7, 100 * kMs);
  CHECK(reference.size() > 20);
  CHECK(push_into_wall(7, 100 * kMs) == reference);
  CHECK(push_into_wall(8, 100 * kMs) != reference);
}

TEST_CASE("emulated device gives the same bytes however a span is cut") {
  const auto reference = push_into_wall(7, 100 * kMs);
  for (const std::int64_t cut_ns : {std::int64_t{33'333}, std::int64_t{777'777}, 10 * kMs}) {
    CAPTURE(cut_ns);
    CHECK(push_into_wall(7, cut_ns) == reference);
  }
}

TEST_CASE("link delivers one report each way in a frame of 1 ms") {
  EmulatedDevice device;
  for (std::uint16_t i = 1; i <= 10; ++i) command(device, protocol::Op::disarm, i);
  std::size_t answered = 0;
  for (int frame = 0; frame < 15; ++frame) {
    device.advance(kMs);
    const std::size_t now = only<protocol::Acknowledgement>(read_all(device)).size();
    CHECK(now <= 1);
    answered += now;
  }
  CHECK(answered == 10);
}

TEST_CASE("link keeps what a device has no room for, because it does nothing for a while") {
  EmulatedDevice device;
  std::uint16_t sent = 0;
  while (device.write(protocol::encode(protocol::Command{sent, 0, protocol::Op::disarm}))) ++sent;
  device.skip_ticks(40);
  device.advance(100 * kMs);
  CHECK(only<protocol::Acknowledgement>(read_all(device)).size() == sent);
}

TEST_CASE("link pushes back when its output queue is full and loses nothing") {
  EmulatedDevice device;
  std::uint16_t sent = 0;
  const auto report = [&] {
    return protocol::encode(protocol::Command{sent, 0, protocol::Op::disarm});
  };
  while (device.write(report())) ++sent;
  CHECK(sent == UsbLink::kOutputQueueReports);
  device.advance(50 * kMs);
  const auto answers = only<protocol::Acknowledgement>(read_all(device));
  REQUIRE(answers.size() == sent);
  for (std::uint16_t i = 0; i < sent; ++i) CHECK(answers[i].sequence == i);
}

TEST_CASE("link keeps as many input reports as its queue holds") {
  EmulatedDevice device({.input_queue_reports = 64});
  send(device, protocol::Stream{1, 0, 1});
  device.advance(1000 * kMs);
  CHECK(read_all(device).size() == 64);
}

TEST_CASE("a plug is pulled in the middle of a span") {
  EmulatedDevice device;
  device.unplug_at(5 * kMs);
  device.advance(10 * kMs);
  CHECK_FALSE(device.write(protocol::encode(protocol::Command{1, 0, protocol::Op::disarm})));
}

TEST_CASE("truth has one sample a tick, at the tick's time, and costs nothing unasked") {
  EmulatedDevice device(
      {.hand = PrescribedMotion{Profile({{0, 0.0}, {1000 * kMs, 1.0}})}, .log_truth = true});
  device.advance(100 * kMs);
  const std::vector<torsio::TruthSample> truth = device.take_truth();
  REQUIRE(truth.size() == 100);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    CHECK(truth[i].time_s == 1e-9 * static_cast<double>(static_cast<std::int64_t>(i) * kMs));
    CHECK(truth[i].angle_rad ==
          doctest::Approx(1e-3 * static_cast<double>(i)).scale(1e-3).epsilon(1e-9));
  }
  CHECK(device.take_truth().empty());

  EmulatedDevice silent;
  silent.advance(100 * kMs);
  CHECK(silent.take_truth().empty());
}

TEST_CASE("pulling the plug disarms the device and empties the cable") {
  EmulatedDevice device;
  command(device, protocol::Op::arm);
  device.advance(5 * kMs);
  CHECK(feature<protocol::Health>(device).state == protocol::State::armed);

  command(device, protocol::Op::arm);  // on its way when the plug is pulled
  device.set_plugged(false);
  CHECK_FALSE(device.connected());
  CHECK_FALSE(device.write(protocol::encode(protocol::Command{})));
  ReportBytes report;
  CHECK_FALSE(device.read(report));
  CHECK(device.get_feature(protocol::Layout<protocol::Health>::id, report) != protocol::Status::ok);
  CHECK_FALSE(device.set_feature(protocol::encode(protocol::ControlConfig{})).ok());
  device.advance(200 * kMs);

  device.set_plugged(true);
  device.advance(20 * kMs);
  CHECK(feature<protocol::Health>(device).state == protocol::State::disarmed);
}

TEST_CASE("an overriding configuration is there from the first moment") {
  const EmulatedDevice device(
      {.given = {.actuator = protocol::ActuatorConfig{.counts_per_rev = 4096},
                 .control = protocol::ControlConfig{.beta = 0.125F}}});
  CHECK(feature<protocol::Identity>(device).counts_per_rev == 4096);
  CHECK(feature<protocol::ControlConfig>(device).beta == 0.125F);
}

TEST_CASE("faults of the world become faults of the device") {
  const auto faults_after = [](auto&& strike) {
    EmulatedDevice device;
    command(device, protocol::Op::arm);
    device.advance(5 * kMs);
    strike(device);
    device.advance(30 * kMs);
    return feature<protocol::Health>(device).faults;
  };
  using Device = EmulatedDevice;
  CHECK(faults_after([](Device&) {}) == 0);
  CHECK(faults_after([](Device& d) { d.set_emergency_stop(true); }) ==
        protocol::fault::emergency_stop);
  CHECK(faults_after([](Device& d) { d.set_actuator_fault(true); }) == protocol::fault::actuator);
  CHECK(faults_after([](Device& d) { d.jump_encoder(5000); }) == protocol::fault::encoder);
  CHECK(faults_after([](Device& d) { d.skip_ticks(20); }) == protocol::fault::overrun);
}

TEST_CASE("ticks that do not happen count as time") {
  EmulatedDevice device;
  device.advance(10 * kMs);
  device.skip_ticks(3);
  device.advance(10 * kMs);
  CHECK(feature<protocol::Clock>(device).tick == 20);
  CHECK(feature<protocol::Health>(device).tick_overruns == 3);
}

TEST_CASE("reports damaged on the way out are refused, and never obeyed as something else") {
  EmulatedDevice device({.seed = 3});
  device.set_link_faults({.corrupt_output = 1.0});
  for (int i = 0; i < 200; ++i) {
    (void)device.write(
        protocol::encode(protocol::Wall{.target = {}, .stiffness_nm_per_rad = 1.0F}));
    device.advance(3 * kMs);
    (void)read_all(device);
  }
  CHECK(feature<protocol::Health>(device).state == protocol::State::disarmed);
  CHECK(feature<protocol::Health>(device).reports_refused > 100);
}

TEST_CASE("emulated device refuses options out of range by name") {
  const auto message = [](EmulatedDeviceOptions options) -> std::string {
    try {
      const EmulatedDevice device(std::move(options));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(message({.control_period_ns = 49'999}).find("control_period_ns") != std::string::npos);
  CHECK(message({.control_period_ns = 1'000'001}).find("control_period_ns") != std::string::npos);
  CHECK(message({.serial = ""}).find("serial") != std::string::npos);
  CHECK(message({.serial = "12345678901234567"}).find("serial") != std::string::npos);
  EmulatedDeviceOptions weightless;
  weightless.plant.knob_inertia_kg_m2 = -1.0;
  CHECK(message(weightless).find("knob_inertia") != std::string::npos);
  CHECK(message({.given = {.control = protocol::ControlConfig{.beta = 2.0F}}}).find("beta") !=
        std::string::npos);
  EmulatedDevice device;
  CHECK_THROWS_AS(device.advance(-1), std::invalid_argument);
  const auto link_message = [&](torsio::LinkFaults faults) -> std::string {
    try {
      device.set_link_faults(faults);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(link_message({.drop_output = -0.1}).find("drop_output") != std::string::npos);
  CHECK(link_message({.corrupt_output = 2.0}).find("corrupt_output") != std::string::npos);
  CHECK(link_message({.drop_input = 1.5}).find("drop_input") != std::string::npos);
  CHECK(link_message({.corrupt_input = std::nan("")}).find("corrupt_input") != std::string::npos);
  CHECK(link_message({.drop_output = 1.0, .corrupt_input = 0.0}) == "accepted");
}
