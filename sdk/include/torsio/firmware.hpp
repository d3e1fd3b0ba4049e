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

#include "torsio/export.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// A file with firmware that is whole, and what it says of itself.
struct FirmwareFile {
  std::string chip{};             ///< "rp2040" or "rp2350"
  std::string board{};            ///< "pico2", ...
  std::string version{};          ///< "major.minor.patch"
  std::uint32_t fingerprint = 0;  ///< of the report layouts, as in DeviceInfo
  std::size_t size = 0;           ///< in flash, in bytes
};

/// Looks into a file.
/// @throws InvalidArgument that says in a sentence why no knob could run it; Error if it cannot be
///         read
[[nodiscard]] TORSIO_EXPORT FirmwareFile read_firmware(const std::filesystem::path& path);

/// How an update is done.
struct UpdateOptions {
  /// Folder in which the boot loader's drive will be, where it cannot be found: anywhere but on
  /// Linux. Empty: it is looked for.
  std::filesystem::path drive{};
  double timeout_s = 60.0;  ///< longest wait for the drive, and again for the knob
  std::function<void(std::string_view)> say{};  ///< is told each step, in words
  std::function<bool()> interrupted{};          ///< as in OpenOptions
};

/// What an update has done.
struct FirmwareUpdate {
  FirmwareFile file{};                 ///< what was copied
  std::optional<DeviceInfo> before{};  ///< none if it could not be asked
  DeviceInfo after{};                  ///< what runs now
  /// The configuration is the one of before, which what was not saved does not outlive; none if
  /// that could not be asked.
  std::optional<bool> kept{};
  std::string configuration{};  ///< the one of before, for load_config(); empty likewise
};

/// Puts new firmware on a knob, without asking: looks whether the file is for it, disarms, starts
/// the boot loader, waits for its drive, copies, waits for the knob, and looks what runs. While
/// another program or a game has the knob nothing happens. The saved configuration stays, unless
/// the firmware before was of another release with other reports.
/// @param selector path or serial number; empty for the only knob, or for a board that waits in its
///                 boot loader already, as one does that was plugged in with its button held
/// @throws InvalidArgument  the file is not whole, not firmware, for another board, or of another
///                          release than this library, which could not talk to the knob any more
/// @throws DeviceBusy       another program or a game has the knob
/// @throws Timeout          drive or knob did not come; says what to do
/// @throws Error            copying failed, or what runs now is not what was copied
/// @throws DeviceNotFound, PermissionDenied, Refused, Disconnected, Interrupted
TORSIO_EXPORT FirmwareUpdate update_firmware(const std::filesystem::path& path,
                                             std::string_view selector = {},
                                             const UpdateOptions& options = {});

}  // namespace torsio
