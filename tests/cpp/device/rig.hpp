/// @file
/// A device on the bench: the test turns the knob, sends reports and reads what comes back.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "device/device.hpp"
#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

namespace torsio::test {

class Rig {
 public:
  explicit Rig(const device::BoardInfo& board = {},
               const device::StoredSlots& stored = device::empty_slots())
      : device(std::make_unique<device::Device>(board, stored)) {}

  /// One round of the main loop and one tick; gathers what the device says.
  void tick(int ticks = 1) {
    for (int i = 0; i < ticks; ++i) {
      device->service();
      outputs = device->tick(inputs);
      protocol::ReportBytes bytes;
      while (device->next_input(bytes)) sort(bytes);
    }
  }

  /// Sends a report and returns its acknowledgement.
  template <class Report>
  protocol::Acknowledgement send(const Report& report) {
    return send_bytes(protocol::encode(report));
  }
  protocol::Acknowledgement send_bytes(std::span<const std::uint8_t> bytes) {
    const std::size_t before = acknowledgements.size();
    REQUIRE(device->receive(bytes));
    for (int i = 0; i < 10 && acknowledgements.size() == before; ++i) tick();
    REQUIRE(acknowledgements.size() == before + 1);
    return acknowledgements.back();
  }
  protocol::Status status(const protocol::Acknowledgement& acknowledgement) const {
    return static_cast<protocol::Status>(acknowledgement.status);
  }
  template <class Report>
  protocol::Status send_status(const Report& report) {
    return status(send(report));
  }
  protocol::Status command(protocol::Op op) { return send_status(protocol::Command{7, 0, op}); }

  template <class Report>
  protocol::Verdict set(const Report& report) {
    const protocol::Verdict verdict = device->set_feature(protocol::encode(report));
    tick(2);
    return verdict;
  }
  template <class Report>
  Report get() {
    protocol::ReportBytes bytes;
    REQUIRE(device->get_feature(protocol::Layout<Report>::id, bytes) == protocol::Status::ok);
    Report report;
    REQUIRE(protocol::decode(bytes, report).ok());
    return report;
  }
  protocol::State state() { return get<protocol::Health>().state; }

  /// Plays constant torque effects in the slots of `active`, without any soft start.
  void arm_with_constant(float torque_nm) {
    protocol::ControlConfig config;
    config.passive_ramp_s = 0.02F;
    config.watchdog_s = 0.1F;
    REQUIRE(set(config).ok());
    protocol::Constant constant;
    constant.torque_nm = torque_nm;
    REQUIRE(send_status(constant) == protocol::Status::ok);
    REQUIRE(send_status(protocol::Commit{1, 0, 1}) == protocol::Status::ok);
    REQUIRE(command(protocol::Op::arm) == protocol::Status::ok);
    tick(25);  // past the soft start
  }

  std::unique_ptr<device::Device> device;
  device::TickInputs inputs;
  device::TickOutputs outputs;
  std::vector<protocol::Acknowledgement> acknowledgements;
  std::vector<protocol::Event> events;
  std::vector<protocol::Telemetry> telemetry;

 private:
  void sort(const protocol::ReportBytes& bytes) {
    protocol::Acknowledgement acknowledgement;
    protocol::Event event;
    protocol::Telemetry report;
    if (protocol::decode(bytes, acknowledgement).ok()) {
      acknowledgements.push_back(acknowledgement);
    } else if (protocol::decode(bytes, event).ok()) {
      events.push_back(event);
    } else {
      REQUIRE(protocol::decode(bytes, report).ok());
      telemetry.push_back(report);
    }
  }
};

}  // namespace torsio::test
