// Files with firmware, made here block by block, and their way onto a stand-in for a board: a drive
// is a folder, and what is copied to it becomes the knob's.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "firmware_update.hpp"
#include "protocol/codec.hpp"
#include "protocol/registry.hpp"
#include "protocol/reports.hpp"
#include "temporary_directory.hpp"
#include "torsio/config_file.hpp"
#include "torsio/error.hpp"

using namespace torsio;
namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kRp2040Family = 0xE48BFF56;
constexpr std::uint32_t kRp2350Family = 0xE48BFF59;

std::string u32(std::uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

void set_u32(std::string& bytes, std::size_t block, std::size_t at, std::uint32_t value) {
  bytes.replace(512 * block + at, 4, u32(value));
}

std::string one_block(std::uint32_t address, std::uint32_t number, std::uint32_t count,
                      std::uint32_t family, const std::string& payload) {
  std::string bytes = u32(0x0A324655) + u32(0x9E5D5157) + u32(0x2000) + u32(address) + u32(256) +
                      u32(number) + u32(count) + u32(family) + payload;
  bytes.resize(508, '\0');
  return bytes + u32(0x0AB16F30);
}

struct Maker {
  std::uint32_t family = kRp2350Family;
  std::string board = "pico2";
  std::uint32_t fingerprint = protocol::fingerprint();
  int marks = 1;

  std::string make() const {
    std::string label("torsio firmware\0", 16);
    label += u32(fingerprint) + std::string("\x00\x09\x07\x00", 4) + board;
    label.resize(40, '\0');
    std::string program = "odd";
    for (int n = 0; n < marks; ++n) program += label;
    program.insert(0, 300, '\xEE');
    program.resize(1024, '\xEE');
    std::string file;
    if (family == kRp2350Family) {
      file = one_block(0x10FFFF00, 0, 2, 0xE48BFF57, std::string(256, '\xEF'));
    }
    for (std::uint32_t n = 0; n < 4; ++n) {
      file += one_block(0x10000000 + 256 * n, n, 4, family, program.substr(256 * n, 256));
    }
    return file;
  }
};

void write(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// An emulated device that says that it is a real board with a firmware of its own.
class StandInTransport final : public Transport {
 public:
  StandInTransport(std::uint8_t board, std::uint8_t minor) : board_(board), minor_(minor) {}
  void close() noexcept override { inner_->close(); }
  bool write(const ReportBytes& report) override { return inner_->write(report); }
  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    return inner_->read(report, timeout);
  }
  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    if (!inner_->get_feature(id, report)) return false;
    if (id != protocol::Layout<protocol::Identity>::id) return true;
    protocol::Identity identity;
    REQUIRE(protocol::decode(report, identity).ok());
    identity.board = board_;
    identity.firmware_version = {0, minor_, 7};
    report = protocol::encode(identity);
    return true;
  }
  bool set_feature(const ReportBytes& report) override { return inner_->set_feature(report); }
  bool time_is_virtual() const override { return inner_->time_is_virtual(); }
  std::int64_t now_ns() const override { return inner_->now_ns(); }
  void advance_to(std::int64_t time_ns) override { inner_->advance_to(time_ns); }

 private:
  std::uint8_t board_;
  std::uint8_t minor_;
  std::unique_ptr<Transport> inner_ = open_transport("emulated:stand-in");
};

/// A knob that becomes a drive and a knob again.
struct StandIn {
  test::TemporaryDirectory directory;
  fs::path root = fs::path(directory.path()) / "system";
  fs::path mount = root / "media/me/my knob";
  fs::path file = fs::path(directory.path()) / "torsio-pico2.uf2";
  std::uint8_t board = 2;
  std::uint8_t minor = 1;
  std::string board_id = "RP2350";
  bool plugged = true, mounts = true, takes = true, returns = true;
  bool other_release = false, loses_configuration = false;
  std::vector<std::string> started, said;
  UpdateOptions options{.timeout_s = 5.0,
                        .say = [this](std::string_view step) { said.emplace_back(step); }};

  StandIn() {
    write(file, Maker{}.make());
    write(root / "proc/mounts", "proc /proc proc rw 0 0\n");
    Knob knob = open();
    knob.load_defaults();
    knob.update([](ControlConfig& control) { control.beta = 0.25; });
    knob.save();
  }

  Knob open() const {
    if (other_release) throw ProtocolMismatch("of another release");
    return Knob::open(std::make_unique<StandInTransport>(board, minor));
  }

  void appear() {
    if (!mounts) return write(root / "dev/disk/by-label" / board_id, "");
    write(mount / "INFO_UF2.TXT",
          "UF2 Bootloader v1.0\r\nModel: Raspberry Pi\r\nBoard-ID: " + board_id + "\r\n");
    write(root / "proc/mounts", "/dev/sda1 /media/me/my\\040knob vfat rw 0 0\n");
  }

  /// A boot loader starts what it has got once all of it has come.
  void take() {
    if (!fs::exists(mount / "torsio.uf2") || read(mount / "torsio.uf2") != read(file)) return;
    fs::remove_all(mount);
    write(root / "proc/mounts", "");
    if (takes) minor = 9;
    other_release = false;
    if (loses_configuration) {
      Knob knob = open();
      knob.load_defaults();
      knob.save();
    }
    plugged = returns;
  }

  FirmwareUpdate update(std::string_view selector = {}) {
    const FirmwareHost host{
        .list =
            [this] {
              take();
              std::vector<ListedDevice> found;
              if (plugged) {
                found.push_back({.path = "/dev/hidraw7", .serial = "E661", .transport = "hid"});
              }
              found.push_back({.path = "emulated", .transport = "emulated"});
              return found;
            },
        .open =
            [this](const std::string& path) {
              CHECK(path == "/dev/hidraw7");
              return open();
            },
        .start_bootloader =
            [this](const std::string& path) {
              started.push_back(path);
              plugged = false;
              appear();
            },
        .root = root};
    return update_firmware(file, selector, options, host);
  }
};

}  // namespace

TEST_CASE("a file says for which board it is") {
  test::TemporaryDirectory directory;
  const fs::path path = fs::path(directory.path()) / "torsio.uf2";
  for (const auto& [family, chip, board] : {std::tuple{kRp2350Family, "rp2350", "pico2"},
                                            std::tuple{kRp2040Family, "rp2040", "pico"}}) {
    write(path, Maker{.family = family, .board = board}.make());
    const FirmwareFile found = read_firmware(path);
    CHECK(found.chip == chip);
    CHECK(found.board == board);
    CHECK(found.version == "0.9.7");
    CHECK(found.fingerprint == protocol::fingerprint());
    CHECK(found.size == 1024);
  }
  CHECK_THROWS_AS((void)read_firmware(path / "none"), Error);
}

TEST_CASE("a file that no knob could run is told in a sentence") {
  test::TemporaryDirectory directory;
  const fs::path path = fs::path(directory.path()) / "bad.uf2";
  const std::string good = Maker{.family = kRp2040Family, .board = "pico"}.make();
  const std::string with_leading = Maker{}.make();
  const auto told = [&](const std::string& bytes, const char* words) {
    write(path, bytes);
    CHECK_THROWS_WITH_AS((void)read_firmware(path), doctest::Contains(words), InvalidArgument);
    CHECK_THROWS_WITH_AS((void)read_firmware(path), doctest::Contains("bad.uf2: "),
                         InvalidArgument);
  };
  const auto patched = [&](std::size_t block, std::size_t at, std::uint32_t value) {
    std::string bytes = good;
    set_u32(bytes, block, at, value);
    return bytes;
  };
  told("", "has 0 bytes");
  told(good.substr(0, good.size() - 1), "cut off");
  told(std::string(1024, 'x'), "no UF2 file");
  told(patched(2, 0, 0), "block 2 is damaged");
  told(patched(2, 4, 0), "block 2 is damaged");
  told(patched(3, 508, 0), "block 3 is damaged");
  told(patched(1, 16, 128), "block 1 is not one page");
  told(patched(1, 12, 0x10000180), "block 1 is not one page");
  told(patched(0, 8, 0), "does not say for which chip");
  told(patched(0, 28, 0xADA52840), "family 0xada52840");
  told(good.substr(0, 512) + with_leading.substr(1024), "mixes");
  told(good.substr(0, good.size() - 512), "out of order");
  told(good.substr(512), "out of order");
  told(good.substr(0, 512) + good, "doubled");
  told(patched(3, 12, 0x10000400), "block 3 goes to address 0x10000400");
  told(patched(0, 12, 0x10000100), "0x10000000 comes next");
  told(patched(1, 8, 0x2001), "goes to address");
  told(with_leading.substr(0, 512), "not for an RP2040");
  told(Maker{.marks = 0}.make(), "not Torsio's firmware");
  told(Maker{.marks = 2}.make(), "more than once");
  told(Maker{.board = "\xFF\xFE"}.make(), "damaged");
}

TEST_CASE("an update disarms, copies, and sees the new version run with the old configuration") {
  StandIn knob;
  const FirmwareUpdate done = knob.update("E661");
  REQUIRE(done.before.has_value());
  CHECK(done.before->firmware_version == "0.1.7");
  CHECK(done.after.firmware_version == "0.9.7");
  CHECK(done.after.board == "pico2");
  CHECK(done.kept == true);
  CHECK(knob.started == std::vector<std::string>{"/dev/hidraw7"});
  CHECK(knob.said.size() == 4);
  CHECK_FALSE(fs::exists(knob.mount));
}

TEST_CASE("a configuration that is not kept is handed back") {
  StandIn knob;
  knob.loses_configuration = true;
  const FirmwareUpdate done = knob.update();
  CHECK(done.kept == false);
  Knob again = knob.open();
  CHECK(again.control_config().beta == 0.5);
  load_config(again, done.configuration);
  CHECK(again.control_config().beta == 0.25);
}

TEST_CASE("a knob of another release, and a board that waits already, get their firmware too") {
  StandIn knob;
  knob.other_release = true;
  FirmwareUpdate done = knob.update();
  CHECK_FALSE(done.before.has_value());
  CHECK_FALSE(done.kept.has_value());
  CHECK(done.after.firmware_version == "0.9.7");

  StandIn fresh;
  fresh.plugged = false;
  CHECK_THROWS_WITH_AS(fresh.update(), doctest::Contains("BOOTSEL"), DeviceNotFound);
  fresh.appear();
  CHECK(fresh.update().after.firmware_version == "0.9.7");
  CHECK(fresh.started.empty());

  StandIn named;
  named.options.drive = named.mount;
  fs::remove(named.root / "proc/mounts");
  CHECK(named.update().kept == true);
}

TEST_CASE("what is not for this knob never starts its boot loader") {
  const auto refused = [](auto&& change, const char* words) {
    StandIn knob;
    std::string selector;
    change(knob, selector);
    CAPTURE(words);
    CHECK_THROWS_WITH(knob.update(selector), doctest::Contains(words));
    CHECK(knob.started.empty());
  };
  refused(
      [](StandIn& knob, std::string&) {
        write(knob.file, Maker{.family = kRp2040Family, .board = "pico"}.make());
      },
      "the knob is a pico2: take torsio-pico2.uf2");
  refused([](StandIn& knob, std::string&) { write(knob.file, Maker{.fingerprint = 1}.make()); },
          "of the same release");
  refused([](StandIn& knob, std::string&) { knob.board = 0; }, "virtual knob");
  refused([](StandIn&, std::string& selector) { selector = "emulated:2"; }, "emulated knob");
  refused([](StandIn&, std::string& selector) { selector = "other"; }, "there is no knob");
  refused([](StandIn& knob, std::string&) { knob.appear(); }, "another board waits");
  refused([](StandIn& knob, std::string&) { fs::remove(knob.root / "proc/mounts"); }, "`drive`");
}

TEST_CASE("what goes wrong on the way is told, with what to do") {
  const auto fails = [](auto&& change, const char* words) {
    StandIn knob;
    knob.options.timeout_s = 0.3;
    change(knob);
    CAPTURE(words);
    CHECK_THROWS_WITH(knob.update(), doctest::Contains(words));
    CHECK(knob.started.size() == 1);
  };
  fails([](StandIn& knob) { knob.mounts = false; }, "udisksctl mount -b /dev/disk/by-label/RP2350");
  fails([](StandIn& knob) { knob.board_id = "RPI-RP2"; }, "a drive RP2350 with INFO_UF2.TXT did");
  fails(
      [](StandIn& knob) {
        knob.board_id = "RPI-RP2";
        knob.options.drive = knob.mount;
      },
      "nothing was copied");
  fails([](StandIn& knob) { knob.returns = false; }, "no knob runs it after 0.3 s");
  fails([](StandIn& knob) { knob.takes = false; }, "runs firmware 0.1.7 of board pico2, not 0.9.7");
  fails(
      [](StandIn& knob) {
        knob.mounts = false;
        knob.options.interrupted = [] { return true; };
      },
      "interrupted");
}
