// The fuzz target with seeded inputs that look like reports, so that most of them get past the
// first check.
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "../../../fuzz/fuzz_game_reports.cpp"

namespace {

class ReportLike {
 public:
  explicit ReportLike(unsigned seed) : random_(seed) {}

  std::vector<std::uint8_t> input() {
    std::vector<std::uint8_t> bytes;
    for (int steps = 150; steps > 0; --steps) {
      const std::vector<std::uint8_t> report = make_report();
      // Mostly reports of the kind that fits the way, and time that passes.
      const bool feature = !report.empty() && report[0] == 0x21;
      const unsigned what = below(8) == 0 ? below(256) : feature ? 3U : below(3) == 0 ? 6U : 0U;
      bytes.push_back(static_cast<std::uint8_t>(what));
      bytes.push_back(static_cast<std::uint8_t>(report.size()));
      bytes.insert(bytes.end(), report.begin(), report.end());
    }
    return bytes;
  }

 private:
  unsigned below(unsigned limit) {
    return std::uniform_int_distribution<unsigned>(0, limit - 1)(random_);
  }
  std::uint8_t byte() {
    constexpr std::uint8_t edges[] = {0x00, 0x01, 0x7F, 0x80, 0xFF};
    return below(3) == 0 ? edges[below(5)] : static_cast<std::uint8_t>(below(256));
  }
  std::vector<std::uint8_t> make_report() {
    constexpr std::uint8_t ids[] = {0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0x1A,
                                    0x1A, 0x1A, 0x1B, 0x1C, 0x1D, 0x21, 0x21};
    constexpr std::uint8_t sizes[] = {18, 10, 15, 10, 4, 6, 4, 4, 4, 2, 2, 3, 4, 4};
    const unsigned kind = below(std::size(ids));
    std::vector<std::uint8_t> report{ids[kind], static_cast<std::uint8_t>(1 + below(6))};
    if (below(20) == 0) report[1] = byte();
    if (ids[kind] == 0x21) report[1] = static_cast<std::uint8_t>(below(13));
    while (report.size() < sizes[kind]) report.push_back(byte());
    if (ids[kind] == 0x11) report[2] = static_cast<std::uint8_t>(1 + below(11));
    if (ids[kind] == 0x1A) report[2] = static_cast<std::uint8_t>(1 + below(3));
    if (below(30) == 0) report.resize(below(32));
    return report;
  }

  std::mt19937 random_;
};

}  // namespace

TEST_CASE("no row of reports breaks the game interface, and all of it can be stopped") {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    const std::vector<std::uint8_t> input = ReportLike(seed).input();
    CHECK(LLVMFuzzerTestOneInput(input.data(), input.size()) == 0);
  }
}
