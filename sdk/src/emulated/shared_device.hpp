/// @file
/// An emulated device and who may touch it when: the transport and the user's handle share it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "emulated/claim.hpp"
#include "emulator/emulated_device.hpp"
#include "fair_mutex.hpp"
#include "process.hpp"
#include "torsio/emulator.hpp"
#include "torsio/error.hpp"

namespace torsio {

/// Runs `make`. An error of the emulator is a mistake of the user, or of the user's hand.
template <class Make>
auto checked(Make&& make) {
  try {
    return make();
  } catch (const Error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Error(error.what());
  } catch (const std::invalid_argument& error) {
    throw InvalidArgument(error.what());
  }
}

class SharedDevice {
 public:
  /// @throws InvalidArgument, DeviceBusy
  SharedDevice(const std::string& name, const EmulatorOptions& options);
  SharedDevice(const SharedDevice&) = delete;
  SharedDevice& operator=(const SharedDevice&) = delete;
  ~SharedDevice() { close(); }

  void close() noexcept;

  /// Calls `use(device)` while nobody else touches it. @throws Closed
  template <class Use>
  auto with_device(Use&& use) const {
    throw_unless_here();
    const std::lock_guard lock(mutex_);
    throw_if_closed();
    throw_if_failed();
    return use(*device_);
  }

  /// Likewise `(device.*member)(given...)`.
  template <class Member, class... Given>
  auto call(Member member, const Given&... given) const {
    return with_device([&](auto& device) { return (device.*member)(given...); });
  }

  /// As above; waits until `ready(device)` or the time is over. @returns false if it is over
  template <class Ready>
  bool wait(std::chrono::nanoseconds timeout, Ready&& ready) const {
    throw_unless_here();
    std::unique_lock lock(mutex_);
    return news_.wait_for(lock, timeout, [&] {
      throw_if_closed();
      throw_if_failed();
      return ready(*device_);
    });
  }

  void notify() const { news_.notify_all(); }
  [[nodiscard]] bool paced() const { return paced_; }
  [[nodiscard]] bool logs_truth() const { return logs_truth_; }
  [[nodiscard]] bool logs_inputs() const { return logs_inputs_; }

 private:
  void throw_unless_here() const;
  void throw_if_closed() const;
  void throw_if_failed() const;
  void run_paced();

  const MakersProcess process_;
  Claim claim_;
  const bool paced_;
  const bool logs_truth_;
  const bool logs_inputs_;
  mutable FairMutex mutex_;  // a world that is late all the time must let others in
  mutable std::condition_variable_any news_;
  std::unique_ptr<emulator::EmulatedDevice> device_;
  bool closed_ = false;
  std::string failure_;  // why time does not go on
  std::thread pacer_;
};

}  // namespace torsio
