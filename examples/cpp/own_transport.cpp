// Bring your own transport: this one writes down every report on its way to and from another one.
// `own_transport` listens in on the emulated knob; `own_transport /dev/hidraw3` on yours.
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <mutex>
#include <utility>

#include "torsio/knob.hpp"
#include "torsio/transport.hpp"

namespace {

using torsio::ReportBytes;

class Recorder final : public torsio::Transport {
 public:
  explicit Recorder(std::unique_ptr<Transport> inner) : inner_(std::move(inner)) {}

  void close() noexcept override { inner_->close(); }

  bool write(const ReportBytes& report) override {
    const bool sent = inner_->write(report);
    if (sent) note("to the device", report);
    return sent;
  }

  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    const bool came = inner_->read(report, timeout);
    if (came) note("from the device", report);
    return came;
  }

  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    const bool given = inner_->get_feature(id, report);
    if (given) note("asked for", report);
    return given;
  }

  bool set_feature(const ReportBytes& report) override {
    note("set", report);
    return inner_->set_feature(report);
  }

  // An emulated device brings its own time.
  bool time_is_virtual() const override { return inner_->time_is_virtual(); }
  std::int64_t now_ns() const override { return inner_->now_ns(); }
  void advance_to(std::int64_t time_ns) override { inner_->advance_to(time_ns); }

 private:
  /// The SDK reads in one thread and sends from others.
  void note(const char* way, const ReportBytes& report) {
    const std::lock_guard lock(mutex_);
    std::printf("%10.3f ms  %-15s  %02x: %02x %02x %02x %02x ...\n",
                1e-6 * static_cast<double>(now_ns()), way, report[0], report[1], report[2],
                report[3], report[4]);
  }

  const std::unique_ptr<Transport> inner_;
  std::mutex mutex_;
};

}  // namespace

int main(int argc, char** argv) try {
  auto inner = torsio::open_transport(argc > 1 ? argv[1] : "emulated");
  torsio::Knob knob = torsio::Knob::open(std::make_unique<Recorder>(std::move(inner)));
  knob.play(torsio::Wall{.angle_rad = 0.05, .stiffness_nm_per_rad = 1.43});
  std::cout << knob.record(0.01).size() << " samples\n";
} catch (const std::exception& error) {
  std::cerr << "own_transport: " << error.what() << '\n';
  return 1;
}
