// The USB driver on a fake stack: what it refuses, and what becomes of a report without room. HID
// 1.11, section 7, says what each request is. The other tests here use the real stack.
#include <doctest/doctest.h>
// Types of the stack.
#include <tusb.h>
// Behind tusb.h.
#include <device/usbd_pvt.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace bench {

using Bytes = std::vector<std::uint8_t>;

/// The driver's calls to the stack, and the answers.
struct Stack {
  bool ready = true;
  bool event_waits = false;
  bool accepts = true;
  std::set<std::uint8_t> busy;
  std::vector<std::pair<std::uint8_t, Bytes>> started;  // transfers, by endpoint
  std::vector<Bytes> control;                           // data stages
  int statuses = 0;
  std::uint8_t* control_buffer = nullptr;
};
Stack stack;

void lock(bool) {}
bool event_ready() { return stack.event_waits; }
bool is_ready() { return stack.ready; }
bool is_busy(std::uint8_t, std::uint8_t endpoint) { return stack.busy.contains(endpoint); }
bool transfer(std::uint8_t, std::uint8_t endpoint, std::uint8_t* bytes, std::uint16_t size) {
  if (!stack.accepts) return false;
  stack.started.emplace_back(endpoint, Bytes(bytes, bytes + size));
  stack.busy.insert(endpoint);
  return true;
}
bool open_pair(std::uint8_t, const std::uint8_t*, std::uint8_t, std::uint8_t, std::uint8_t* out,
               std::uint8_t* in) {
  *out = 0x01;
  *in = 0x81;
  return true;
}
bool control_data(std::uint8_t, const tusb_control_request_t*, void* bytes, std::uint16_t size) {
  stack.control_buffer = static_cast<std::uint8_t*>(bytes);
  stack.control.emplace_back(stack.control_buffer, stack.control_buffer + size);
  return true;
}
bool control_status(std::uint8_t, const tusb_control_request_t*) {
  ++stack.statuses;
  return true;
}

}  // namespace bench

#define usb usb_on_the_bench
#define usbd_app_driver_get_cb torsio_driver_on_the_bench
#define usbd_int_set bench::lock
#define tud_task_event_ready bench::event_ready
#define tud_ready bench::is_ready
#define usbd_edpt_busy bench::is_busy
#define usbd_edpt_xfer bench::transfer
#define usbd_open_edpt_pair bench::open_pair
#define tud_control_xfer bench::control_data
#define tud_control_status bench::control_status
#include "usb/hid_driver.cpp"

namespace {

using bench::Bytes;
using bench::stack;

struct Function : torsio::device::HidFunction {
  std::size_t get_feature(std::uint8_t id, std::span<std::uint8_t> report) override {
    ++asked;
    report[0] = id;
    return 5;
  }
  std::size_t get_input(std::uint8_t id, std::span<std::uint8_t> report) override {
    ++asked;
    report[0] = id;
    report[1] = report[2] = 0xEE;
    return 3;
  }
  void input_over(bool taken) override { overs.push_back(taken); }
  bool set_feature(std::span<const std::uint8_t> report) override {
    features.emplace_back(report.begin(), report.end());
    return true;
  }
  bool receive(std::span<const std::uint8_t> report) override {
    if (has_room) outputs.emplace_back(report.begin(), report.end());
    return has_room;
  }
  std::size_t next_input(std::span<std::uint8_t> report) override {
    report[0] = ++inputs;
    return 3;
  }

  bool has_room = true;
  std::vector<bool> overs;
  int asked = 0;
  std::uint8_t inputs = 0;
  std::vector<Bytes> features;
  std::vector<Bytes> outputs;
};

/// Interface 0 of the device, open.
struct Bench {
  Bench() {
    stack = {};
    std::uint8_t count = 0;
    driver = torsio_driver_on_the_bench(&count);
    REQUIRE(count == 1);
    torsio::usb_on_the_bench::set_hid_function(0, function);
    reopen();
  }
  ~Bench() { driver->reset(0); }

  static const tusb_desc_interface_t* descriptor() {
    const std::span<const std::uint8_t> all = torsio::device::configuration_descriptor();
    for (std::size_t at = 0; at < all.size(); at += all[at]) {
      if (all[at + 1] == TUSB_DESC_INTERFACE && all[at + 2] == 0) {
        return reinterpret_cast<const tusb_desc_interface_t*>(&all[at]);
      }
    }
    return nullptr;
  }
  void reopen() const {
    driver->reset(0);
    stack.busy.clear();
    REQUIRE(driver->open(0, descriptor(), 200) == kSize);
  }
  static void poll() { torsio::usb_on_the_bench::poll_hid(); }
  /// The host has taken, or brought, a report.
  void over(std::uint8_t endpoint, std::uint32_t size,
            xfer_result_t result = XFER_RESULT_SUCCESS) const {
    stack.busy.erase(endpoint);
    REQUIRE(driver->xfer_cb(0, endpoint, result, size));
  }
  bool request(std::uint8_t stage, std::uint8_t kind, std::uint8_t number, std::uint16_t value,
               std::uint16_t index, std::uint16_t length) const {
    tusb_control_request_t request{};
    request.bmRequestType = kind;
    request.bRequest = number;
    request.wValue = value;
    request.wIndex = index;
    request.wLength = length;
    return driver->control_xfer_cb(0, stage, &request);
  }
  bool setup(std::uint8_t kind, std::uint8_t number, std::uint16_t value, std::uint16_t index,
             std::uint16_t length) const {
    return request(CONTROL_STAGE_SETUP, kind, number, value, index, length);
  }

  static constexpr std::uint16_t kSize = 9 + 9 + 7 + 7;  // interface, HID, two endpoints
  Function function;
  const usbd_class_driver_t* driver = nullptr;
};

Bytes ids_to_host() {
  Bytes ids;
  for (const auto& [endpoint, bytes] : stack.started) {
    if (endpoint == 0x81) ids.push_back(bytes.at(0));
  }
  return ids;
}

}  // namespace

TEST_CASE("driver begins no transfer before the stack has looked at what happened on the bus") {
  Bench bench;
  stack.event_waits = true;
  Bench::poll();
  CHECK(stack.started.empty());
  stack.event_waits = false;
  Bench::poll();
  CHECK(stack.started.size() == 2);
}

TEST_CASE("driver takes no report for a host that sleeps") {
  Bench bench;
  stack.ready = false;
  Bench::poll();
  CHECK(bench.function.inputs == 0);
  CHECK(ids_to_host().empty());
  stack.ready = true;
  Bench::poll();
  CHECK(ids_to_host() == Bytes{1});
}

TEST_CASE("driver keeps a report whose transfer does not start, and sends it first") {
  Bench bench;
  stack.accepts = false;
  for (int i = 0; i < 3; ++i) Bench::poll();
  stack.accepts = true;
  Bench::poll();
  bench.over(0x81, 3);
  Bench::poll();
  CHECK(ids_to_host() == Bytes{1, 2});
}

TEST_CASE("driver sends no report of before a reset to the host behind it") {
  Bench bench;
  stack.accepts = false;
  Bench::poll();
  stack.accepts = true;
  bench.reopen();
  Bench::poll();
  CHECK(ids_to_host() == Bytes{2});
}

TEST_CASE("driver holds an output report until there is room, and drops it at a reset") {
  Bench bench;
  Bench::poll();
  bench.function.has_room = false;
  bench.over(0x01, 40);
  for (int i = 0; i < 3; ++i) Bench::poll();
  CHECK(stack.started.size() == 2);  // the host waits
  bench.function.has_room = true;
  Bench::poll();
  REQUIRE(bench.function.outputs.size() == 1);
  CHECK(bench.function.outputs[0].size() == 40);
  CHECK(stack.started.size() == 3);

  bench.function.has_room = false;
  bench.over(0x01, 40);
  Bench::poll();
  bench.reopen();
  bench.function.has_room = true;
  Bench::poll();
  CHECK(bench.function.outputs.size() == 1);
}

TEST_CASE("driver takes no report from a transfer that has failed") {
  Bench bench;
  Bench::poll();
  bench.over(0x01, 64, XFER_RESULT_FAILED);
  Bench::poll();
  CHECK(bench.function.outputs.empty());
  CHECK(stack.busy.contains(0x01));  // and listens again
}

TEST_CASE("driver opens no interface whose descriptor is cut off, and none that is not HID") {
  Bench bench;
  CHECK(bench.driver->open(0, Bench::descriptor(), Bench::kSize) == Bench::kSize);
  CHECK(bench.driver->open(0, Bench::descriptor(), Bench::kSize - 1) == 0);
  tusb_desc_interface_t other = *Bench::descriptor();
  other.bInterfaceClass = TUSB_CLASS_CDC;
  CHECK(bench.driver->open(0, &other, 200) == 0);
}

TEST_CASE("driver gives input and feature reports, takes output and feature reports") {
  Bench bench;
  for (const int kind : {0, 2, 4}) {
    CHECK_FALSE(bench.setup(0xA1, 0x01, static_cast<std::uint16_t>(kind << 8 | 5), 0, 64));
  }
  for (const int kind : {0, 1, 4}) {
    CHECK_FALSE(bench.setup(0x21, 0x09, static_cast<std::uint16_t>(kind << 8 | 5), 0, 64));
  }
  CHECK_FALSE(bench.setup(0x81, 0x06, 0x2201, 0, 64));  // there is one of each
  CHECK_FALSE(bench.setup(0x21, 0x01, 0x0305, 0, 64));  // GET_REPORT with data to the device
  CHECK_FALSE(bench.setup(0xA1, 0x09, 0x0305, 0, 64));  // SET_REPORT with data to the host
  CHECK_FALSE(bench.setup(0x21, 0x02, 0, 0, 1));        // GET_IDLE
  CHECK_FALSE(bench.setup(0xA1, 0x0A, 0, 0, 0));        // SET_IDLE
  CHECK_FALSE(bench.setup(0x01, 0x06, 0x2200, 0, 64));  // GET_DESCRIPTOR
  CHECK_FALSE(bench.setup(0x21, 0x09, 0x0305, 0, 0));
  CHECK_FALSE(bench.setup(0x21, 0x09, 0x0305, 0, 65));
  CHECK(bench.function.asked == 0);
  CHECK(stack.control.empty());
  CHECK(stack.statuses == 0);
  CHECK(bench.setup(0xA1, 0x01, 0x0305, 0, 64));
  CHECK(bench.setup(0x81, 0x06, 0x2200, 0, 64));
  CHECK(stack.control.size() == 2);
  CHECK(bench.setup(0xA1, 0x01, 0x0141, 0, 64));
  CHECK(stack.control.back() == Bytes{0x41, 0xEE, 0xEE});
  CHECK(bench.function.inputs == 0);
}

TEST_CASE("driver takes an output report as it was announced, if it has room and its turn") {
  Bench bench;
  const auto say = [&](std::uint16_t value) {
    REQUIRE(bench.setup(0x21, 0x09, value, 0, 4));
    stack.control_buffer[0] = 0x15;
    return bench.request(CONTROL_STAGE_DATA, 0x21, 0x09, value, 0, 4);
  };
  CHECK(say(0x0215));
  CHECK_FALSE(say(0x0216));
  REQUIRE(bench.function.outputs.size() == 1);
  CHECK(bench.function.outputs[0] == Bytes{0x15, 0xFF, 0xFF, 0xFF});
  CHECK(bench.function.features.empty());
  bench.function.has_room = false;
  CHECK_FALSE(say(0x0215));
  Bench::poll();
  bench.over(0x01, 40);
  Bench::poll();  // one waits
  bench.function.has_room = true;
  CHECK_FALSE(say(0x0215));
  Bench::poll();
  CHECK(say(0x0215));
  CHECK(bench.function.outputs.size() == 3);
}

TEST_CASE("driver says what became of an input report") {
  Bench bench;
  Bench::poll();
  CHECK(bench.function.overs.empty());
  bench.over(0x81, 3);
  CHECK(bench.function.overs == std::vector{true});
  Bench::poll();
  bench.reopen();
  CHECK(bench.function.overs == std::vector{true, false});
}

TEST_CASE("driver answers a request once, and with nothing of what was asked before") {
  Bench bench;
  for (const auto& [kind, number, length] :
       {std::tuple{0x81, 0x00, 2}, std::tuple{0xA1, 0x02, 1}}) {  // GET_STATUS, GET_IDLE
    CAPTURE(number);
    REQUIRE(bench.setup(0xA1, 0x01, 0x0305, 0, 64));
    stack.control_buffer[0] = stack.control_buffer[1] = 0xEE;
    CHECK(bench.setup(static_cast<std::uint8_t>(kind), static_cast<std::uint8_t>(number), 0, 0, 2));
    CHECK(stack.control.back() == Bytes(static_cast<std::size_t>(length), 0));
  }
  REQUIRE(bench.setup(0x81, 0x06, 0x2200, 0, 64));
  const std::size_t answers = stack.control.size();
  CHECK(bench.request(CONTROL_STAGE_DATA, 0x81, 0x06, 0x2200, 0, 64));
  CHECK(bench.request(CONTROL_STAGE_ACK, 0x81, 0x06, 0x2200, 0, 64));
  CHECK(stack.control.size() == answers);
}

TEST_CASE("driver answers for its interfaces only") {
  Bench bench;
  for (const int recipient : {0, 2, 3}) {  // device, endpoint, other
    CHECK_FALSE(bench.setup(static_cast<std::uint8_t>(0xA0 | recipient), 0x02, 0, 0, 1));
    CHECK_FALSE(bench.setup(static_cast<std::uint8_t>(0xA0 | recipient), 0x01, 0x0305, 0, 64));
  }
  for (const std::uint16_t interface : std::initializer_list<std::uint16_t>{2, 3, 9, 255}) {
    CHECK_FALSE(bench.setup(0xA1, 0x02, 0, interface, 1));
    CHECK_FALSE(bench.setup(0x21, 0x0A, 0, interface, 0));
  }
  CHECK_FALSE(bench.setup(0xC1, 0x01, 0x0305, 0, 64));  // a request of a vendor
  CHECK(bench.function.asked == 0);
  CHECK(stack.control.empty());
  CHECK(bench.setup(0xA1, 0x02, 0, 0, 1));
}

TEST_CASE("driver reads a feature report as long as it was announced, if it is the one announced") {
  Bench bench;
  REQUIRE(bench.setup(0x21, 0x09, 0x0305, 0, 7));
  // A host sends nothing where nothing may be.
  CHECK(stack.control.back() == Bytes(7, 0xFF));
  stack.control_buffer[0] = 0x06;
  CHECK_FALSE(bench.request(CONTROL_STAGE_DATA, 0x21, 0x09, 0x0305, 0, 7));
  CHECK(bench.function.features.empty());
  stack.control_buffer[0] = 0x05;
  CHECK(bench.request(CONTROL_STAGE_DATA, 0x21, 0x09, 0x0305, 0, 7));
  REQUIRE(bench.function.features.size() == 1);
  CHECK(bench.function.features[0].size() == 7);
}
