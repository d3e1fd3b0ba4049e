// The host library against a device that lies. Time is virtual. The input gives the device's
// answers, most of them plausible. Every call of the library must end, with a result or an error.
#include <array>
#include <chrono>
#include <cstring>
#include <deque>
#include <exception>
#include <memory>

#include "fuzz.hpp"
#include "protocol/axis_samples.hpp"
#include "reports.hpp"
#include "torsio/knob.hpp"

namespace {

using namespace torsio;
namespace wire = torsio::protocol;

/// Answers as the input says: rightly, wrongly, late or not at all.
class Liar final : public Transport {
 public:
  explicit Liar(fuzz::Reader& input) : input_(input), make_(input.word()) {}

  void close() noexcept override {}
  bool write(const ReportBytes& report) override {
    if (++writes_ > kMostCalls) throw Disconnected("enough");
    const std::uint8_t how = input_.byte();
    if (how % 32 == 31) return false;
    if (how % 32 == 30) throw Disconnected("the liar has left");
    answer(report, how);
    return true;
  }
  bool read(ReportBytes& report, std::chrono::nanoseconds) override {
    if (++reads_ > 50 * kMostCalls) throw Disconnected("enough");
    if (waiting_.empty()) return false;
    report = waiting_.front();
    waiting_.pop_front();
    return true;
  }
  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    if (++features_ > kMostCalls) throw Disconnected("enough");
    const std::uint8_t how = input_.byte();
    if (how % 32 == 31) return false;
    report = feature(id);
    if (how % 8 == 7) damage(report);
    return true;
  }
  bool set_feature(const ReportBytes& report) override {
    const std::uint8_t how = input_.byte();
    if (how % 16 == 15) return false;
    answer(report, how);
    return true;
  }
  [[nodiscard]] bool time_is_virtual() const override { return true; }
  [[nodiscard]] std::int64_t now_ns() const override { return now_ns_; }
  void advance_to(std::int64_t time_ns) override {
    if (time_ns <= now_ns_) return;
    now_ns_ = time_ns;
    if (waiting_.size() > 200) return;
    const std::uint8_t how = input_.byte();
    if (how % 4 != 0 && stream_ == 0) return;
    if (how % 16 == 3) {
      waiting_.push_back(make_.any());
    } else if (stream_ != 0) {
      waiting_.push_back(telemetry(how));
    }
  }

 private:
  static constexpr int kMostCalls = 400;

  void answer(const ReportBytes& report, std::uint8_t how) {
    wire::Stream stream;
    if (wire::decode(report, stream).ok()) stream_ = stream.decimation;
    wire::Acknowledgement answer;
    answer.sequence = static_cast<std::uint16_t>(report[1] | (report[2] << 8));
    answer.report = report[0];
    answer.state = how % 4 == 3 ? wire::State::disarmed : wire::State::armed;
    answer.tick = static_cast<std::uint64_t>(now_ns_ / 1'000'000);
    if (how % 8 == 5) answer = make_.make<wire::Acknowledgement>();
    if (how % 8 == 6) answer.status = static_cast<std::uint8_t>(how >> 3U);
    ReportBytes bytes = wire::encode(answer);
    if (how % 16 == 7) damage(bytes);
    if (how % 16 != 8) waiting_.push_back(bytes);
  }
  ReportBytes telemetry(std::uint8_t how) {
    auto report = make_.make<wire::Telemetry>();
    if (how % 8 < 6) {
      report.tick = tick_;
      report.decimation = stream_;
      report.axis_samples = wire::pack_axis_samples(0, 4);
    }
    tick_ += 4U * stream_;
    return wire::encode(report);
  }
  ReportBytes feature(std::uint8_t id) {
    ReportBytes bytes{};
    wire::for_each_report<wire::AllReports>([&]<class Report>(std::type_identity<Report>) {
      if (wire::Layout<Report>::id != id) return;
      auto report = make_.below(3) == 0 ? make_.make<Report>() : Report{};
      if constexpr (std::is_same_v<Report, wire::Identity>) {
        report.fingerprint = wire::fingerprint();
        if (make_.below(4) != 0) report.control_period_ns = 1'000'000;
      }
      bytes = wire::encode(report);
    });
    return bytes;
  }
  void damage(ReportBytes& bytes) {
    bytes[input_.byte() % bytes.size()] ^= static_cast<std::uint8_t>(1U << (input_.byte() % 8U));
  }

  fuzz::Reader& input_;
  fuzz::FieldMaker make_;
  std::deque<ReportBytes> waiting_;
  std::int64_t now_ns_ = 0;
  std::uint64_t tick_ = 0;
  std::uint8_t stream_ = 0;
  int writes_ = 0;
  int reads_ = 0;
  int features_ = 0;
};

void call(Knob& knob, std::uint8_t which) {
  switch (which % 22) {
    case 0:
      return knob.arm();
    case 1:
      return knob.disarm();
    case 2:
      return static_cast<void>(knob.play(Wall{.angle_rad = 0.5, .stiffness_nm_per_rad = 1.0}));
    case 3:
      return knob.stop();
    case 4:
      return static_cast<void>(knob.record(0.01));
    case 5:
      return static_cast<void>(knob.health());
    case 6:
      return static_cast<void>(knob.clock());
    case 7:
      return static_cast<void>(knob.position_rad());
    case 8:
      return knob.configure(ControlConfig{});
    case 9:
      return static_cast<void>(knob.actuator_config());
    case 10:
      return knob.save();
    case 11:
      return static_cast<void>(knob.stream_local_model(LocalModel{}));
    case 12:
      return knob.clear_fault();
    case 13:
      return static_cast<void>(knob.faults());
    case 14:
      return knob.sleep(0.005);
    case 15:
      return static_cast<void>(knob.events(0.003));
    case 16:
      return static_cast<void>(knob.start_telemetry({}, which >= 128));
    case 17:
      return static_cast<void>(knob.latest());
    case 18:
      return static_cast<void>(knob.game_effects());
    case 19:
      for (const Step step : knob.every(0.001)) {
        if (step.index >= 3) break;
      }
      return;
    case 20:
      return static_cast<void>(knob.record(0.01, {}, true));
    default:
      return static_cast<void>(knob.board_config());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Reader input(data, size);
  OpenOptions options;
  options.ring_samples = 256;
  options.command_timeout_s = 0.02;
  try {
    Knob knob = Knob::open(std::make_unique<Liar>(input), options);
    for (int left = 24; left > 0 && !input.empty(); --left) {
      try {
        call(knob, input.byte());
      } catch (const Error&) {
        // Said in a sentence; the knob may go on.
      }
    }
  } catch (const Error&) {
    // No knob could be made of it.
  }
  return 0;
}
