// Clients of the USB/IP server. An input is a row of steps: a byte that says which of three clients
// connects, sends, reads or goes, then its data. The server is the real one; its system calls are
// answered from memory, ten times faster than TCP, with interrupted calls and full buffers.
// tests/cpp/usbip/test_usbip_server.cpp has real sockets.
#include <errno.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <memory>
#include <string>

#include "emulator/usbip/server.hpp"
#include "emulator/usbip/usb_knob.hpp"
#include "fuzz.hpp"
#include "usbip_messages.hpp"

namespace {

using namespace torsio::emulator::usbip;

/// The server system's side of a connection.
struct Line {
  std::deque<std::uint8_t> to_server;
  std::deque<std::uint8_t> to_client;
  bool ended = false;   // the client sends no more
  bool reset = false;   // it is gone
  bool closed = false;  // the server has hung up
};

// No file of the process has so large a number.
constexpr int kFirstNumber = 1'000'000;
// Small enough to be full now and then.
constexpr std::size_t kBuffer = 1024;
constexpr std::size_t kBacklog = 8;

struct Network {
  std::deque<std::shared_ptr<Line>> arriving;
  std::map<int, std::shared_ptr<Line>> lines;  // by the server's number of them
  int next_number = kFirstNumber;
  bool interrupts = false;  // the next call

  bool interrupted() {
    if (!interrupts) return false;
    interrupts = false;
    errno = EINTR;
    return true;
  }
} network;

int fails(int why) {
  errno = why;
  return -1;
}

}  // namespace

// The linker redirects the server's calls to here, see CMakeLists.txt. Only the listening socket is
// real, and nobody connects to it.
extern "C" {
int __real_close(int number);

int __wrap_ppoll(pollfd* watched, nfds_t count, const timespec*, const void*) {
  if (network.interrupted()) return -1;
  int ready = 0;
  for (pollfd& one : std::span(watched, count)) {
    int happens = 0;
    if (one.fd >= kFirstNumber) {
      const Line& line = *network.lines.at(one.fd);
      if (!line.to_server.empty() || line.ended) happens |= one.events & POLLIN;
      if (line.to_client.size() < kBuffer) happens |= one.events & POLLOUT;
      if (line.reset) happens |= POLLERR | POLLHUP;
    } else if (one.fd >= 0 && !network.arriving.empty()) {
      happens = POLLIN;
    }
    one.revents = static_cast<short>(happens);
    ready += one.revents != 0 ? 1 : 0;
  }
  return ready;
}
int __wrap_accept4(int, sockaddr* peer, socklen_t* size, int) {
  if (network.interrupted()) return -1;
  if (network.arriving.empty()) return fails(EAGAIN);
  std::fill_n(reinterpret_cast<char*>(peer), *size, '\0');
  const int number = network.next_number++;
  network.lines.emplace(number, network.arriving.front());
  network.arriving.pop_front();
  return number;
}
int __wrap_setsockopt(int, int, int, const void*, socklen_t) { return 0; }
ssize_t __wrap_recv(int number, void* bytes, std::size_t size, int) {
  if (network.interrupted()) return -1;
  Line& line = *network.lines.at(number);
  if (line.reset) return fails(ECONNRESET);
  if (line.to_server.empty()) return line.ended ? 0 : fails(EAGAIN);
  const auto count = static_cast<std::ptrdiff_t>(std::min(size, line.to_server.size()));
  std::copy_n(line.to_server.begin(), count, static_cast<std::uint8_t*>(bytes));
  line.to_server.erase(line.to_server.begin(), line.to_server.begin() + count);
  return count;
}
ssize_t __wrap_send(int number, const void* bytes, std::size_t size, int flags) {
  fuzz::require((flags & MSG_NOSIGNAL) != 0, "a client that is gone does not end the program");
  if (network.interrupted()) return -1;
  Line& line = *network.lines.at(number);
  if (line.reset) return fails(EPIPE);
  if (line.to_client.size() >= kBuffer) return fails(EAGAIN);
  const std::size_t count = std::min(size, kBuffer - line.to_client.size());
  const auto* first = static_cast<const std::uint8_t*>(bytes);
  line.to_client.insert(line.to_client.end(), first, first + count);
  return static_cast<ssize_t>(count);
}
int __wrap_close(int number) {
  if (number < kFirstNumber) return __real_close(number);
  fuzz::require(network.lines.contains(number), "what is closed was open");
  network.lines.at(number)->closed = true;
  network.lines.erase(number);
  return 0;
}
}

namespace {

class Client {
 public:
  ~Client() { reset(); }
  Client() = default;
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void connect() {
    reset();
    if (network.arriving.size() >= kBacklog) return;
    line_ = std::make_shared<Line>();
    network.arriving.push_back(line_);
  }
  void send(std::span<const std::uint8_t> bytes) {
    if (line_ == nullptr || line_->ended || line_->closed) return;
    line_->to_server.insert(line_->to_server.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::uint8_t> read() {
    if (line_ == nullptr) return {};
    std::vector<std::uint8_t> bytes(line_->to_client.begin(), line_->to_client.end());
    line_->to_client.clear();
    return bytes;
  }
  void end() {
    if (line_ != nullptr) line_->ended = true;
  }
  void reset() {
    if (line_ != nullptr) line_->reset = true;
    line_.reset();
  }

 private:
  std::shared_ptr<Line> line_;
};

enum class Step : std::uint8_t { connect, reset, read, frame, end, interrupt, send };
constexpr std::uint8_t kSteps = 8;  // sends twice as often
constexpr std::uint8_t kClients = 3;
constexpr std::uint8_t code(Step step, std::size_t client) {
  return static_cast<std::uint8_t>(client + kClients * static_cast<std::size_t>(step));
}

}  // namespace

std::span<const std::string_view> fuzz::dictionary() { return fuzz::kUsbipWords; }

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  fuzz::FieldMaker make(seed);
  const std::size_t client = make.below(kClients);
  std::vector<std::uint8_t> piece;
  if (make.below(3) == 0) {
    piece = {code(static_cast<Step>(make.below(static_cast<std::size_t>(Step::send))), client)};
  } else {
    const bool arrives = size == 0 || make.below(8) == 0;
    const auto message = arrives ? usbip_test::import_request() : fuzz::message(make);
    if (arrives) piece = {code(Step::connect, client)};
    piece.push_back(code(Step::send, client));
    piece.push_back(static_cast<std::uint8_t>(message.size()));
    piece.insert(piece.end(), message.begin(), message.end());
    piece.push_back(code(Step::frame, client));
  }
  return fuzz::put(piece, std::span(data, max_size), size, make);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // One knob and one server for all inputs: each must be left as it was found.
  static UsbKnob knob({});
  static Server server(knob.exported(), "127.0.0.1", 0, [](const std::string&) {});
  std::array<Client, kClients> clients;
  fuzz::Reader input(data, size);
  for (int left = 64; left > 0 && !input.empty(); --left) {
    const std::uint8_t what = input.byte();
    Client& client = clients[what % kClients];
    switch (static_cast<Step>(what / kClients % kSteps)) {
      case Step::connect:
        client.connect();
        break;
      case Step::reset:
        client.reset();
        break;
      case Step::read:
        (void)client.read();
        break;
      case Step::frame:
        server.frame();
        break;
      case Step::end:
        client.end();
        break;
      case Step::interrupt:
        network.interrupts = true;
        break;
      default:
        client.send(input.bytes(input.byte()));
    }
    (void)server.serve({});
    fuzz::require(network.lines.size() <= Server::kMostConnections, "not more than so many");
  }
  for (Client& client : clients) client.reset();
  network.interrupts = false;
  for (int round = 0; round < 2; ++round) (void)server.serve({});
  fuzz::require(network.lines.empty(), "who has gone leaves nothing");

  // Whatever that was, the next client gets the knob.
  Client& next = clients[0];
  next.connect();
  (void)server.serve({});
  next.send(usbip_test::import_request());
  (void)server.serve({});
  const auto reply = next.read();
  fuzz::require(reply.size() == 8 + 312 && reply[3] == 0x03 && usbip_test::word(reply, 4) == 0,
                "the next client gets the knob");
  next.reset();
  (void)server.serve({});
  return 0;
}
