// The server's sockets, with a client on a socket of its own.
#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "client.hpp"
#include "device/usb_descriptors.hpp"
#include "emulator/usbip/server.hpp"

using namespace usbip_test;
using namespace std::chrono_literals;
using torsio::emulator::usbip::CannotListen;
using torsio::emulator::usbip::Descriptor;
using torsio::emulator::usbip::Server;
using torsio::emulator::usbip::UsbKnob;

namespace {

struct ServerRig {
  UsbKnob knob{{}};
  std::vector<std::string> told;
  Server server{knob.exported(), "127.0.0.1", 0,
                [this](const std::string& line) { told.push_back(line); }};

  /// Long enough for what is on its way over loopback.
  void serve(int rounds = 20) {
    for (int i = 0; i < rounds; ++i) (void)server.serve(2ms);
  }
};

class Peer {
 public:
  explicit Peer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(port);
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(connect(socket_.get(), reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0);
  }
  void send(const Bytes& bytes) {
    REQUIRE(::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
            static_cast<ssize_t>(bytes.size()));
  }
  /// @returns how much of it there is room for
  std::size_t offer(const Bytes& bytes) {
    const ssize_t sent =
        ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return sent > 0 ? static_cast<std::size_t>(sent) : 0;
  }
  /// Lets as little as possible be on its way from the server, whose end is in this process too.
  void narrow() {
    const int smallest = 1;
    sockaddr_in own{};
    socklen_t size = sizeof own;
    REQUIRE(getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&own), &size) == 0);
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &smallest, sizeof smallest);
    for (int other = 0; other < 1024; ++other) {
      sockaddr_in peer{};
      size = sizeof peer;
      if (getpeername(other, reinterpret_cast<sockaddr*>(&peer), &size) == 0 &&
          peer.sin_port == own.sin_port) {
        setsockopt(other, SOL_SOCKET, SO_SNDBUF, &smallest, sizeof smallest);
      }
    }
  }
  /// The bytes that have come. Sets ended() if the server has hung up.
  Bytes take() {
    Bytes bytes(1 << 16);
    const ssize_t count = recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    ended_ = count == 0 || (count < 0 && errno == ECONNRESET);
    bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return bytes;
  }
  bool ended() {
    while (!take().empty()) {
    }
    return ended_;
  }

 private:
  Descriptor socket_;
  bool ended_ = false;
};

}  // namespace

TEST_CASE("server lists, imports, and hangs up after a list") {
  ServerRig rig;
  Peer first(rig.server.port());
  first.send(kListRequest);
  rig.serve();
  CHECK(first.take().size() == 12 + 312 + 4 * torsio::device::usb_interfaces().size());
  CHECK(first.ended());
  Peer second(rig.server.port());
  second.send(import_request());
  rig.serve();
  CHECK(second.take().size() == 320);
  CHECK_FALSE(second.ended());
  REQUIRE(rig.told.size() == 1);
  CHECK(rig.told[0].starts_with("attached 127.0.0.1:"));
}

TEST_CASE("server refuses a second import and serves the next client after the first has gone") {
  ServerRig rig;
  {
    Peer first(rig.server.port());
    first.send(import_request() + submit_header(1, 1, 1, 64));
    rig.serve();
    Peer second(rig.server.port());
    second.send(import_request());
    rig.serve();
    CHECK(second.take() == words({0x01110003, 2}));
    CHECK(second.ended());
    CHECK_FALSE(first.ended());
  }
  rig.serve();
  CHECK(rig.told.back() == "detached the connection has ended");
  Peer third(rig.server.port());
  third.send(import_request());
  rig.serve();
  CHECK(third.take().size() == 320);
}

TEST_CASE("server can hang up on its client") {
  ServerRig rig;
  Peer peer(rig.server.port());
  peer.send(import_request());
  rig.serve();
  (void)peer.take();
  rig.server.disconnect();
  CHECK(peer.ended());
  CHECK_FALSE(rig.knob.has_host());
}

TEST_CASE("server stays with its client while others only connect") {
  ServerRig rig;
  Peer owner(rig.server.port());
  owner.send(import_request());
  rig.serve();
  (void)owner.take();
  std::list<Peer> idle;
  for (int i = 0; i < 40; ++i) {
    idle.emplace_back(rig.server.port());
    rig.serve(2);
  }
  owner.send(submit_header(1, 1, 0, 18, setup_packet(0x80, 6, 0x0100, 0, 18)));
  rig.serve();
  CHECK(owner.take().size() == 48 + 18);
  // The oldest made room, and only as many as necessary.
  const auto gone = std::ranges::count_if(idle, &Peer::ended);
  CHECK(gone == 41 - static_cast<std::ptrdiff_t>(Server::kMostConnections));
  CHECK(idle.front().ended());
  CHECK_FALSE(idle.back().ended());
}

TEST_CASE("server keeps what a client does not read and sends it later") {
  ServerRig rig;
  Peer peer(rig.server.port());
  peer.send(import_request());
  rig.serve();
  REQUIRE(peer.take().size() == 320);
  constexpr std::size_t kRequests = 2000;
  const Bytes request = submit_header(1, 1, 0, 255, setup_packet(0x80, 6, 0x0200, 0, 255));
  std::size_t expected = 0;
  for (std::size_t i = 0; i < kRequests; ++i) {
    peer.send(request);
    expected += 48 + torsio::device::configuration_descriptor().size();
    if (i % 50 == 0) rig.serve(1);
  }
  std::size_t received = 0;
  for (int i = 0; i < 1000 && received < expected; ++i) {
    rig.serve(1);
    received += peer.take().size();
  }
  CHECK(received == expected);
}

TEST_CASE("server stops reading from a client that does not read") {
  ServerRig rig;
  Peer peer(rig.server.port());
  peer.send(import_request());
  rig.serve();
  peer.narrow();
  REQUIRE(peer.take().size() == 320);
  Bytes requests;
  for (int i = 0; i < 100; ++i) {
    requests = requests + submit_header(1, 1, 0, 255, setup_packet(0x80, 6, 0x0200, 0, 255));
  }
  // The answers are longer than the questions, and only one side has narrow buffers.
  std::size_t taken = 0;
  constexpr std::size_t kEndless = std::size_t{1} << 25U;
  for (int idle = 0; idle < 20 && taken < kEndless;) {
    const std::size_t now = peer.offer(requests);
    taken += now;
    idle = now == 0 ? idle + 1 : 0;
    rig.serve(1);
  }
  CHECK(taken < kEndless);
}

TEST_CASE("server drops a client that breaks the rules and does not read either") {
  ServerRig rig;
  Peer peer(rig.server.port());
  peer.send(import_request());
  rig.serve();
  peer.narrow();
  REQUIRE(peer.take().size() == 320);
  // More than fits on the way, and less than makes the server stop reading.
  const Bytes request = submit_header(1, 1, 0, 255, setup_packet(0x80, 6, 0x0200, 0, 255));
  for (int i = 0; i < 1500; ++i) {
    peer.send(request);
    if (i % 50 == 0) rig.serve(2);
  }
  peer.send(Bytes(48, 0xEE));
  rig.serve(100);
  CHECK(rig.told.back() == "detached sent a request that does not exist");
}
