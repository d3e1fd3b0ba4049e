// Clients of the USB/IP server over real sockets of this machine. An input is a row of steps: one
// byte that says which of three clients connects, sends, hangs up or reads, and what it sends.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "emulator/usbip/server.hpp"
#include "emulator/usbip/usb_knob.hpp"
#include "fuzz.hpp"

namespace {

using namespace torsio::emulator::usbip;

// Operations of USB/IP, and the import of the knob as a whole message.
constexpr std::string_view kWords[] = {
    std::string_view("\x01\x11\x80\x05\0\0\0\0", 8),
    std::string_view("\x01\x11\x80\x03\0\0\0\0"
                     "1-1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
                     40),
    std::string_view("\0\0\0\x01\0\0\0\x01\0\x01\0\x02\0\0\0\x01\0\0\0\0", 20),
    std::string_view("\0\0\0\x02", 4),
};

class Client {
 public:
  ~Client() { hang_up(); }
  Client() = default;
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void connect(std::uint16_t port) {
    hang_up();
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    const sockaddr_in address{.sin_family = AF_INET,
                              .sin_port = htons(port),
                              .sin_addr = {htonl(INADDR_LOOPBACK)},
                              .sin_zero = {}};
    (void)::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  void send(std::span<const std::uint8_t> bytes) {
    if (socket_ >= 0) (void)::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  void read() {
    std::array<char, 512> ignored{};
    if (socket_ >= 0) (void)::recv(socket_, ignored.data(), ignored.size(), 0);
  }
  /// With a reset, so that no port waits for its end.
  void hang_up() {
    if (socket_ < 0) return;
    const linger at_once{.l_onoff = 1, .l_linger = 0};
    (void)::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    ::close(socket_);
    socket_ = -1;
  }

 private:
  int socket_ = -1;
};

}  // namespace

std::span<const std::string_view> fuzz::dictionary() { return kWords; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // One knob and one server for all inputs: each must be left as it was found.
  static UsbKnob knob({});
  static Server server(knob.exported(), "127.0.0.1", 0, [](const std::string&) {});
  std::array<Client, 3> clients;
  fuzz::Reader input(data, size);
  for (int left = 64; left > 0 && !input.empty(); --left) {
    const std::uint8_t what = input.byte();
    Client& client = clients[what % clients.size()];
    switch (what / 4 % 6) {
      case 0:
        client.connect(server.port());
        break;
      case 1:
        client.hang_up();
        break;
      case 2:
        client.read();
        break;
      case 3:
        server.frame();
        break;
      default:
        client.send(input.bytes(input.byte()));
    }
    (void)server.serve({});
  }
  for (Client& client : clients) client.hang_up();
  for (int round = 0; round < 3; ++round) (void)server.serve({});

  // Whatever that was, the next client is heard.
  Client& next = clients[0];
  next.connect(server.port());
  (void)server.serve({});
  next.send(std::span(reinterpret_cast<const std::uint8_t*>(kWords[0].data()), kWords[0].size()));
  for (int round = 0; round < 3; ++round) (void)server.serve({});
  next.hang_up();
  (void)server.serve({});
  return 0;
}
