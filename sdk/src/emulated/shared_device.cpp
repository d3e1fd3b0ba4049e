#include "emulated/shared_device.hpp"

#include <cmath>
#include <cstdint>
#include <utility>

#include "conversion/configuration.hpp"
#include "emulator/plant/ranges.hpp"
#include "torsio/fields.hpp"

namespace torsio {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

emulator::EmulatedDeviceOptions to_emulator(const EmulatorOptions& in, const std::string& name,
                                            const device::StoredSlots& stored) {
  emulator::EmulatedDeviceOptions out;
  out.seed = in.seed;
  emulator::require_as(&EmulatorOptions::control_rate_hz, in.control_rate_hz, "");
  out.control_period_ns = std::llround(1e9 / in.control_rate_hz);
  out.plant = in.plant;
  out.encoder = emulator::encoder_of(in.plant);
  out.hand = emulator::take_hold(in.hand);
  out.serial = !in.serial.empty() ? in.serial : !name.empty() ? name : std::string(kEmulatedSerial);
  out.stored = stored;
  protocol::for_each_configuration(out.given, [&in](auto& place) {
    const auto take = [&place](const auto& option) {
      if constexpr (requires { place = conversion::to_wire(*option); }) {
        if (option) place = conversion::to_wire(*option);
      }
    };
    Fields<EmulatorOptions>::apply([&](const auto&... field) { (take(in.*field.member), ...); });
  });
  out.log_truth = in.log_truth;
  out.log_inputs = in.log_inputs;
  return out;
}

}  // namespace

SharedDevice::SharedDevice(const std::string& name, const EmulatorOptions& options)
    : claim_(name),
      paced_(options.paced),
      logs_truth_(options.log_truth),
      logs_inputs_(options.log_inputs),
      device_(checked([&] {
        return std::make_unique<emulator::EmulatedDevice>(
            to_emulator(options, name, claim_.stored()));
      })) {
  if (paced_) pacer_ = std::thread([this] { run_paced(); });
}

void SharedDevice::close() noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(closed_, true)) return;
    claim_.release(&device_->stored());
  }
  news_.notify_all();
  if (pacer_.joinable()) pacer_.join();
}

void SharedDevice::throw_unless_here() const {
  if (process_.is_this()) return;
  throw Closed("the emulated knob belongs to the process that this one was forked from");
}

void SharedDevice::throw_if_closed() const {
  if (closed_) throw Closed("the emulated knob was closed; open it again");
}

void SharedDevice::throw_if_failed() const {
  if (!failure_.empty()) throw Error(failure_);
}

void SharedDevice::run_paced() {
  constexpr auto kFrame = std::chrono::nanoseconds(emulator::UsbLink::kFrameNs);
  constexpr auto kHopelesslyLate = 50ms;
  auto next = steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!closed_) {
    try {
      device_->advance(kFrame.count());
    } catch (const std::exception& error) {
      failure_ = error.what();  // for the next call
      news_.notify_all();
      return;
    }
    news_.notify_all();
    next += kFrame;
    // A machine that slept must not make the world race.
    const auto now = steady_clock::now();
    if (now - next > kHopelesslyLate) next = now;
    // Also if there is no time left: a waiting thread is next.
    lock.unlock();
    lock.lock();
    news_.wait_until(lock, next, [&] { return closed_ || steady_clock::now() >= next; });
  }
}

}  // namespace torsio
