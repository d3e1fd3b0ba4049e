#include "own_transport.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "bytes.hpp"
#include "interpreter.hpp"
#include "torsio/error.hpp"

namespace py = pybind11;

namespace torsio::bindings {
namespace {

thread_local const Passing* in_transport = nullptr;

struct InTransport {
  explicit InTransport(const Passing& passing) { in_transport = &passing; }
  InTransport(const InTransport&) = delete;
  InTransport& operator=(const InTransport&) = delete;
  ~InTransport() { in_transport = before; }
  // A transport may use a knob whose transport is its own too.
  const Passing* before = in_transport;
};

/// @throws Interrupted if asking for the text is interrupted
std::string text_of(Passing& passing, const py::error_already_set& error) {
  try {
    return py::bytes(py::str(error.value()).attr("encode")("utf-8", "backslashreplace"));
  } catch (py::error_already_set& second) {
    if (second.matches(PyExc_Exception)) return "it does not say what";
    passing.keep(second);
    throw Interrupted("the transport was interrupted");
  }
}

/// @throws Disconnected if the call raises it, Interrupted if that is no Exception, else Error with
///         what it raises
template <class Call>
auto ask(Passing& passing, Call&& call) {
  const Locked locked;
  const InTransport inside(passing);
  try {
    return call();
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_Exception)) {
      passing.keep(error);
      throw Interrupted("the transport was interrupted");
    }
    const std::string text = text_of(passing, error);
    if (error.matches(py::module_::import("torsio.errors").attr("Disconnected"))) {
      throw Disconnected(text);
    }
    throw Error(py::type::of(error.value()).attr("__name__").cast<std::string>() + ": " + text);
  } catch (const py::cast_error&) {
    throw Error("a transport must give bytes, None, or True or False");
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
  OwnTransport(py::object own, std::shared_ptr<Passing> passing)
      : own_(std::move(own)), passing_(std::move(passing)) {
    time_is_virtual_ = own_.attr("time_is_virtual").cast<bool>();
  }
  OwnTransport(const OwnTransport&) = delete;
  OwnTransport& operator=(const OwnTransport&) = delete;
  ~OwnTransport() override {
    if (!closed_) close();  // a knob that could not be opened
    const Locked locked;
    own_ = py::object();
    passing_.reset();
  }

  void close() noexcept override {
    closed_ = true;
    const Locked locked;
    const InTransport inside(*passing_);
    // An interrupt may have ended it at its first line.
    for (int attempts_left = kAttempts; attempts_left > 0; --attempts_left) {
      try {
        own_.attr("close")();
        return;
      } catch (py::error_already_set& error) {
        if (error.matches(PyExc_Exception)) {
          error.discard_as_unraisable("torsio.Transport.close");
          return;
        }
        passing_->keep(error);
      }
    }
  }

  bool write(const ReportBytes& report) override {
    return ask(*passing_, [&] { return own_.attr("write")(to_bytes(report)).cast<bool>(); });
  }

  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    return ask(*passing_, [&] {
      const double timeout_s = std::chrono::duration<double>(timeout).count();
      return take(own_.attr("read")(timeout_s), report);
    });
  }

  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    return ask(*passing_, [&] { return take(own_.attr("get_feature")(id), report); });
  }

  bool set_feature(const ReportBytes& report) override {
    return ask(*passing_, [&] { return own_.attr("set_feature")(to_bytes(report)).cast<bool>(); });
  }

  bool time_is_virtual() const override { return time_is_virtual_; }

  std::int64_t now_ns() const override {
    if (!time_is_virtual_) return Transport::now_ns();
    return ask(*passing_, [&] { return own_.attr("now_ns")().cast<std::int64_t>(); });
  }

  void advance_to(std::int64_t time_ns) override {
    ask(*passing_, [&] {
      own_.attr("advance_to")(time_ns);
      return true;
    });
  }

 private:
  py::object own_;
  std::shared_ptr<Passing> passing_;
  bool time_is_virtual_ = false;
  bool closed_ = false;
};

}  // namespace

void Passing::pass_on() {
  if (const auto error = std::exchange(error_, std::nullopt)) throw *error;
}

bool Passing::is_in_transport() const { return in_transport == this; }

std::unique_ptr<Transport> transport_from_python(py::object transport,
                                                 std::shared_ptr<Passing> passing) {
  return std::make_unique<OwnTransport>(std::move(transport), std::move(passing));
}

}  // namespace torsio::bindings
