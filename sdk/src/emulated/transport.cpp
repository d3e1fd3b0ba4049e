// The transport whose other end is an emulated device in this process.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>
#include <utility>

#include "emulated/handle.hpp"
#include "emulated/shared_device.hpp"
#include "emulated_transport.hpp"
#include "link.hpp"

namespace torsio {
namespace {

using namespace std::chrono_literals;

class EmulatedTransport final : public Transport {
 public:
  explicit EmulatedTransport(std::shared_ptr<SharedDevice> device)
      : device_(std::move(device)),
        emulator_(make_handle(device_, [this](std::int64_t ns) { sleep(ns); })) {}

  void close() noexcept override { device_->close(); }

  bool write(const ReportBytes& report) override {
    bool written = false;
    const auto try_to_write = [&](emulator::EmulatedDevice& device) {
      throw_unless_connected(device);
      return written = device.write(report);
    };
    if (!device_->paced()) return device_->with_device(try_to_write);
    // As a driver does: the caller waits for its turn on the bus.
    device_->wait(1s, try_to_write);
    return written;
  }

  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    const auto try_to_read = [&](emulator::EmulatedDevice& device) {
      if (device.read(report)) return true;
      throw_unless_connected(device);
      return false;
    };
    return device_->paced() ? device_->wait(timeout, try_to_read)
                            : device_->with_device(try_to_read);
  }

  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    return device_->with_device([&](emulator::EmulatedDevice& device) {
      throw_unless_connected(device);
      return device.get_feature(id, report) == protocol::Status::ok;
    });
  }

  bool set_feature(const ReportBytes& report) override {
    return device_->with_device([&](emulator::EmulatedDevice& device) {
      throw_unless_connected(device);
      return device.set_feature(report).ok();
    });
  }

  bool time_is_virtual() const override { return !device_->paced(); }

  std::int64_t now_ns() const override {
    if (device_->paced()) return Transport::now_ns();
    return device_->call(&emulator::EmulatedDevice::time_ns);
  }

  void advance_to(std::int64_t time_ns) override {
    device_->with_device([&](emulator::EmulatedDevice& device) {
      try {
        device.advance(std::max<std::int64_t>(time_ns - device.time_ns(), 0));
      } catch (const std::runtime_error& error) {
        throw Error(error.what());
      }
    });
  }

  Emulator* emulator() override { return emulator_.get(); }

 private:
  void sleep(std::int64_t duration_ns) {
    if (device_->paced()) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(duration_ns));
    } else {
      advance_to(now_ns() + duration_ns);
    }
  }

  static void throw_unless_connected(const emulator::EmulatedDevice& device) {
    if (device.connected()) return;
    throw Disconnected(
        "the emulated knob is gone: it was unplugged or lost its power; open it again");
  }

  std::shared_ptr<SharedDevice> device_;
  std::unique_ptr<Emulator> emulator_;
};

}  // namespace

bool has_emulator() noexcept { return true; }

Connection open_emulated(const std::string& name, const EmulatorOptions& options) {
  auto device = std::make_shared<SharedDevice>(name, options);
  Connection connection;
  connection.transport = std::make_unique<EmulatedTransport>(device);
  connection.make_emulator = [device](Link& link) {
    return make_handle(device, [&link](std::int64_t ns) { link.sleep(ns); });
  };
  return connection;
}

}  // namespace torsio
