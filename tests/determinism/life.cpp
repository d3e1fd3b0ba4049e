// The lives of some emulated knobs, as one number: every report that a device sends and everything
// that the plant knows, in every tick.
//
//     torsio_life [--knobs N] [--seconds S] [--threads N] [--cut SEED] [--pace FACTOR] [--each]
//
// With --pace time goes by the clock, so many times faster, in pieces as they come. How the time is
// cut into calls, over how many threads the knobs are spread, which compiler has
// made the program with which options for which processor: the number must not show it.
#include "tests/determinism/life.hpp"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

namespace {

using namespace torsio;
using test::Life;

/// FNV-1a, 64 bits.
class Hash {
 public:
  void add(std::uint8_t byte) { value_ = (value_ ^ byte) * 1099511628211U; }
  void add(std::uint64_t bits) {
    for (unsigned shift = 0; shift < 64; shift += 8) add(static_cast<std::uint8_t>(bits >> shift));
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  template <class Bytes>
  void add_all(const Bytes& bytes) {
    for (const std::uint8_t byte : bytes) add(byte);
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037U;
};

/// Makes a number from the knob's outputs.
class Hasher final : public test::Witness {
 public:
  void see(const protocol::ReportBytes& report) override { hash_.add_all(report); }
  void see_game(std::span<const std::uint8_t> report) override { hash_.add_all(report); }
  void see(const TruthSample& sample) override {
    hash_.add(sample.time_s);
    hash_.add(sample.angle_rad);
    hash_.add(sample.brake_angle_rad);
    hash_.add(sample.speed_rad_s);
  }
  [[nodiscard]] std::uint64_t value() const { return hash_.value(); }

 private:
  Hash hash_;
};

struct Options {
  std::uint64_t knobs = 8;
  std::int64_t seconds = 10;
  std::uint64_t threads = 1;
  std::uint64_t cut = 0;
  std::int64_t pace = 0;
  bool each = false;
};

bool read_options(int count, char** arguments, Options& options) {
  for (int i = 1; i < count; ++i) {
    const std::string_view name = arguments[i];
    if (name == "--each") {
      options.each = true;
      continue;
    }
    if (i + 1 == count) return false;
    const auto value = std::strtoull(arguments[++i], nullptr, 10);
    if (name == "--knobs") {
      options.knobs = value;
    } else if (name == "--seconds") {
      options.seconds = static_cast<std::int64_t>(value);
    } else if (name == "--threads") {
      options.threads = value;
    } else if (name == "--cut") {
      options.cut = value;
    } else if (name == "--pace") {
      options.pace = static_cast<std::int64_t>(value);
    } else {
      return false;
    }
  }
  return options.knobs != 0 && options.threads != 0;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  if (!read_options(count, arguments, options)) {
    std::fprintf(stderr,
                 "usage: %s [--knobs N] [--seconds S] [--threads N] [--cut SEED] "
                 "[--pace FACTOR] [--each]\n",
                 arguments[0]);
    return 2;
  }
  std::vector<std::uint64_t> hashes(options.knobs);
  std::vector<std::thread> threads;
  for (std::uint64_t thread = 0; thread < options.threads; ++thread) {
    threads.emplace_back([&, thread] {
      for (std::uint64_t knob = thread; knob < options.knobs; knob += options.threads) {
        Hasher hasher;
        Life life(hasher, knob, options.cut == 0 ? 0 : options.cut + knob, options.pace);
        life.live(options.seconds);
        hashes[knob] = hasher.value();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  Hash all;
  for (const std::uint64_t hash : hashes) {
    all.add(hash);
    if (options.each) std::printf("%016llx\n", static_cast<unsigned long long>(hash));
  }
  std::printf("%016llx\n", static_cast<unsigned long long>(all.value()));
  return 0;
}
