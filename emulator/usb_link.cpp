#include "emulator/usb_link.hpp"

#include <stdexcept>
#include <string>

#include "emulator/plant/ranges.hpp"

namespace torsio::emulator {

UsbLink::UsbLink(std::uint64_t seed, std::size_t input_queue_reports)
    : input_queue_reports_(input_queue_reports), random_(seed) {}

bool UsbLink::write(const protocol::ReportBytes& report) {
  if (!can_write()) return false;
  output_.push_back(report);
  return true;
}

bool UsbLink::read(protocol::ReportBytes& report) {
  if (input_.empty()) return false;
  report = input_.front();
  input_.pop_front();
  return true;
}

std::optional<protocol::ReportBytes> UsbLink::frame(device::Device& device) {
  std::optional<protocol::ReportBytes> taken;
  if (!output_.empty()) {
    protocol::ReportBytes& report = output_.front();
    if (random_.happens(faults_.corrupt_output)) corrupt(report);
    if (random_.happens(faults_.drop_output)) {
      output_.pop_front();
    } else if (device.receive(report)) {
      taken = report;
      output_.pop_front();
    }
  }

  protocol::ReportBytes report;
  if (!device.next_input(report)) return taken;
  if (random_.happens(faults_.drop_input)) return taken;
  if (random_.happens(faults_.corrupt_input)) corrupt(report);
  if (input_.size() < input_queue_reports_) input_.push_back(report);
  return taken;
}

void UsbLink::clear() {
  output_.clear();
  input_.clear();
}

void UsbLink::set_faults(const LinkFaults& faults) {
  require_ranges(faults, "");
  faults_ = faults;
}

void UsbLink::corrupt(protocol::ReportBytes& report) {
  const std::uint64_t bit = random_.next() % (8 * report.size());
  report[bit / 8] = static_cast<std::uint8_t>(report[bit / 8] ^ (1U << (bit % 8)));
}

}  // namespace torsio::emulator
