// Any bytes over the game interface. An input is a row of steps: one byte that says what to do, one
// with a length, and so many bytes of report.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "device/device.hpp"
#include "device/game/codec.hpp"
#include "fuzz.hpp"
#include "protocol/codec.hpp"
#include "reports.hpp"

namespace {

using namespace torsio;

constexpr float kCapNm = 0.05F;

/// The motor gives every torque, so that the cap shows.
class GameBench {
 public:
  GameBench() : device_({}, device::empty_slots()) {
    protocol::ControlConfig control;
    control.law = protocol::Law::motor_only;
    control.passive_ramp_s = 0.01F;
    fuzz::require(device_.set_feature(protocol::encode(control)).ok(), "configured");
    tick(3);
    protocol::GameConfig game;
    game.torque_max_nm = kCapNm;
    fuzz::require(device_.set_feature(protocol::encode(game)).ok(), "configured");
    tick(3);
  }

  device::game::PidEngine& game() { return device_.game(); }

  void tick(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      device_.service();
      outputs_ = device_.tick(inputs_);
      fuzz::require(std::isfinite(outputs_.motor_command_nm), "a finite torque");
      fuzz::require(std::abs(outputs_.motor_command_nm) <= kCapNm * 1.0001F, "within the cap");
      protocol::ReportBytes ignored;
      while (device_.next_input(ignored)) {
      }
    }
  }
  void turn(std::int8_t counts) { inputs_.encoder_count += static_cast<std::uint32_t>(counts); }
  void connect(bool connected) { device_.set_connected(connected); }
  float torque_nm() const { return outputs_.motor_command_nm; }
  protocol::State state() const { return device_.state(); }

 private:
  device::Device device_;
  device::TickInputs inputs_;
  device::TickOutputs outputs_;
};

void step(GameBench& bench, std::uint8_t what, std::span<const std::uint8_t> report) {
  std::array<std::uint8_t, device::game::kLongestReport> answer{};
  const std::uint8_t first = report.empty() ? 0 : report[0];
  switch (what % 8) {
    case 0:
    case 1:
    case 2:
      bench.game().receive(report);
      break;
    case 3:
      (void)bench.game().set_feature(report);
      break;
    case 4: {
      const std::size_t size = bench.game().get_feature(first, answer);
      fuzz::require(size <= answer.size(), "an answer of known length");
      fuzz::require(first != 0x22 || (size == 5 && answer[1] <= 40), "a block that exists");
      break;
    }
    case 5:
      for (int n = 0; n < 100 && bench.game().next_input(answer) != 0; ++n) {
        fuzz::require(answer[0] == 1 || answer[0] == 2, "an input report");
      }
      break;
    case 6:
      bench.turn(static_cast<std::int8_t>(first));
      bench.tick(1 + first % 8);
      break;
    default:
      if (first < 8) {
        bench.connect(first % 2 == 0);
      } else {
        bench.game().set_buttons(first);
      }
      break;
  }
}

}  // namespace

std::span<const std::string_view> fuzz::dictionary() {
  using Reports = device::game::PidReports;
  // A step, the report's length and its id.
  static const auto steps = []<class... Report>(std::type_identity<std::tuple<Report...>>) {
    return std::array{std::string{
        device::game::PidLayout<Report>::main == device::game::Main::feature ? '\3' : '\0',
        static_cast<char>(device::game::size_of<Report>()),
        static_cast<char>(device::game::PidLayout<Report>::id)}...};
  }(std::type_identity<Reports>{});
  static const std::array<std::string_view, std::tuple_size_v<Reports>> words = [] {
    std::array<std::string_view, std::tuple_size_v<Reports>> found;
    std::ranges::copy(steps, found.begin());
    return found;
  }();
  return words;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  // A report of the right length about one of few effects, or some ticks.
  fuzz::FieldMaker make(seed);
  std::array<std::uint8_t, 2 + device::game::kLongestReport> piece{6, 1};
  piece[2] = static_cast<std::uint8_t>(make.bits());
  std::size_t length = 3;
  std::size_t wanted = make.below(2 * std::tuple_size_v<device::game::PidReports>);
  const auto take = [&]<class Report>() {
    using Layout = device::game::PidLayout<Report>;
    if (wanted-- != 0) return;
    constexpr std::size_t kSize = device::game::size_of<Report>();
    const bool is_feature = Layout::main == device::game::Main::feature;
    const bool asks = is_feature && !std::is_same_v<Report, device::game::CreateEffect>;
    piece[0] = asks ? 4 : (is_feature ? 3 : 0);
    piece[1] = kSize;
    piece[2] = Layout::id;
    piece[3] = static_cast<std::uint8_t>(make.below(16));
    for (std::size_t i = 2; i < kSize; ++i) {
      constexpr std::array<std::uint8_t, 6> kOften{0x00, 0x01, 0x7F, 0x80, 0xFF, 0x02};
      piece[2 + i] = make.below(3) == 0 ? static_cast<std::uint8_t>(make.bits())
                                        : kOften[make.below(kOften.size())];
    }
    length = 2 + kSize;
  };
  [&]<std::size_t... index>(std::index_sequence<index...>) {
    (take.operator()<std::tuple_element_t<index, device::game::PidReports>>(), ...);
  }(std::make_index_sequence<std::tuple_size_v<device::game::PidReports>>{});
  return fuzz::put(std::span(piece).first(length), std::span(data, max_size), size, make);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  GameBench bench;
  std::span<const std::uint8_t> rest(data, size);
  while (rest.size() >= 2) {
    const std::uint8_t what = rest[0];
    const std::size_t length = std::min<std::size_t>(rest[1] % 33, rest.size() - 2);
    step(bench, what, rest.subspan(2, length));
    rest = rest.subspan(2 + length);
  }
  // Whatever it was, it can be stopped, and it stays stopped.
  const std::array<std::uint8_t, 2> stop_all{0x1C, 3};
  bench.game().set_buttons(0);
  bench.game().receive(stop_all);
  bench.tick(15);  // past every fade
  fuzz::require(bench.torque_nm() == 0.0F, "no torque after stop all");
  bench.connect(false);
  bench.tick(15);
  fuzz::require(bench.state() != protocol::State::armed, "nobody there: not armed");
  return 0;
}
