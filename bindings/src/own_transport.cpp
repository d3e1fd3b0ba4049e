#include "own_transport.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "bytes.hpp"
#include "interpreter.hpp"
#include "torsio/error.hpp"

namespace py = pybind11;

namespace torsio::bindings {
namespace {

/// @throws Disconnected if the call raises it, else Error with what it raises
template <class Call>
auto ask(Call&& call) {
  const Locked locked;
  try {
    return call();
  } catch (py::error_already_set& error) {
    const std::string text = py::str(error.value()).cast<std::string>();
    if (error.matches(py::module_::import("torsio.errors").attr("Disconnected"))) {
      throw Disconnected(text);
    }
    throw Error(py::type::of(error.value()).attr("__name__").cast<std::string>() + ": " + text);
  } catch (const py::cast_error&) {
    throw Error("a transport gave what is neither bytes nor a truth");
  }
}

bool take(const py::object& given, ReportBytes& report) {
  if (given.is_none()) return false;
  const auto bytes = given.cast<std::string_view>();
  if (bytes.size() != report.size()) {
    throw Error("a transport gave a report of " + std::to_string(bytes.size()) +
                " bytes; every report has 64");
  }
  std::ranges::copy(bytes, report.begin());
  return true;
}

/// The SDK calls from threads that do not hold the interpreter's lock.
class OwnTransport final : public Transport {
 public:
  explicit OwnTransport(py::object own) : own_(std::move(own)) {
    time_is_virtual_ = own_.attr("time_is_virtual").cast<bool>();
  }
  OwnTransport(const OwnTransport&) = delete;
  OwnTransport& operator=(const OwnTransport&) = delete;
  ~OwnTransport() override {
    const Locked locked;
    own_ = py::object();
  }

  void close() noexcept override {
    const Locked locked;
    try {
      own_.attr("close")();
    } catch (py::error_already_set& error) {
      error.discard_as_unraisable("torsio.Transport.close");
    }
  }

  bool write(const ReportBytes& report) override {
    return ask([&] { return own_.attr("write")(to_bytes(report)).cast<bool>(); });
  }

  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    return ask([&] {
      const double timeout_s = std::chrono::duration<double>(timeout).count();
      return take(own_.attr("read")(timeout_s), report);
    });
  }

  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    return ask([&] { return take(own_.attr("get_feature")(id), report); });
  }

  bool set_feature(const ReportBytes& report) override {
    return ask([&] { return own_.attr("set_feature")(to_bytes(report)).cast<bool>(); });
  }

  bool time_is_virtual() const override { return time_is_virtual_; }

  std::int64_t now_ns() const override {
    if (!time_is_virtual_) return Transport::now_ns();
    return ask([&] { return own_.attr("now_ns")().cast<std::int64_t>(); });
  }

  void advance_to(std::int64_t time_ns) override {
    ask([&] {
      own_.attr("advance_to")(time_ns);
      return true;
    });
  }

 private:
  py::object own_;
  bool time_is_virtual_ = false;
};

}  // namespace

std::unique_ptr<Transport> transport_from_python(py::object transport) {
  return std::make_unique<OwnTransport>(std::move(transport));
}

}  // namespace torsio::bindings
