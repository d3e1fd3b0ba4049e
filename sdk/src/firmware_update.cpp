#include "firmware_update.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "file_sync.hpp"
#include "protocol/registry.hpp"
#include "torsio/config_file.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

namespace fs = std::filesystem;
using RealClock = std::chrono::steady_clock;

constexpr auto kLookEvery = std::chrono::milliseconds(200);
constexpr auto kAskEvery = std::chrono::milliseconds(20);
constexpr std::size_t kChunkBytes = 65536;
constexpr const char* kInfo = "INFO_UF2.TXT";

/// The drive that a board shows while it waits for firmware.
struct Drive {
  fs::path folder;
  std::string board_id;
};

/// What the boot loader calls itself in its file.
std::string board_id_of(std::string_view chip) { return chip == "rp2040" ? "RPI-RP2" : "RP2350"; }

/// The drive that is mounted in a folder, if it is a boot loader's.
std::optional<Drive> drive_in(const fs::path& folder) {
  std::ifstream file(folder / kInfo);
  constexpr std::string_view key = "Board-ID:";
  for (std::string line; std::getline(file, line);) {
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

std::vector<Drive> find_drives(const fs::path& root) {
  std::ifstream mounts(root / "proc/mounts");
  std::vector<Drive> found;
  for (std::string line; std::getline(mounts, line);) {
    const std::size_t first = line.find(' ');
    if (first == std::string::npos || !line.starts_with("/dev/")) continue;
    const std::string folder =
        unescaped(std::string_view(line).substr(first + 1, line.find(' ', first + 1) - first - 1));
    const auto drive = drive_in(root / fs::path(folder).relative_path());
    if (drive && (drive->board_id == "RPI-RP2" || drive->board_id == "RP2350")) {
      found.push_back(*drive);
    }
  }
  return found;
}

/// One update, from a file that was read to the knob that runs it.
class FirmwareUpdater {
 public:
  FirmwareUpdater(const fs::path& path, const UpdateOptions& options, const FirmwareHost& host)
      : path_(path), options_(options), host_(host) {}

  FirmwareUpdate run(std::string_view selector) {
    prepare(selector);
    std::vector<std::string> old;
    for (const ListedDevice& device : real_devices()) old.push_back(device.serial);
    if (device_) {
      say("disarming, and starting the boot loader");
      host_.start_bootloader(device_->path);
    }
    say("waiting for the boot loader's drive");
    const Drive drive = wait_for_drive();
    say("copying " + std::to_string(done_.file.size / 1024) + " KiB to " + drive.folder.string());
    copy_to(drive);
    say("waiting for the knob");
    look_at(wait_for_knob(old));
    return std::move(done_);
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

  RealClock::time_point deadline() const {
    return RealClock::now() + std::chrono::duration_cast<RealClock::duration>(
                                  std::chrono::duration<double>(options_.timeout_s));
  }

  std::string seconds() const {
    std::string text = std::to_string(options_.timeout_s);
    return text.substr(0, text.find('.') + 2) + " s";
  }

  std::vector<ListedDevice> real_devices() const {
    std::vector<ListedDevice> devices = host_.list();
    std::erase_if(devices, [](const ListedDevice& one) { return one.transport == "emulated"; });
    return devices;
  }

  /// Looks at file and knob. Changes nothing.
  void prepare(std::string_view selector) {
    if (selector.substr(0, selector.find(':')) == "emulated") {
      throw InvalidArgument("an emulated knob has no firmware of its own: it is the library's");
    }
    if (!(options_.timeout_s > 0.0 && options_.timeout_s <= 86400.0)) {
      throw InvalidArgument("timeout_s is above 0 and at most 86400");
    }
    done_.file = read_firmware(path_);
    if (done_.file.fingerprint != protocol::fingerprint()) {
      throw InvalidArgument(path_.string() + ": firmware " + done_.file.version +
                            " is of another release than this library, which could not talk to "
                            "the knob; take firmware and library of the same release");
    }
    if (options_.drive.empty() && !fs::exists(host_.root / "proc/mounts")) {
      throw InvalidArgument("this system does not tell where drives are: give `drive`");
    }
    const std::vector<Drive> waiting = find_drives(host_.root);
    device_ = meant(selector);
    if (!device_) {
      if (waiting.empty() && (options_.drive.empty() || !drive_in(options_.drive))) {
        throw DeviceNotFound(
            "no knob is plugged in, and no board waits in its boot loader; hold the board's "
            "BOOTSEL button while you plug it in");
      }
      return;
    }
    if (!waiting.empty() && options_.drive.empty()) {
      throw Error("another board waits in its boot loader already, at " +
                  waiting.front().folder.string() +
                  ": unplug it, or name the drive of the one that is meant");
    }
    std::string board = device_->board;
    try {
      Knob knob = host_.open(device_->path);
      if (knob.health().owner == Owner::game) {
        throw DeviceBusy("a game has the knob: end it first; nothing was changed");
      }
      done_.before = knob.info();
      done_.configuration = dump_config(knob);
      board = done_.before->board;
    } catch (const ProtocolMismatch&) {
      // Of another release: it cannot be asked, and its configuration will be lost.
    }
    if (board == "emulated") {
      throw InvalidArgument("a virtual knob has no firmware of its own: it is the library's");
    }
    if (!board.empty() && board != done_.file.board) {
      throw InvalidArgument(path_.string() + " is firmware for board " + done_.file.board +
                            ", and the knob is a " + board + ": take torsio-" + board + ".uf2");
    }
  }

  std::optional<ListedDevice> meant(std::string_view selector) const {
    std::vector<ListedDevice> devices = real_devices();
    std::erase_if(devices, [&](const ListedDevice& one) {
      return !selector.empty() && selector != one.path && selector != one.serial;
    });
    if (devices.size() > 1) {
      throw DeviceNotFound("more than one knob is meant; name one by its path or serial number");
    }
    if (devices.empty() && !selector.empty()) {
      throw DeviceNotFound("there is no knob with path or serial number '" + std::string(selector) +
                           "'");
    }
    return devices.empty() ? std::nullopt : std::optional(devices.front());
  }

  Drive wait_for_drive() const {
    const std::string wanted = board_id_of(done_.file.chip);
    const auto end = deadline();
    for (;; pause()) {
      std::vector<Drive> drives;
      if (options_.drive.empty()) {
        drives = find_drives(host_.root);
      } else if (auto drive = drive_in(options_.drive)) {
        if (drive->board_id != wanted) {
          throw InvalidArgument(drive->folder.string() + " is the drive of an " + drive->board_id +
                                ", and " + path_.string() + " is for an " + wanted +
                                ": nothing was copied");
        }
        drives.push_back(*drive);
      }
      std::erase_if(drives, [&](const Drive& one) { return one.board_id != wanted; });
      if (drives.size() > 1) {
        throw Error(
            "more than one board waits in its boot loader; name the drive that is meant, "
            "nothing was copied");
      }
      if (!drives.empty()) return drives.front();
      if (RealClock::now() > end) throw Timeout(no_drive(wanted));
    }
  }

  std::string no_drive(const std::string& board_id) const {
    const std::string node = "/dev/disk/by-label/" + board_id;
    if (options_.drive.empty() && fs::exists(host_.root / fs::path(node).relative_path())) {
      return "the boot loader's drive " + node + " is there but not mounted; mount it with " +
             "`udisksctl mount -b " + node + "`, or `sudo mount -o umask=0 " + node + " /mnt`";
    }
    return (options_.drive.empty() ? "a drive " + board_id : options_.drive.string()) + " with " +
           kInfo + " did not appear within " + seconds() +
           "; the board waits for firmware: copy the file onto its drive, or unplug it and plug it "
           "in again, which leaves the old one";
  }

  /// To where it runs as soon as it is whole.
  void copy_to(const Drive& drive) const {
    std::ifstream from(path_, std::ios::binary);
    const std::string content{std::istreambuf_iterator<char>(from),
                              std::istreambuf_iterator<char>()};
    const fs::path target = drive.folder / "torsio.uf2";
    std::ofstream to(target, std::ios::binary | std::ios::trunc);
    std::size_t written = 0;
    while (to && written < content.size()) {
      const std::size_t size = std::min(kChunkBytes, content.size() - written);
      to.write(content.data() + written, static_cast<std::streamsize>(size));
      to.flush();
      if (to) written += size;
    }
    // The board starts anew at the last block, and takes its drive away.
    if (written < content.size()) {
      throw Error("copying to " + drive.folder.string() + " failed; the board still waits: copy " +
                  path_.string() + " there by hand, or try again");
    }
    to.close();
    sync_file(target);
  }

  ListedDevice wait_for_knob(const std::vector<std::string>& old) const {
    std::string problem = "it has not come back";
    const auto end = deadline();
    for (;; pause()) {
      for (const ListedDevice& device : real_devices()) {
        const bool is_it = device_ ? device.serial == device_->serial
                                   : std::ranges::find(old, device.serial) == old.end();
        if (is_it && device.problem.empty()) return device;
        if (is_it) problem = device.problem;
      }
      if (RealClock::now() > end) break;
    }
    throw Timeout("the firmware was copied, but no knob runs it after " + seconds() + ": " +
                  problem +
                  "; plug it in again, or load the firmware once more with the board's "
                  "BOOTSEL button held");
  }

  /// At what runs now.
  void look_at(const ListedDevice& device) {
    Knob knob = host_.open(device.path);
    done_.after = knob.info();
    const FirmwareFile& file = done_.file;
    if (done_.after.board != file.board || done_.after.firmware_version != file.version ||
        done_.after.fingerprint != file.fingerprint) {
      throw Error("the knob runs firmware " + done_.after.firmware_version + " of board " +
                  done_.after.board + ", not " + file.version + " of board " + file.board +
                  ": it was not taken; try again");
    }
    if (done_.before) done_.kept = dump_config(knob) == done_.configuration;
  }

  const fs::path& path_;
  const UpdateOptions& options_;
  const FirmwareHost& host_;
  std::optional<ListedDevice> device_;
  FirmwareUpdate done_;
};

}  // namespace

FirmwareUpdate update_firmware(const fs::path& path, std::string_view selector,
                               const UpdateOptions& options, const FirmwareHost& host) {
  return FirmwareUpdater(path, options, host).run(selector);
}

FirmwareUpdate update_firmware(const fs::path& path, std::string_view selector,
                               const UpdateOptions& options) {
  const OpenOptions open{.interrupted = options.interrupted};
  const FirmwareHost host{
      .list = list_devices,
      .open = [&](const std::string& device) { return Knob::open(device, open); },
      .start_bootloader = [&](const std::string& device) { start_bootloader(device, open); }};
  return update_firmware(path, selector, options, host);
}

}  // namespace torsio
