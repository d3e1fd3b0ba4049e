#include "emulator/usbip/session.hpp"

namespace torsio::emulator::usbip {

Session::~Session() {
  if (!attached()) return;
  export_.owner = nullptr;
  export_.host.unplug();
}

void Session::receive(std::span<const std::uint8_t> bytes) {
  if (finished_) return;
  input_.insert(input_.end(), bytes.begin(), bytes.end());
  std::size_t at = 0;
  while (!finished_) {
    const auto rest = std::span<const std::uint8_t>(input_).subspan(at);
    const std::size_t taken = attached() ? read_request(rest) : read_operation(rest);
    if (taken == 0) break;
    at += taken;
  }
  input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(at));
}

std::size_t Session::give_up(std::string_view problem) {
  finished_ = true;
  problem_ = problem;
  return 0;
}

std::size_t Session::read_operation(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kOperationSize) return 0;
  const OperationHeader header = usbip::read_operation(bytes);
  if (header.version != kVersion) return give_up("speaks another version of USB/IP");
  switch (static_cast<Operation>(header.code)) {
    case Operation::list_devices:
      write_device_list(output_, export_.record);
      finished_ = true;
      return kOperationSize;
    case Operation::import_device:
      if (bytes.size() < kOperationSize + kBusIdSize) return 0;
      import_device(read_bus_id(bytes.subspan(kOperationSize)));
      return kOperationSize + kBusIdSize;
  }
  return give_up("asked for an operation that does not exist");
}

void Session::import_device(std::string_view bus_id) {
  OperationStatus status = OperationStatus::ok;
  if (bus_id != export_.record.bus_id) {
    status = OperationStatus::no_device;
  } else if (!export_.available) {
    status = OperationStatus::not_available;
  } else if (export_.owner != nullptr) {
    status = OperationStatus::busy;
  }
  if (status != OperationStatus::ok) {
    write_refusal(output_, status);
    finished_ = true;
    return;
  }
  export_.owner = this;
  export_.host.plug();
  write_import(output_, export_.record);
}

std::size_t Session::take_back(const Unlink& unlink) {
  if (unlink.device_id != export_.record.id()) return give_up("asked another device");
  const bool was_pending = export_.host.unlink(unlink.target);
  write_unlink_reply(output_, unlink.sequence, was_pending ? kUnlinked : kOk);
  return kHeaderSize;
}

std::size_t Session::read_request(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kHeaderSize) return 0;
  const auto [submit, unlink] = usbip::read_request(bytes);
  if (unlink) return take_back(*unlink);
  if (!submit) return give_up("sent a request that does not exist");
  if (submit->device_id != export_.record.id()) return give_up("asked another device");
  if (submit->packets != 0 && submit->packets != 0xFFFFFFFF) {
    return give_up("asked for an isochronous transfer");
  }
  std::size_t payload = 0;
  if (submit->direction == Direction::out) {
    if (submit->length > HostController::kLongestTransfer) return give_up("sent too much at once");
    payload = submit->length;
  }
  if (bytes.size() < kHeaderSize + payload) return 0;
  if (export_.host.pending() >= kMostPending) return give_up("has too many transfers under way");

  const auto data = bytes.subspan(kHeaderSize, payload);
  completions_.clear();
  export_.host.submit(*submit, Bytes(data.begin(), data.end()), completions_);
  reply(completions_);
  return kHeaderSize + payload;
}

void Session::frame() {
  if (!attached()) return;
  completions_.clear();
  export_.host.frame(completions_);
  reply(completions_);
}

void Session::reply(const std::vector<Completion>& completions) {
  for (const Completion& completion : completions) {
    write_submit_reply(output_, completion.request, completion.status, completion.actual_length,
                       completion.data);
  }
}

}  // namespace torsio::emulator::usbip
