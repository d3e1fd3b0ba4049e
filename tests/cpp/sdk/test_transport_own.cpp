// Transports of the user's own: their duties, and how the SDK takes what they do.
#include <doctest/doctest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/reports.hpp"
#include "sdk/errors.hpp"
#include "sdk/wrapped_transport.hpp"
#include "torsio/knob.hpp"
#include "torsio/transport.hpp"

using namespace torsio;
using test::contains;
using test::message_of;
using test::WrappedTransport;

namespace {

class Failing final : public WrappedTransport {
 public:
  Failing(std::unique_ptr<Transport> inner, const std::atomic<bool>& fails)
      : WrappedTransport(std::move(inner)), fails_(fails) {}
  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    if (fails_) throw std::runtime_error("the carrier pigeon is lost");
    return WrappedTransport::read(report, timeout);
  }

 private:
  const std::atomic<bool>& fails_;
};

/// Asks before each report that goes out; without a yes it has no room.
class Asking final : public WrappedTransport {
 public:
  using Takes = std::function<bool(const ReportBytes&)>;
  Asking(std::unique_ptr<Transport> inner, Takes takes)
      : WrappedTransport(std::move(inner)), takes_(std::move(takes)) {}
  bool write(const ReportBytes& report) override {
    return takes_(report) && WrappedTransport::write(report);
  }

 private:
  const Takes takes_;
};

std::unique_ptr<Transport> recorded(std::unique_ptr<Transport> inner,
                                    std::vector<ReportBytes>& sent) {
  return std::make_unique<Asking>(std::move(inner), [&](const ReportBytes& report) {
    sent.push_back(report);
    return true;
  });
}

/// An order to arm waits in it until the order to disarm has passed; keeps the orders' codes.
class Slow final : public WrappedTransport {
 public:
  struct Orders {
    std::atomic<bool> arms = false;
    std::atomic<bool> disarmed = false;
    std::mutex mutex;
    std::vector<int> passed;
  };
  Slow(std::unique_ptr<Transport> inner, Orders& orders)
      : WrappedTransport(std::move(inner)), orders_(orders) {}
  bool write(const ReportBytes& report) override {
    if (report[0] != 0x10 || report[4] == 0) return WrappedTransport::write(report);
    if (report[4] == 1) {
      orders_.arms = true;
      orders_.disarmed.wait(false);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    const std::lock_guard lock(orders_.mutex);
    orders_.passed.push_back(report[4]);
    const bool taken = WrappedTransport::write(report);
    if (report[4] == 2) {
      orders_.disarmed = true;
      orders_.disarmed.notify_all();
    }
    return taken;
  }

 private:
  Orders& orders_;
};

/// Returns once the order is in the transport.
std::thread arm_slowly(Knob& knob, const Slow::Orders& orders) {
  std::thread arms([&] {
    try {
      knob.arm();
    } catch (const Closed&) {  // NOLINT(bugprone-empty-catch): the answer may come or not
    }
  });
  while (!orders.arms) std::this_thread::yield();
  return arms;
}

// A wire of two sockets: one for questions and answers, one for the device's reports. Each message
// has one size: a question or a result, and a report.
struct Message {
  std::uint8_t what = 0;
  ReportBytes report{};
};
static_assert(sizeof(Message) == 65);
enum What : std::uint8_t { kWrite, kGetFeature, kSetFeature };

void send(int socket, const Message& message) {
  (void)::send(socket, &message, sizeof message, MSG_NOSIGNAL);
}

bool receive(int socket, Message& message, int timeout_ms) {
  pollfd ready{.fd = socket, .events = POLLIN, .revents = 0};
  if (::poll(&ready, 1, timeout_ms) <= 0) return false;
  if (::recv(socket, &message, sizeof message, MSG_WAITALL) == sizeof message) return true;
  throw Disconnected("the wire is cut");
}

struct Wire {
  std::array<int, 2> questions{};
  std::array<int, 2> input{};
  Wire() {
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, questions.data()) == 0);
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, input.data()) == 0);
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  ~Wire() {
    for (const int socket : {questions[0], questions[1], input[0], input[1]}) ::close(socket);
  }
  /// Both ends hear of it.
  void cut() const {
    ::shutdown(questions[0], SHUT_RDWR);
    ::shutdown(input[0], SHUT_RDWR);
  }
};

/// The far end: serves a paced emulated knob until the wire is cut.
class Server {
 public:
  explicit Server(const Wire& wire) : wire_(wire) {
    OpenOptions options;
    options.emulator.emplace().paced = true;
    device_ = open_transport("emulated", options);
    thread_ = std::thread([this] { serve(); });
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server() {
    wire_.cut();
    thread_.join();
    device_->close();
  }

 private:
  void serve() {
    try {
      while (true) {
        Message message;
        while (receive(wire_.questions[1], message, 0)) {
          message.what = do_it(message);
          send(wire_.questions[1], message);
        }
        if (device_->read(message.report, std::chrono::milliseconds(1))) {
          send(wire_.input[1], message);
        }
      }
    } catch (const Disconnected&) {  // NOLINT(bugprone-empty-catch): the end
    }
  }
  bool do_it(Message& message) {
    if (message.what == kWrite) return device_->write(message.report);
    if (message.what == kSetFeature) return device_->set_feature(message.report);
    return device_->get_feature(message.report[0], message.report);
  }

  const Wire& wire_;
  std::unique_ptr<Transport> device_;
  std::thread thread_;
};

/// The near end.
class WireTransport final : public Transport {
 public:
  explicit WireTransport(const Wire& wire) : wire_(wire) {}
  void close() noexcept override {}
  bool write(const ReportBytes& report) override { return ask({kWrite, report}).what != 0; }
  bool set_feature(const ReportBytes& report) override {
    return ask({kSetFeature, report}).what != 0;
  }
  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    const Message answer = ask({kGetFeature, {id}});
    report = answer.report;
    return answer.what != 0;
  }
  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    Message message;
    const auto timeout_ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
    if (!receive(wire_.input[0], message, static_cast<int>(timeout_ms))) return false;
    report = message.report;
    return true;
  }

 private:
  Message ask(const Message& question) {
    const std::lock_guard lock(mutex_);
    send(wire_.questions[0], question);
    Message answer;
    while (!receive(wire_.questions[0], answer, 1000)) {
    }
    return answer;
  }

  const Wire& wire_;
  std::mutex mutex_;
};

OpenOptions pushed_knob() {
  OpenOptions options;
  options.emulator.emplace().hand = TorqueHand{{{0.0, 0.05}}};
  return options;
}

std::vector<TelemetrySample> feel(Knob knob) {
  knob.arm();
  knob.play(Wall{.angle_rad = 0.1, .stiffness_nm_per_rad = 1.0});
  return knob.record(0.3);
}

}  // namespace

TEST_CASE("a transport without room ends every order with Timeout, and close lets go of it") {
  for (const bool is_paced : {true, false}) {
    CAPTURE(is_paced);
    std::atomic<bool> is_full = false;
    const auto has_room = [&](const ReportBytes&) { return !is_full; };
    OpenOptions device;
    device.emulator.emplace().paced = is_paced;
    Knob knob = Knob::open(std::make_unique<Asking>(open_transport("emulated", device), has_room),
                           {.command_timeout_s = 0.05});
    knob.play(Spring{.stiffness_nm_per_rad = 0.1});
    knob.arm();
    is_full = true;
    CHECK_THROWS_WITH_AS(knob.disarm(), doctest::Contains("no room within 50 ms"), Timeout);
    CHECK_THROWS_AS(knob.stop(), Timeout);
    CHECK_THROWS_AS(knob.play(Spring{.stiffness_nm_per_rad = 0.2}), Timeout);
    CHECK_THROWS_AS(knob.stream_local_model({}), Timeout);
    CHECK_THROWS_AS(knob.start_telemetry(), Timeout);
    if (is_paced) {
      is_full = false;  // room again: it goes on
      knob.disarm();
      is_full = true;
    }
    knob.close();
    CHECK_FALSE(knob.is_open());
  }
}

TEST_CASE("close says once that a transport had no room for the order to disarm") {
  for (const bool disarms_before : {true, false}) {
    CAPTURE(disarms_before);
    std::atomic<bool> is_full = false;
    const auto has_room = [&](const ReportBytes&) { return !is_full; };
    Knob knob = Knob::open(std::make_unique<Asking>(open_transport("emulated"), has_room));
    knob.play(Spring{.stiffness_nm_per_rad = 0.1});
    knob.arm();
    is_full = true;
    if (disarms_before) knob.disarm_to_close();
    CHECK_FALSE(knob.close());
    CHECK(knob.close());
  }
}

TEST_CASE("close disarms behind an order to arm that is under way") {
  for (const bool is_paced : {false, true}) {
    CAPTURE(is_paced);
    OpenOptions device;
    device.emulator.emplace().paced = is_paced;
    Slow::Orders orders;
    Knob knob = Knob::open(std::make_unique<Slow>(open_transport("emulated", device), orders));
    std::thread arms = arm_slowly(knob, orders);
    CHECK(knob.close());
    arms.join();
    CHECK(orders.passed == std::vector{2, 1, 2});
  }
}

TEST_CASE("an order to disarm does not hide one to arm that is under way") {
  Slow::Orders orders;
  OpenOptions device;
  device.emulator.emplace().paced = true;
  Knob knob = Knob::open(std::make_unique<Slow>(open_transport("emulated", device), orders));
  std::thread arms = arm_slowly(knob, orders);
  knob.disarm();
  knob.close();
  arms.join();
  CHECK(orders.passed.back() == 2);
}

TEST_CASE("a knob over a transport that wraps another one plays just the same") {
  std::vector<ReportBytes> sent;
  auto inner = open_transport("emulated", pushed_knob());
  const auto wrapped = feel(Knob::open(recorded(std::move(inner), sent)));
  const auto direct = feel(Knob::open("emulated", pushed_knob()));
  REQUIRE(wrapped.size() == direct.size());
  CHECK(wrapped.back().angle_rad > 0.1);
  for (std::size_t i = 0; i < direct.size(); ++i) {
    CHECK(wrapped[i].angle_rad == direct[i].angle_rad);
  }
  // docs/reference/protocol.md: command (0x10) with arm (1), then the wall (0x20) somewhere behind
  // it.
  REQUIRE_FALSE(sent.empty());
  CHECK(sent.front()[0] == 0x10);
  CHECK(sent.front()[4] == 1);
  CHECK(std::ranges::any_of(sent, [](const ReportBytes& report) { return report[0] == 0x20; }));
}

TEST_CASE("who closes a knob disarms it, unless a game or the dial has it") {
  for (const Owner owner : {Owner::sdk, Owner::game, Owner::dial}) {
    CAPTURE(static_cast<int>(owner));
    std::vector<ReportBytes> sent;
    auto inner = test::emulated_with<protocol::Health>([owner](protocol::Health& health) {
      health.state = protocol::State::armed;
      health.owner = static_cast<protocol::Owner>(owner);
    });
    Knob knob = Knob::open(recorded(std::move(inner), sent));
    REQUIRE(knob.state() == State::armed);
    knob.close();
    // docs/reference/protocol.md: command (0x10) with disarm (2).
    const auto disarms = [](const ReportBytes& report) {
      return report[0] == 0x10 && report[4] == 2;
    };
    CHECK(std::ranges::any_of(sent, disarms) == (owner == Owner::sdk));
  }
}

TEST_CASE("signs of life are given while the torque is on, and only then") {
  for (const bool is_paced : {false, true}) {
    CAPTURE(is_paced);
    OpenOptions options;
    options.emulator.emplace().paced = is_paced;
    std::atomic<int> signs = 0;
    // docs/reference/protocol.md: command (0x10) with keep_alive (0).
    const auto count = [&](const ReportBytes& report) {
      if (report[0] == 0x10 && report[4] == 0) ++signs;
      return true;
    };
    Knob knob = Knob::open(std::make_unique<Asking>(open_transport("emulated", options), count));
    knob.sleep(0.3);
    CHECK(signs == 0);
    knob.arm();
    for (int left = 100; left > 0 && signs < 2; --left) knob.sleep(0.1);
    CHECK(signs >= 2);
  }
}

TEST_CASE("a device that says whose it is though it is not armed is not told to disarm") {
  std::vector<ReportBytes> sent;
  auto inner = test::emulated_with<protocol::Health>(
      [](protocol::Health& health) { health.owner = protocol::Owner::sdk; });
  Knob::open(recorded(std::move(inner), sent)).close();
  CHECK(sent.empty());
}

TEST_CASE("a knob over the user's transport says so, and knows no world and no path") {
  const Knob knob = Knob::open(std::make_unique<WrappedTransport>(open_transport("emulated")));
  CHECK_FALSE(knob.is_emulated());
  CHECK_THROWS_AS((void)knob.emulator(), Error);
  CHECK(knob.info().transport == "own");
  CHECK(knob.info().path.empty());
  CHECK(knob.info().board == "emulated");
}

TEST_CASE("no transport is an InvalidArgument") {
  CHECK(
      contains(message_of<InvalidArgument>([] { (void)Knob::open(std::unique_ptr<Transport>()); }),
               "no transport"));
}

TEST_CASE("emulator options are not for a transport that is there already") {
  const auto open = [] {
    (void)Knob::open(std::make_unique<WrappedTransport>(open_transport("emulated")), pushed_knob());
  };
  CHECK(contains(message_of<InvalidArgument>(open), "open_transport()"));
}

TEST_CASE("a transport across a wire, in real time, carries commands and telemetry") {
  const Wire wire;
  const Server server(wire);
  Knob knob = Knob::open(std::make_unique<WireTransport>(wire), {.command_timeout_s = 30.0});
  knob.arm();
  knob.play(Wall{.stiffness_nm_per_rad = 1});
  CHECK(knob.record(0.1).size() == 100);
  knob.disarm();
  knob.configure(ControlConfig{.beta = 0.25});
  CHECK(knob.control_config().beta == 0.25);
  wire.cut();
  CHECK(contains(message_of<Disconnected>([&] { knob.sleep(60.0); }), "the wire is cut"));
  CHECK(knob.state() == State::disconnected);
}

TEST_CASE("whatever comes out of a transport's read, in real time or not, the user is told of") {
  OpenOptions options;
  SUBCASE("virtual time") { options.emulator.emplace().paced = false; }
  SUBCASE("real time") { options.emulator.emplace().paced = true; }
  std::atomic<bool> fails = false;
  auto inner = open_transport("emulated", options);
  Knob knob = Knob::open(std::make_unique<Failing>(std::move(inner), fails));
  fails = true;
  CHECK(contains(message_of<Disconnected>([&] { knob.sleep(60.0); }), "carrier pigeon"));
  fails = false;
}
