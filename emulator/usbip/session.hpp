/// @file
/// One client's conversation, from its first byte to its last: bytes in, bytes out, no sockets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "emulator/usbip/host_controller.hpp"
#include "emulator/usbip/messages.hpp"

namespace torsio::emulator::usbip {

class Session;

/// The one device that there is to import, and who has it.
struct Export {
  DeviceRecord record;
  HostController& host;
  const Session* owner = nullptr;
  bool available = true;  // false: nobody can import it now
};

class Session {
 public:
  /// More transfers than a driver has under way; a client with more of them is lost.
  static constexpr std::size_t kMostPending = 1024;

  explicit Session(Export& exported) : export_(exported) {}
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  /// Pulls the plug if the client had the device.
  ~Session();

  /// Takes what the client has sent, in pieces of any size.
  void receive(std::span<const std::uint8_t> bytes);

  /// One frame of 1 ms, for the session that has the device.
  void frame();

  /// Bytes for the client. The sender takes them away.
  [[nodiscard]] Bytes& output() { return output_; }

  [[nodiscard]] bool attached() const { return export_.owner == this; }
  /// Nothing more will come: close the connection when the output is sent.
  [[nodiscard]] bool finished() const { return finished_; }
  /// The client's error; empty if none.
  [[nodiscard]] std::string_view problem() const { return problem_; }

 private:
  /// @returns how many bytes it took; 0: it needs more of them
  std::size_t read_operation(std::span<const std::uint8_t> bytes);
  std::size_t read_request(std::span<const std::uint8_t> bytes);
  std::size_t take_back(const Unlink& unlink);
  void import_device(std::string_view bus_id);
  void reply(const std::vector<Completion>& completions);
  std::size_t give_up(std::string_view problem);

  Export& export_;
  Bytes input_;
  Bytes output_;
  std::vector<Completion> completions_;
  bool finished_ = false;
  std::string_view problem_;
};

}  // namespace torsio::emulator::usbip
