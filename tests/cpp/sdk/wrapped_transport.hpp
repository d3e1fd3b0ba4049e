/// @file Another transport, with code between it and the library.
#pragma once

#include <doctest/doctest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>

#include "protocol/codec.hpp"
#include "torsio/knob.hpp"
#include "torsio/transport.hpp"

namespace torsio::test {

/// Passes everything on.
class WrappedTransport : public Transport {
 public:
  explicit WrappedTransport(std::unique_ptr<Transport> inner) : inner_(std::move(inner)) {}

  void close() noexcept override { inner_->close(); }
  bool write(const ReportBytes& report) override { return inner_->write(report); }
  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    return inner_->read(report, timeout);
  }
  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    return inner_->get_feature(id, report);
  }
  bool set_feature(const ReportBytes& report) override { return inner_->set_feature(report); }
  [[nodiscard]] bool time_is_virtual() const override { return inner_->time_is_virtual(); }
  [[nodiscard]] std::int64_t now_ns() const override { return inner_->now_ns(); }
  void advance_to(std::int64_t time_ns) override { inner_->advance_to(time_ns); }

 private:
  std::unique_ptr<Transport> inner_;
};

/// Changes one kind of the reports that the device is asked for.
template <class Report, class Change>
class ChangedAnswer final : public WrappedTransport {
 public:
  ChangedAnswer(std::unique_ptr<Transport> inner, Change change)
      : WrappedTransport(std::move(inner)), change_(std::move(change)) {}

  bool get_feature(std::uint8_t id, ReportBytes& bytes) override {
    if (!WrappedTransport::get_feature(id, bytes)) return false;
    if (id != protocol::Layout<Report>::id) return true;
    Report report;
    REQUIRE(protocol::decode(bytes, report).ok());
    change_(report);
    bytes = protocol::encode(report);
    return true;
  }

 private:
  Change change_;
};

/// An emulated device with one changed answer.
template <class Report, class Change>
std::unique_ptr<Transport> emulated_with(Change change) {
  return std::make_unique<ChangedAnswer<Report, Change>>(open_transport("emulated"),
                                                         std::move(change));
}

}  // namespace torsio::test
