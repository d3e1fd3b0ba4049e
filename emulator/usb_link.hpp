/// @file
/// The USB cable of an emulated device: queues of reports, one each way in a frame, with faults.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "device/device.hpp"
#include "emulator/random.hpp"
#include "protocol/codec.hpp"
#include "torsio/plant.hpp"

namespace torsio::emulator {

/// The cable and the host's driver at full speed. In each frame of 1 ms at most one output report
/// reaches the device, and the driver fetches at most one input report.
class UsbLink {
 public:
  static constexpr std::int64_t kFrameNs = 1'000'000;
  /// Output reports that wait at the host. A full queue refuses the next report; none is lost.
  static constexpr std::size_t kOutputQueueReports = 16;

  /// @param input_queue_reports input reports that the host keeps until they are read. As in
  ///        Linux's hidraw, which keeps 64, what comes while the queue is full is lost.
  UsbLink(std::uint64_t seed, std::size_t input_queue_reports);

  /// Host: puts an output report into the queue. @returns false if it is full
  [[nodiscard]] bool write(const protocol::ReportBytes& report);

  /// Host: takes the oldest input report. @returns false if there is none
  [[nodiscard]] bool read(protocol::ReportBytes& report);

  /// One frame. An output report that the device has no room for is offered again in the next one.
  /// @returns the output report that the device has taken, if there was one
  std::optional<protocol::ReportBytes> frame(device::Device& device);

  /// Forgets everything on the way, as pulling the plug does.
  void clear();

  /// A corrupted report has one bit flipped.
  /// @throws std::invalid_argument that names the field which is out of its range
  void set_faults(const LinkFaults& faults);

  [[nodiscard]] bool can_write() const { return output_.size() < kOutputQueueReports; }

 private:
  void corrupt(protocol::ReportBytes& report);

  std::deque<protocol::ReportBytes> output_;
  std::deque<protocol::ReportBytes> input_;
  std::size_t input_queue_reports_;
  LinkFaults faults_;
  Random random_;
};

}  // namespace torsio::emulator
