/// @file
/// Exceptions of the library. Every message says what was wrong and what to do about it.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "torsio/export.hpp"

namespace torsio {

struct TelemetrySample;

/// Base of everything that the library throws on purpose.
class TORSIO_EXPORT Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;

  /// Samples of a Knob::record() that ended early. None if something else has thrown this.
  [[nodiscard]] const std::shared_ptr<const std::vector<TelemetrySample>>& samples()
      const noexcept {
    return samples_;
  }
  /// For the library, which knows what it had.
  void keep_samples(std::shared_ptr<const std::vector<TelemetrySample>> samples) noexcept {
    samples_ = std::move(samples);
  }

 private:
  std::shared_ptr<const std::vector<TelemetrySample>> samples_;
};

/// A value that the device would refuse. Nothing was sent; what plays goes on.
class TORSIO_EXPORT InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// There is no such device, or no device, or more than one to choose from.
class TORSIO_EXPORT DeviceNotFound : public Error {
 public:
  using Error::Error;
};

/// The device is there, but this user may not open it.
class TORSIO_EXPORT PermissionDenied : public Error {
 public:
  using Error::Error;
};

/// Somebody, maybe this very program, has opened the device already.
class TORSIO_EXPORT DeviceBusy : public Error {
 public:
  using Error::Error;
};

/// Firmware and library were built from different report layouts.
class TORSIO_EXPORT ProtocolMismatch : public Error {
 public:
  using Error::Error;
};

/// The device said no. The old scene goes on.
class TORSIO_EXPORT Refused : public Error {
 public:
  /// For the library; the arguments are what the members below give.
  Refused(const std::string& message, std::string status, std::string report, std::string field,
          std::string reason = {})
      : Error(message),
        status_(std::move(status)),
        report_(std::move(report)),
        field_(std::move(field)),
        reason_(std::move(reason)) {}

  /// Why, in one word of docs/reference/protocol.md: "not_armed", "out_of_range", ...
  [[nodiscard]] const std::string& status() const noexcept { return status_; }
  /// Name of the refused report: "wall", "command", ...
  [[nodiscard]] const std::string& report() const noexcept { return report_; }
  /// Name of the offending field; empty if no field in particular.
  [[nodiscard]] const std::string& field() const noexcept { return field_; }
  /// If the device had to be armed and is not any more, why: the name of a DisarmReason,
  /// "watchdog", "fault", ...; else empty.
  [[nodiscard]] const std::string& reason() const noexcept { return reason_; }

 private:
  std::string status_;
  std::string report_;
  std::string field_;
  std::string reason_;
};

/// The torque went off during a Knob::record() that was to keep it on. Recording and device go on.
class TORSIO_EXPORT Disarmed : public Error {
 public:
  /// For the library.
  Disarmed(const std::string& message, std::string reason)
      : Error(message), reason_(std::move(reason)) {}

  /// Name of the DisarmReason: "watchdog", "fault", ...
  [[nodiscard]] const std::string& reason() const noexcept { return reason_; }

 private:
  std::string reason_;
};

/// The device did not answer in time.
class TORSIO_EXPORT Timeout : public Error {
 public:
  using Error::Error;
};

/// The device was unplugged or lost its power. Open it again once it is back.
class TORSIO_EXPORT Disconnected : public Error {
 public:
  using Error::Error;
};

/// The knob was closed, or moved from.
class TORSIO_EXPORT Closed : public Error {
 public:
  using Error::Error;
};

/// `OpenOptions::interrupted` said so.
class TORSIO_EXPORT Interrupted : public Error {
 public:
  using Error::Error;
};

}  // namespace torsio
