// Any reports from the host to the device alone, without physics. An input is a row of steps: a
// byte that says what to do, then its data.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "boards/reference.hpp"
#include "device/device.hpp"
#include "fuzz.hpp"
#include "reports.hpp"

namespace {

using namespace torsio;
using protocol::State;

enum Step : std::uint8_t { output, feature, ask, ticks, turn, cable, flash, trouble, kSteps };

/// A device on the bench, whose every tick is looked at.
class Bench {
 public:
  Bench() : device_(board(), device::empty_slots()) {}

  void tick(unsigned count) {
    for (; count != 0; --count) {
      device_.service();
      const device::TickOutputs out = device_.tick(inputs);
      inputs.missed_ticks = 0;
      check(out);
      protocol::ReportBytes bytes;
      while (device_.next_input(bytes)) look_at(bytes);
    }
  }
  void output_report(std::span<const std::uint8_t> bytes) {
    // A full inbox pushes back, and the bus offers the report again.
    while (!device_.receive(bytes)) {
      write_flash(true);  // or a save would hold up all that comes after it
      tick(1);
    }
  }
  void feature_report(std::span<const std::uint8_t> bytes) {
    const auto before = config();
    if (!device_.set_feature(bytes).ok()) {
      fuzz::require(config() == before, "what is refused changes nothing");
    }
  }
  void ask_for(std::uint8_t id) {
    protocol::ReportBytes bytes;
    if (device_.get_feature(id, bytes) == protocol::Status::ok) {
      fuzz::require(bytes[0] == id, "the answer is what was asked for");
    }
  }
  void cable(bool plugged) { device_.set_connected(plugged); }
  void write_flash(bool works) {
    if (!device_.take_slot_write()) return;
    if (works) {
      device_.storage_written();
    } else {
      device_.storage_failed();
    }
  }
  [[nodiscard]] State state() const { return device_.state(); }
  [[nodiscard]] const device::TickOutputs& last() const { return last_; }

  device::TickInputs inputs;

 private:
  static device::BoardInfo board() {
    device::BoardInfo info;
    info.has_bootloader = true;
    // The slowest rate: whatever takes time takes the fewest ticks.
    info.control_period_ns = 1'000'000;
    info.wiring_rule = boards::kReference.wiring_rule;
    return info;
  }

  template <class Report>
  Report get() {
    protocol::ReportBytes bytes;
    Report report{};
    fuzz::require(device_.get_feature(protocol::Layout<Report>::id, bytes) == protocol::Status::ok,
                  "a report that it has");
    fuzz::require(protocol::decode(bytes, report).ok(), "what it says of itself is in range");
    return report;
  }
  std::array<protocol::ReportBytes, 4> config() {
    std::array<protocol::ReportBytes, 4> reports;
    (void)device_.get_feature(protocol::Layout<protocol::ActuatorConfig>::id, reports[0]);
    (void)device_.get_feature(protocol::Layout<protocol::ControlConfig>::id, reports[1]);
    (void)device_.get_feature(protocol::Layout<protocol::BoardConfig>::id, reports[2]);
    (void)device_.get_feature(protocol::Layout<protocol::GameConfig>::id, reports[3]);
    return reports;
  }

  void check(const device::TickOutputs& out) {
    fuzz::require(std::isfinite(out.motor_command_nm) && std::isfinite(out.brake_command_nm),
                  "finite torques");
    if (!out.enabled) {
      fuzz::require(out.motor_command_nm == 0.0F && out.brake_command_nm == 0.0F,
                    "no torque without power");
    } else {
      // Nobody can change them until the power is off again.
      if (!last_.enabled) read_caps();
      fuzz::require(std::abs(out.motor_command_nm) <= motor_nm_ * 1.00001F,
                    "the motor's cap holds");
      fuzz::require(out.brake_command_nm >= 0.0F && out.brake_command_nm <= brake_nm_,
                    "the brake's cap holds");
      fuzz::require(!inputs.emergency_stop && !inputs.actuator_fault, "faults cut the power");
    }
    last_ = out;
  }

  void read_caps() {
    const auto actuator = get<protocol::ActuatorConfig>();
    const auto control = get<protocol::ControlConfig>();
    motor_nm_ = std::min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm);
    brake_nm_ = std::min(actuator.brake_torque_max_nm, control.brake_torque_cap_nm);
  }

  void look_at(const protocol::ReportBytes& bytes) {
    protocol::Acknowledgement acknowledgement;
    protocol::Event event;
    protocol::Telemetry telemetry;
    const bool known = protocol::decode(bytes, acknowledgement).ok() ||
                       protocol::decode(bytes, event).ok() ||
                       protocol::decode(bytes, telemetry).ok();
    fuzz::require(known, "it says nothing that its own protocol does not allow");
  }

  device::Device device_;
  device::TickOutputs last_;
  float motor_nm_ = 0;
  float brake_nm_ = 0;
};

void step(Bench& bench, fuzz::Reader& input) {
  switch (static_cast<Step>(input.byte() % kSteps)) {
    case output: {
      const std::size_t length = std::min<std::size_t>(input.byte(), 70);
      bench.output_report(input.bytes(length));
      break;
    }
    case feature: {
      const std::size_t length = std::min<std::size_t>(input.byte(), 70);
      bench.feature_report(input.bytes(length));
      break;
    }
    case ask:
      bench.ask_for(input.byte());
      break;
    case ticks:
      bench.tick(1U + input.byte() % 16U);
      break;
    case turn:
      bench.inputs.encoder_count +=
          static_cast<std::uint32_t>(static_cast<std::int16_t>(input.word()));
      bench.tick(1);
      break;
    case cable:
      bench.cable(input.byte() % 2 == 0);
      break;
    case flash:
      bench.write_flash(input.byte() % 2 == 0);
      break;
    case trouble: {
      const std::uint8_t what = input.byte();
      bench.inputs.emergency_stop = (what & 1U) != 0;
      bench.inputs.actuator_fault = (what & 2U) != 0;
      bench.inputs.missed_ticks = what >> 4U;
      bench.inputs.tick_time_ns = (what & 4U) != 0 ? 1'000'000U : 1'000U;
      bench.tick(1);
      break;
    }
    case kSteps:
      break;
  }
}

}  // namespace

std::span<const std::string_view> fuzz::dictionary() {
  // A step, a report's length and its id, and the request.
  static const auto words = [] {
    static std::vector<std::string> made;
    protocol::for_each_report<protocol::AllReports>([]<class Report>(std::type_identity<Report>) {
      const auto id = static_cast<char>(protocol::Layout<Report>::id);
      const bool is_feature = protocol::Layout<Report>::direction == protocol::Direction::feature;
      made.push_back({static_cast<char>(is_feature ? feature : output), 64, id});
      if (is_feature) made.push_back({static_cast<char>(ask), id});
    });
    return std::vector<std::string_view>(made.begin(), made.end());
  }();
  return words;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  fuzz::FieldMaker make(seed);
  std::array<std::uint8_t, 66> piece{};
  std::size_t length = 0;
  const auto command = [&](protocol::Op op) {
    return protocol::encode(protocol::Command{static_cast<std::uint16_t>(seed), 0, op});
  };
  if (make.below(3) == 0) {
    piece = {static_cast<std::uint8_t>(2 + make.below(kSteps - 2)),
             static_cast<std::uint8_t>(make.bits()), static_cast<std::uint8_t>(make.bits())};
    length = piece[0] == turn ? 3 : 2;
  } else {
    protocol::ReportBytes report = make.any();
    if (make.below(5) == 0)
      report = command(make.below(2) == 0 ? protocol::Op::arm : protocol::Op::clear_fault);
    const std::uint8_t id = report[0];
    const bool is_feature = protocol::Layout<protocol::ActuatorConfig>::id <= id &&
                            id <= protocol::Layout<protocol::GameConfig>::id;
    piece[0] = is_feature ? feature : output;
    piece[1] = 64;
    std::copy(report.begin(), report.end(), piece.begin() + 2);
    length = 66;
  }
  return fuzz::put(std::span(piece).first(length), std::span(data, max_size), size, make);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bench bench;
  fuzz::Reader input(data, size);
  while (!input.empty()) step(bench, input);

  // Whatever it was, it can be stopped, and it stays stopped.
  bench.output_report(protocol::encode(protocol::Command{1, 0, protocol::Op::stop}));
  for (int round = 0; round < 12; ++round) {  // reports in the inbox go first
    bench.write_flash(true);
    bench.tick(3);  // and an armed device lets go first
  }
  fuzz::require(bench.state() != State::armed, "stop disarms");
  fuzz::require(!bench.last().enabled, "no power after stop");
  return 0;
}
