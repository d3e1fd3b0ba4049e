// The way of new firmware onto a knob: a board that waits for some is a drive, and what is copied
// there runs.
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "conversion/field_check.hpp"
#include "emulated.hpp"
#include "file_sync.hpp"
#include "firmware_file.hpp"
#include "path_text.hpp"
#include "protocol/registry.hpp"
#include "protocol_names.hpp"
#include "torsio/config_file.hpp"
#include "torsio/error.hpp"
#include "torsio/firmware.hpp"
#include "torsio/knob.hpp"

namespace torsio {
namespace {

namespace fs = std::filesystem;
using RealClock = std::chrono::steady_clock;

constexpr auto kLookEvery = std::chrono::milliseconds(200);
constexpr auto kAskEvery = std::chrono::milliseconds(20);
// Desktops mount a drive by themselves within a second or two.
constexpr double kPatienceS = 4.0;
constexpr double kLongestTimeoutS = 86400.0;
constexpr std::size_t kChunkBytes = 65536;
constexpr const char* kInfo = "INFO_UF2.TXT";
constexpr std::streamsize kMostInfoBytes = 4096;

/// The drive that a board shows while it waits for firmware.
struct Drive {
  fs::path folder;
  std::string board_id;
};

/// The boot loader's name in its file.
std::string board_id_of(std::string_view chip) { return chip == "rp2040" ? "RPI-RP2" : "RP2350"; }

/// The drive that is mounted in a folder, if it is a boot loader's.
std::optional<Drive> drive_in(const fs::path& folder) {
  std::error_code unknown;
  // Any drive may have a file of this name, also a pipe that nobody writes or one without an end.
  if (!fs::is_regular_file(folder / kInfo, unknown)) return std::nullopt;
  std::string text(kMostInfoBytes, '\0');
  std::ifstream(folder / kInfo).read(text.data(), kMostInfoBytes);
  std::istringstream lines(text);
  constexpr std::string_view key = "Board-ID:";
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t begin = line.find_first_not_of(" \t", key.size());
    if (begin == std::string::npos) continue;
    const std::size_t end = line.find_first_of(" \t\r", begin);
    return Drive{folder, line.substr(begin, end == std::string::npos ? end : end - begin)};
  }
  return std::nullopt;
}

/// A blank in a name of /proc/mounts stands there as \040.
std::string unescaped(std::string_view text) {
  const auto is_octal = [](char letter) { return letter >= '0' && letter <= '7'; };
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 3 < text.size() && is_octal(text[i + 1]) && is_octal(text[i + 2]) &&
        is_octal(text[i + 3])) {
      result += static_cast<char>((text[i + 1] - '0') * 64 + (text[i + 2] - '0') * 8 +
                                  (text[i + 3] - '0'));
      i += 3;
    } else {
      result += text[i];
    }
  }
  return result;
}

/// "a, b".
template <class Items, class Text>
std::string listed(const Items& items, Text&& text) {
  std::string list;
  for (const auto& item : items) list += (list.empty() ? "" : ", ") + text(item);
  return list;
}

/// The computer's functions for an update; its own where the caller gave none.
class Host {
 public:
  explicit Host(const UpdateOptions& options)
      : host_(options.host), open_{.interrupted = options.interrupted} {}

  /// None of them emulated.
  [[nodiscard]] std::vector<ListedDevice> devices() const {
    std::vector<ListedDevice> devices = host_.list_devices ? host_.list_devices() : list_devices();
    std::erase_if(devices, [](const ListedDevice& one) { return one.transport == kEmulated; });
    return devices;
  }

  [[nodiscard]] ExaminedKnob examine(const std::string& path) const {
    if (host_.examine) return host_.examine(path);
    Knob knob = Knob::open(path, open_);
    return {knob.info(), knob.health().owner, dump_config(knob)};
  }

  void start_bootloader(const std::string& path) const {
    if (host_.start_bootloader) return host_.start_bootloader(path);
    torsio::start_bootloader(path, open_);
  }

  /// A file of the system's, by its usual name.
  [[nodiscard]] fs::path file(const fs::path& name) const {
    return host_.root / name.relative_path();
  }

 private:
  const FirmwareHost& host_;
  OpenOptions open_;
};

std::vector<Drive> find_drives(const Host& host) {
  std::ifstream mounts(host.file("/proc/mounts"));
  std::vector<Drive> found;
  for (std::string line; std::getline(mounts, line);) {
    const std::size_t first = line.find(' ');
    if (first == std::string::npos || !line.starts_with("/dev/")) continue;
    const std::string folder =
        unescaped(std::string_view(line).substr(first + 1, line.find(' ', first + 1) - first - 1));
    const auto drive = drive_in(host.file(folder));
    if (drive && (drive->board_id == "RPI-RP2" || drive->board_id == "RP2350")) {
      found.push_back(*drive);
    }
  }
  return found;
}

std::optional<ListedDevice> meant_device(std::string_view selector, const Host& host) {
  std::vector<ListedDevice> devices = host.devices();
  std::erase_if(devices, [&](const ListedDevice& one) {
    return !selector.empty() && selector != one.path && selector != one.serial;
  });
  if (devices.size() > 1) {
    throw DeviceNotFound("more than one knob is meant; name one: " +
                         listed(devices, [](const ListedDevice& one) { return one.path; }));
  }
  if (devices.empty() && !selector.empty()) {
    throw DeviceNotFound("there is no knob with path or serial number '" + std::string(selector) +
                         "'");
  }
  return devices.empty() ? std::nullopt : std::optional(devices.front());
}

void check_fingerprint(const FirmwareFile& file) {
  if (protocol::drives(file.fingerprint)) return;
  throw InvalidArgument(path_text(file.path) + ": firmware " + file.version +
                        " has the protocol fingerprint " + hex32(file.fingerprint) +
                        ", this library " + hex32(protocol::fingerprint()) +
                        ": it could not talk to the knob; take firmware and library of the same "
                        "release");
}

void check_board(const FirmwareFile& file, const std::string& board) {
  if (board == kEmulated) {
    throw InvalidArgument("a virtual knob has no firmware of its own: it is the library's");
  }
  if (!board.empty() && board != file.board) {
    throw InvalidArgument(path_text(file.path) + " is firmware for board " + file.board +
                          ", and the knob is a " + board + ": take torsio-" + board + ".uf2");
  }
}

/// A plan that is being carried out.
class FirmwareUpdater {
 public:
  explicit FirmwareUpdater(const FirmwarePlan& plan)
      : plan_(plan), options_(plan.options), host_(plan.options) {}

  FirmwareUpdate run() const {
    if (!(options_.timeout_s > 0.0 && options_.timeout_s <= kLongestTimeoutS)) {
      throw InvalidArgument("timeout_s is " + number_text(options_.timeout_s) +
                            ", allowed are above 0 to " + number_text(kLongestTimeoutS) + " s");
    }
    const std::string content = file_content(plan_.file.path);
    if (firmware_in(plan_.file.path, content) != plan_.file) {
      throw InvalidArgument(path_text(plan_.file.path) +
                            " has changed since it was examined: nothing was done");
    }
    std::vector<std::string> old;
    for (const ListedDevice& device : host_.devices()) old.push_back(device.serial);
    if (plan_.device) {
      say("disarming, and starting the boot loader");
      host_.start_bootloader(plan_.device->path);
    }
    say("waiting for the boot loader's drive");
    const Drive drive = wait_for_drive();
    say("copying " + std::to_string(plan_.file.size / 1024) + " KiB to " + path_text(drive.folder));
    copy_to(drive, content);
    say("waiting for the knob");
    return look_at(wait_for_knob(old));
  }

 private:
  void say(const std::string& step) const {
    if (options_.say) options_.say(step);
  }

  /// Lets real time pass until the next look.
  void pause() const {
    const auto end = RealClock::now() + kLookEvery;
    while (RealClock::now() < end) {
      if (options_.interrupted && options_.interrupted()) {
        throw Interrupted(
            "the update was interrupted; a board that waits for firmware leaves its "
            "boot loader when it is unplugged");
      }
      std::this_thread::sleep_for(kAskEvery);
    }
  }

  static double since_s(RealClock::time_point begin) {
    return std::chrono::duration<double>(RealClock::now() - begin).count();
  }

  Drive wait_for_drive() const {
    const std::string wanted = board_id_of(plan_.file.chip);
    const auto begin = RealClock::now();
    for (bool hinted = false;; pause()) {
      std::vector<Drive> drives;
      if (options_.drive.empty()) {
        drives = find_drives(host_);
      } else if (auto drive = drive_in(options_.drive)) {
        if (drive->board_id != wanted) {
          throw InvalidArgument(path_text(drive->folder) + " is the drive of an " +
                                drive->board_id + ", and " + path_text(plan_.file.path) +
                                " is for an " + wanted + ": nothing was copied");
        }
        drives.push_back(*drive);
      }
      std::erase_if(drives, [&](const Drive& one) { return one.board_id != wanted; });
      if (drives.size() > 1) {
        throw Error("more than one board waits in its boot loader: " +
                    listed(drives, [](const Drive& one) { return path_text(one.folder); }) +
                    "; name the drive that is meant, nothing was copied");
      }
      if (!drives.empty()) return drives.front();
      const std::string hint = mount_hint(wanted);
      if (!hinted && !hint.empty() &&
          since_s(begin) > std::min(kPatienceS, options_.timeout_s / 2.0)) {
        hinted = true;
        say(hint);
      }
      if (since_s(begin) > options_.timeout_s) {
        throw Timeout(hint.empty() ? no_drive(wanted) : hint);
      }
    }
  }

  /// How a drive that is there but not mounted is mounted; empty if there is none.
  std::string mount_hint(const std::string& board_id) const {
    const std::string node = "/dev/disk/by-label/" + board_id;
    std::error_code ignored;
    // The link need not lead anywhere below another root.
    if (!options_.drive.empty() || !fs::exists(fs::symlink_status(host_.file(node), ignored))) {
      return {};
    }
    return "the boot loader's drive " + node + " is there but not mounted; mount it with " +
           "`udisksctl mount -b " + node + "`, or `sudo mount -o umask=0 " + node + " /mnt`";
  }

  std::string timeout_text() const { return number_text(options_.timeout_s) + " s"; }

  std::string no_drive(const std::string& board_id) const {
    return (options_.drive.empty() ? "a drive " + board_id : path_text(options_.drive)) + " with " +
           kInfo + " did not appear within " + timeout_text() +
           "; the board waits for firmware: copy the file onto its drive, or plug the board in "
           "again to keep the old firmware";
  }

  /// To where it runs as soon as it is whole.
  void copy_to(const Drive& drive, std::string_view content) const {
    const fs::path target = drive.folder / "torsio.uf2";
    errno = 0;
    std::ofstream to(target, std::ios::binary | std::ios::trunc);
    std::size_t written = 0;
    while (to && written < content.size()) {
      const std::string_view part = content.substr(written, kChunkBytes);
      to.write(part.data(), static_cast<std::streamsize>(part.size()));
      to.flush();
      if (to) written += part.size();
    }
    // The board starts anew at the last block, and takes its drive away.
    if (written < content.size()) {
      throw Error("copying to " + path_text(drive.folder) + " failed" + system_reason() +
                  "; the board still waits: copy " + path_text(plan_.file.path) +
                  " there by hand, or try again");
    }
    to.close();
    sync_file(target);
  }

  ListedDevice wait_for_knob(const std::vector<std::string>& old) const {
    std::string problem = "it has not come back";
    for (const auto begin = RealClock::now();; pause()) {
      for (const ListedDevice& device : host_.devices()) {
        const bool is_it = plan_.device ? device.serial == plan_.device->serial
                                        : std::ranges::find(old, device.serial) == old.end();
        if (is_it && device.problem.empty()) return device;
        if (is_it) problem = device.problem;
      }
      if (since_s(begin) > options_.timeout_s) break;
    }
    throw Timeout("the firmware was copied, but no knob runs it after " + timeout_text() + ": " +
                  problem +
                  "; plug it in again, or load the firmware once more with the board's "
                  "BOOTSEL button held");
  }

  /// At what runs now.
  FirmwareUpdate look_at(const ListedDevice& device) const {
    const auto [after, owner, configuration] = host_.examine(device.path);
    const FirmwareFile& file = plan_.file;
    if (after.board != file.board || after.firmware_version != file.version ||
        after.fingerprint != file.fingerprint) {
      throw Error("the knob runs firmware " + after.firmware_version + " of board " + after.board +
                  ", not " + file.version + " of board " + file.board +
                  ": it was not taken; try again");
    }
    FirmwareUpdate done{file, plan_.before, after, {}, plan_.configuration};
    if (done.before) done.kept = configuration == done.configuration;
    return done;
  }

  const FirmwarePlan& plan_;
  const UpdateOptions& options_;
  Host host_;
};

void note_before(FirmwarePlan& plan, const Host& host) {
  try {
    ExaminedKnob knob = host.examine(plan.device->path);
    if (knob.owner == Owner::game) {
      throw DeviceBusy("a game has the knob: end it first; nothing was changed");
    }
    plan.before = std::move(knob.info);
    plan.configuration = std::move(knob.configuration);
  } catch (const ProtocolMismatch&) {
    // Firmware of another release: nobody can ask it, and its configuration will be lost.
  }
}

}  // namespace

std::string FirmwarePlan::text() const {
  std::string who = "the board that waits in its boot loader";
  if (device) {
    who = "the knob " + (device->serial.empty() ? device->path : device->serial) + " (" +
          (before ? "board " + before->board + ", firmware " + before->firmware_version
                  : "whose firmware is of another release") +
          ")";
  }
  return who + " gets firmware " + file.version + " for board " + file.board;
}

FirmwarePlan prepare_update(const fs::path& path, std::string_view selector,
                            const UpdateOptions& options) {
  if (selects_emulated(selector)) {
    throw InvalidArgument("an emulated knob has no firmware of its own: it is the library's");
  }
  FirmwarePlan plan{.file = read_firmware(path), .options = options};
  check_fingerprint(plan.file);
  const Host host(options);
  if (options.drive.empty() && !fs::exists(host.file("/proc/mounts"))) {
    throw InvalidArgument("this system does not tell where drives are: give `drive`");
  }
  const std::vector<Drive> waiting = find_drives(host);
  plan.device = meant_device(selector, host);
  if (!plan.device) {
    if (waiting.empty() && (options.drive.empty() || !drive_in(options.drive))) {
      throw DeviceNotFound(
          "no knob is plugged in, and no board waits in its boot loader; hold the board's "
          "BOOTSEL button while you plug it in");
    }
    return plan;
  }
  if (!waiting.empty() && options.drive.empty()) {
    throw Error("another board waits in its boot loader already, at " +
                path_text(waiting.front().folder) +
                ": unplug it, or name the drive of the one that is meant");
  }
  note_before(plan, host);
  check_board(plan.file, plan.before ? plan.before->board : plan.device->board);
  return plan;
}

FirmwareUpdate carry_out(const FirmwarePlan& plan) { return FirmwareUpdater(plan).run(); }

FirmwareUpdate update_firmware(const fs::path& path, std::string_view selector,
                               const UpdateOptions& options) {
  return carry_out(prepare_update(path, selector, options));
}

}  // namespace torsio
