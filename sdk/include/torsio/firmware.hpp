/// @file
/// New firmware for a knob: look into a file, put it on the knob, and see that it runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "torsio/export.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// A file with firmware that is whole, and what it says of itself.
struct FirmwareFile {
  std::filesystem::path path{};   ///< where it is
  std::string chip{};             ///< "rp2040" or "rp2350"
  std::string board{};            ///< "pico2", ...
  std::string version{};          ///< "major.minor.patch"
  std::uint32_t fingerprint = 0;  ///< of the report layouts, as in DeviceInfo
  std::size_t size = 0;           ///< in flash, in bytes

  friend bool operator==(const FirmwareFile&, const FirmwareFile&) = default;
};

/// Looks into a file.
/// @throws InvalidArgument that says in a sentence why no knob could run it; Error if it cannot be
///         read
[[nodiscard]] TORSIO_EXPORT FirmwareFile read_firmware(const std::filesystem::path& path);

/// A knob's answers before and after an update.
struct ExaminedKnob {
  DeviceInfo info{};            ///< who it is
  Owner owner = Owner::none;    ///< who has the actuator
  std::string configuration{};  ///< as dump_config() gives it
};

/// Where an update finds knobs and drives. Empty members mean the computer's own. Others are for
/// tests, and for knobs behind your own transport.
struct FirmwareHost {
  std::function<std::vector<ListedDevice>()> list_devices{};        ///< as list_devices()
  std::function<ExaminedKnob(const std::string& path)> examine{};   ///< throws as Knob::open()
  std::function<void(const std::string& path)> start_bootloader{};  ///< as start_bootloader()
  std::filesystem::path root = "/";                                 ///< of the system's files
};

/// How an update is done.
struct UpdateOptions {
  /// Folder in which the boot loader's drive will be, where it cannot be found: anywhere but on
  /// Linux. Empty: it is looked for.
  std::filesystem::path drive{};
  double timeout_s = 60.0;  ///< longest wait for the drive, and again for the knob
  std::function<void(std::string_view)> say{};  ///< is told each step, in words
  std::function<bool()> interrupted{};          ///< as in OpenOptions
  FirmwareHost host{};                          ///< where knobs and drives are
};

/// Plan of an update: made by prepare_update(), done by carry_out().
struct FirmwarePlan {
  FirmwareFile file{};                   ///< what will be copied
  std::optional<ListedDevice> device{};  ///< none: a board that waits in its boot loader already
  /// None if it cannot be asked: it is of another release, or waits already.
  std::optional<DeviceInfo> before{};
  std::string configuration{};  ///< the knob's own, as dump_config() gives it; may be empty
  UpdateOptions options{};      ///< as they were given

  /// The knob is of another release, whose configuration the new firmware cannot read.
  [[nodiscard]] bool loses_configuration() const { return device && !before; }
  /// The plan in a sentence, to ask for consent.
  [[nodiscard]] TORSIO_EXPORT std::string text() const;
};

/// Result of an update.
struct FirmwareUpdate {
  FirmwareFile file{};                 ///< what was copied
  std::optional<DeviceInfo> before{};  ///< none if it could not be asked
  DeviceInfo after{};                  ///< what runs now
  /// Whether the knob has the configuration that it had before. Unsaved values are lost. None if
  /// the knob could not be asked.
  std::optional<bool> kept{};
  std::string configuration{};  ///< before the update, for load_config(); may be empty
};

/// Looks whether a file is for a knob, and what an update would do. Changes nothing.
/// @param selector path or serial number; empty for the only knob, or for a board that waits in its
///                 boot loader, as after plugging in with its button held
/// @throws InvalidArgument  the file is not whole, not firmware, or for another board; or its
///                          release cannot talk to this library
/// @throws DeviceBusy       another program or a game has the knob
/// @throws DeviceNotFound, PermissionDenied, Disconnected, Interrupted, Error
[[nodiscard]] TORSIO_EXPORT FirmwarePlan prepare_update(const std::filesystem::path& path,
                                                        std::string_view selector = {},
                                                        const UpdateOptions& options = {});

/// Does it: disarms, starts the boot loader, waits for its drive, copies, waits for the knob, and
/// looks what runs. The saved configuration stays, unless the plan says that it is lost.
/// @throws Timeout          drive or knob did not come; says what to do
/// @throws Error            copying failed, or other firmware runs now
/// @throws InvalidArgument, Refused, DeviceBusy, Disconnected, Interrupted
TORSIO_EXPORT FirmwareUpdate carry_out(const FirmwarePlan& plan);

/// Puts new firmware on a knob, without asking: both in one.
TORSIO_EXPORT FirmwareUpdate update_firmware(const std::filesystem::path& path,
                                             std::string_view selector = {},
                                             const UpdateOptions& options = {});

}  // namespace torsio
