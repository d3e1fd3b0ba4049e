// A thousand hours of virtual time: emulated knobs live, and every so often trouble ends and they
// are examined. The sensor's error is then the same as at first, every command is answered in its
// order, no sample is missing, and the position is true.
//
//     torsio_soak [--hours H] [--knobs N] [--threads N] [--seed N] [--minutes M]
//
// Hours of all knobs together, most of them at low rates, which take less of the processor; M
// minutes of life between two examinations.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "tests/determinism/life.hpp"

namespace {

using namespace torsio;
using emulator::EmulatedDevice;
using test::Life;

// Allowed error of a wall's torque, with the sensor of the reference actuator.
constexpr double kSensorErrorMostNm = 4.5e-3;
constexpr double kCountsPerRad = 8192.0 / (2.0 * std::numbers::pi);

std::atomic<int> faults_found{0};

/// As the truth has it.
double in_s(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

void require(bool holds, std::uint64_t seed, double hour, const char* what) {
  if (holds) return;
  ++faults_found;
  std::fprintf(stderr, "soak: knob %llu after %.3f h: %s\n", static_cast<unsigned long long>(seed),
               hour, what);
}

/// Looks at everything, and keeps it while an examination goes on.
class Examiner final : public test::Witness {
 public:
  explicit Examiner(std::uint64_t seed) : seed_(seed) {}

  void see(const protocol::ReportBytes& report) override {
    protocol::Telemetry telemetry;
    protocol::Acknowledgement acknowledgement;
    if (!examines_) return;
    if (protocol::decode(report, telemetry).ok()) telemetry_.push_back(telemetry);
    if (protocol::decode(report, acknowledgement).ok()) answers_.push_back(acknowledgement);
  }
  void see_game(std::span<const std::uint8_t>) override {}
  void see(const TruthSample& sample) override {
    ++ticks_;
    // The reference actuator's most torque, and a little for rounding.
    const bool sound = std::isfinite(sample.angle_rad) && std::isfinite(sample.speed_rad_s) &&
                       std::abs(sample.motor_torque_nm) <= 0.0851 &&
                       sample.brake_capacity_nm <= 0.1121;
    if (!sound) say(false, "a torque beyond what the parts can give, or a motion that is none");
    if (examines_) truth_.push_back(sample);
  }
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

  /// @returns the sensor's error, RMS, in N m
  double examine(Life& life) {
    EmulatedDevice& device = life.device();
    hour_ = static_cast<double>(device.time_ns()) / 3.6e12;
    life.recover();
    for (int n = 0; n < 200 && std::abs(device.plant().state().knob_speed_rad_s()) > 1e-3; ++n) {
      device.advance(100'000'000);
      life.look();
    }
    examines_ = true;
    protocol::ControlConfig control;
    control.law = protocol::Law::compensated;
    control.watchdog_s = 1.0F;
    say(device.set_feature(protocol::encode(control)).ok(), "a configuration is refused");
    send(life, protocol::Stream{0, 0, 0});
    device.advance(20'000'000);
    life.look();
    telemetry_.clear();
    answers_.clear();
    truth_.clear();

    const auto period_ns =
        static_cast<std::int64_t>(get<protocol::Identity>(device).control_period_ns);
    const auto decimation = static_cast<std::uint8_t>(5'000'000 / period_ns);
    const std::uint32_t dropped = get<protocol::Health>(device).samples_dropped;
    ask(life, decimation);
    push(life);
    const protocol::Clock clock = get<protocol::Clock>(device);
    const std::int64_t begin_ns =
        device.next_tick_ns() - static_cast<std::int64_t>(clock.tick) * period_ns;
    command(life, protocol::Op::disarm);
    send(life, protocol::Stream{sequence_++, 0, 0});
    device.advance(30'000'000);
    life.look();
    examines_ = false;
    say(get<protocol::Health>(device).samples_dropped == dropped, "the device dropped samples");
    check_answers();
    return compare(begin_ns, period_ns, decimation, get<protocol::Identity>(device));
  }

 private:
  void say(bool holds, const char* what) const { require(holds, seed_, hour_, what); }

  template <class Report>
  Report get(const EmulatedDevice& device) const {
    protocol::ReportBytes bytes{};
    Report report{};
    say(device.get_feature(protocol::Layout<Report>::id, bytes) == protocol::Status::ok &&
            protocol::decode(bytes, report).ok(),
        "a report that cannot be read");
    return report;
  }
  template <class Report>
  void send(Life& life, const Report& report) const {
    say(life.device().write(protocol::encode(report)), "the queue is full");
    life.device().advance(2'000'000);
    life.look();
  }
  void command(Life& life, protocol::Op op) { send(life, protocol::Command{sequence_++, 0, op}); }

  /// Writes a scene: a wall a little further on, and something in every other slot.
  void ask(Life& life, std::uint8_t decimation) {
    sequence_ = first_;
    wall_rad_ = life.device().plant().state().knob_angle_rad();
    protocol::ReportBytes bytes{};
    say(life.device().get_feature(protocol::Layout<protocol::Clock>::id, bytes) ==
            protocol::Status::ok,
        "no clock");
    protocol::Clock clock{};
    (void)protocol::decode(bytes, clock);
    protocol::Wall wall;
    wall.target = {sequence_++, 0, 0};
    wall.side = protocol::Side::above;
    wall.stiffness_nm_per_rad = 1.72F;  // 30 mN m a degree
    wall.angle_turns_q32 = (clock.position_counts + 40) * (std::int64_t{1} << 32) / 8192;
    send(life, wall);
    for (std::uint8_t slot = 1; slot < 16; ++slot) {
      protocol::Damper damper;
      damper.target = {sequence_++, 0, slot};
      send(life, damper);
    }
    send(life, protocol::Commit{sequence_++, 0, 1});
    command(life, protocol::Op::arm);
    send(life, protocol::Stream{sequence_++, 0, decimation});
  }

  /// In a second a hand's torque rises to 60 mN m, stays for a moment and goes.
  void push(Life& life) {
    EmulatedDevice& device = life.device();
    const std::int64_t now_ns = device.next_tick_ns();
    device.set_hand(emulator::TorqueHand{emulator::Profile({{now_ns, 0.0},
                                                            {now_ns + 1'000'000'000, 0.06},
                                                            {now_ns + 1'200'000'000, 0.06},
                                                            {now_ns + 2'200'000'000, -0.01}})});
    for (int n = 0; n < 22; ++n) {
      device.advance(100'000'000);
      const bool alive =
          device.write(protocol::encode(protocol::Command{0, 0, protocol::Op::keep_alive}));
      say(alive, "the queue is full");
      life.look();
    }
    device.set_hand(emulator::NoHand{});
  }

  void check_answers() {
    std::uint16_t wanted = first_;
    for (const protocol::Acknowledgement& answer : answers_) {
      say(answer.sequence == wanted++, "an answer is missing, or out of order");
      say(answer.status == 0, "a command is refused");
    }
    say(wanted == sequence_, "a command has no answer");
  }

  /// Telemetry beside the truth, tick by tick.
  double compare(std::int64_t begin_ns, std::int64_t period_ns, std::uint8_t decimation,
                 const protocol::Identity& identity) const {
    double squares = 0.0;
    double least_counts = 1e300;
    double most_counts = -1e300;
    std::uint64_t samples = 0;
    std::uint64_t next_tick = 0;
    for (const protocol::Telemetry& report : telemetry_) {
      // Samples of the earlier stream that a batch still held.
      const std::int64_t first_ns = begin_ns + static_cast<std::int64_t>(report.tick) * period_ns;
      if (samples == 0 && !truth_.empty() && in_s(first_ns) < truth_.front().time_s) continue;
      say(samples == 0 || report.tick == next_tick, "samples are missing");
      const unsigned count = report.axis_samples >> 4U;
      for (unsigned n = 0; n < count; ++n) {
        const std::uint64_t tick = report.tick + std::uint64_t{n} * decimation;
        next_tick = tick + decimation;
        const std::int64_t at_ns = begin_ns + static_cast<std::int64_t>(tick) * period_ns;
        const auto found = std::ranges::lower_bound(truth_, in_s(at_ns), {}, &TruthSample::time_s);
        if (found == truth_.end() || found->time_s != in_s(at_ns)) {
          say(false, "a sample of a tick that was not");
          continue;
        }
        ++samples;
        const double sensed_nm =
            report.sample[n].spring_torque * static_cast<double>(identity.torque_step_nm);
        squares += (sensed_nm - found->spring_torque_nm) * (sensed_nm - found->spring_torque_nm);
        const double off_counts = static_cast<double>(report.base_counts) +
                                  report.sample[n].offset_counts - found->angle_rad * kCountsPerRad;
        // The base has the low 32 bits of the position alone.
        const double folded = std::remainder(off_counts, 0x1p32);
        least_counts = std::min(least_counts, folded);
        most_counts = std::max(most_counts, folded);
      }
    }
    say(samples >= 400, "fewer samples than there were");
    say(most_counts - least_counts <= 4.0, "the position has slipped");
    const double error_nm =
        std::sqrt(squares / static_cast<double>(std::max<std::uint64_t>(samples, 1)));
    say(error_nm <= kSensorErrorMostNm, "the sensor is further off than it may be");
    return error_nm;
  }

  static constexpr std::uint16_t first_ = 100;
  std::uint64_t seed_;
  double hour_ = 0;
  bool examines_ = false;
  std::uint64_t ticks_ = 0;
  std::uint16_t sequence_ = first_;
  double wall_rad_ = 0;
  std::vector<protocol::Telemetry> telemetry_;
  std::vector<protocol::Acknowledgement> answers_;
  std::vector<TruthSample> truth_;
};

struct Options {
  double hours = 1;
  std::uint64_t knobs = 8;
  std::uint64_t threads = 1;
  std::uint64_t seed = 1;
  double minutes = 10;
};

bool read_options(int count, char** arguments, Options& options) {
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string_view name = arguments[i];
    const double value = std::atof(arguments[i + 1]);
    if (name == "--hours") {
      options.hours = value;
    } else if (name == "--knobs") {
      options.knobs = static_cast<std::uint64_t>(value);
    } else if (name == "--threads") {
      options.threads = static_cast<std::uint64_t>(value);
    } else if (name == "--seed") {
      options.seed = static_cast<std::uint64_t>(value);
    } else if (name == "--minutes") {
      options.minutes = value;
    } else {
      return false;
    }
  }
  return count % 2 == 1 && options.hours > 0 && options.knobs > 0 && options.threads > 0 &&
         options.minutes > 0;
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  double pages = 0;
  file >> pages >> pages;
  return pages * 4096.0 / 1e6;
}

double mean(std::span<const double> numbers) {
  double sum = 0.0;
  for (const double number : numbers) sum += number;
  return sum / static_cast<double>(std::max<std::size_t>(numbers.size(), 1));
}

/// The result of one knob.
struct Told {
  double hours = 0;
  std::uint64_t ticks = 0;
  std::vector<double> errors_nm;  // one for each examination
};

Told soak(std::uint64_t seed, double hours, double minutes) {
  Examiner examiner(seed);
  Life life(examiner, seed);
  Told told;
  const auto seconds = static_cast<std::int64_t>(std::max(1.0, 60.0 * minutes));
  do {
    life.live(seconds);
    told.errors_nm.push_back(examiner.examine(life));
    told.hours = static_cast<double>(life.device().time_ns()) / 3.6e12;
  } while (told.hours < hours && faults_found < 20);
  told.ticks = examiner.ticks();
  // Of the first and last quarter, at least two examinations.
  const std::size_t quarter = told.errors_nm.size() / 4;
  if (quarter > 0) {
    const double first_nm = mean(std::span(told.errors_nm).first(quarter));
    const double last_nm = mean(std::span(told.errors_nm).last(quarter));
    require(last_nm <= 1.3 * first_nm + 0.5e-3, seed, told.hours, "the sensor's error has grown");
  }
  return told;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  if (!read_options(count, arguments, options)) {
    std::fprintf(stderr,
                 "usage: %s [--hours H] [--knobs N] [--threads N] [--seed N] [--minutes M]\n",
                 arguments[0]);
    return 2;
  }
  const auto begin = std::chrono::steady_clock::now();
  std::vector<Told> all(options.knobs);
  const auto weight = [&](std::uint64_t knob) {
    const double period_ms = 1e-6 * static_cast<double>(Life::period_ns(options.seed + knob));
    return period_ms * period_ms;
  };
  double weights = 0.0;
  for (std::uint64_t knob = 0; knob < options.knobs; ++knob) weights += weight(knob);
  std::atomic<double> early_mb{0.0};
  std::vector<std::thread> threads;
  for (std::uint64_t thread = 0; thread < options.threads; ++thread) {
    threads.emplace_back([&, thread] {
      for (std::uint64_t knob = thread; knob < options.knobs; knob += options.threads) {
        all[knob] =
            soak(options.seed + knob, options.hours * weight(knob) / weights, options.minutes);
        double none = 0.0;
        early_mb.compare_exchange_strong(none, resident_mb());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const double grown_mb = resident_mb() - early_mb;
  require(grown_mb < 32.0, 0, options.hours, "the process has grown");
  double hours = 0.0;
  double worst_nm = 0.0;
  std::uint64_t ticks = 0;
  std::size_t examinations = 0;
  std::vector<double> firsts, lasts;
  for (const Told& told : all) {
    hours += told.hours;
    ticks += told.ticks;
    examinations += told.errors_nm.size();
    firsts.push_back(told.errors_nm.front());
    lasts.push_back(told.errors_nm.back());
    worst_nm = std::max(worst_nm, *std::ranges::max_element(told.errors_nm));
  }
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double worked_s = static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
  std::printf(
      "%.1f h of %zu knobs, %.3g ticks, %zu examinations; sensor off by %.2f mN m at first, %.2f "
      "at "
      "the end, %.2f at most; %.0f times as fast as time, %.0f with one processor; %d faults\n",
      hours, all.size(), static_cast<double>(ticks), examinations, 1e3 * mean(firsts),
      1e3 * mean(lasts), 1e3 * worst_nm, 3600 * hours / took_s, 3600 * hours / worked_s,
      faults_found.load());
  return faults_found == 0 ? 0 : 1;
}
