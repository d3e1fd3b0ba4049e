// Firmware's way onto a stand-in for a board: a drive is a folder, and what is copied to it becomes
// the knob's. Python's tests of the same, tests/python/test_firmware.py, know all that may be
// wrong.
#include <doctest/doctest.h>

#ifndef _WIN32
#include <sys/resource.h>
#endif

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "device/config_store.hpp"
#include "protocol/registry.hpp"
#include "temporary_directory.hpp"
#include "torsio/config_file.hpp"
#include "torsio/error.hpp"
#include "torsio/firmware.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
namespace fs = std::filesystem;

namespace {

std::string u32(std::uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

/// Firmware 0.9.7 for a board "pico" with an RP2040.
std::string firmware_bytes(std::uint32_t blocks = 4) {
  std::string label("torsio firmware\0", 16);
  label += u32(protocol::fingerprint()) + std::string("\x00\x09\x07\x00", 4) + "pico";
  label.resize(44, '\0');
  std::string program(300, '\xEE');
  program += label;
  program.resize(std::size_t{256} * blocks, '\xEE');
  std::vector<std::uint8_t> image(program.begin(), program.end());
  program.replace(340, 4, u32(device::crc32(image)));
  std::string file;
  for (std::uint32_t n = 0; n < blocks; ++n) {
    file += u32(0x0A324655) + u32(0x9E5D5157) + u32(0x2000) + u32(0x10000000 + 256 * n) + u32(256) +
            u32(n) + u32(blocks) + u32(0xE48BFF56) + program.substr(256 * n, 256);
    file.resize(512 * n + 508, '\0');
    file += u32(0x0AB16F30);
  }
  return file;
}

void write(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// A knob that becomes a drive and a knob again.
struct StandIn {
  test::TemporaryDirectory directory;
  fs::path root = fs::path(directory.path()) / "system";
  fs::path mount = root / "media/me/my knob";
  fs::path file = fs::path(directory.path()) / "torsio-pico.uf2";
  std::string version = "0.1.7";
  bool plugged = true, other_release = false, loses_configuration = false;
  std::vector<std::string> started, said;
  Knob knob = Knob::open("emulated");
  UpdateOptions options{
      .timeout_s = 5.0,
      .say = [this](std::string_view step) { said.emplace_back(step); },
      .host = {.list_devices =
                   [this] {
                     take();
                     std::vector<ListedDevice> found;
                     if (plugged) {
                       found.push_back(
                           {.path = "/dev/hidraw7", .serial = "E661", .transport = "hid"});
                     }
                     found.push_back({.path = "emulated", .transport = "emulated"});
                     return found;
                   },
               .examine =
                   [this](const std::string& path) {
                     CHECK(path == "/dev/hidraw7");
                     if (other_release) throw ProtocolMismatch("of another release");
                     ExaminedKnob answer{knob.info(), Owner::none, dump_config(knob)};
                     answer.info.board = "pico";
                     answer.info.firmware_version = version;
                     return answer;
                   },
               .start_bootloader =
                   [this](const std::string& path) {
                     started.push_back(path);
                     plugged = false;
                     appear();
                   },
               .root = root}};

  StandIn() {
    write(file, firmware_bytes());
    write(root / "proc/mounts", "proc /proc proc rw 0 0\n");
    knob.update([](ControlConfig& control) { control.beta = 0.25; });
  }

  void appear() const {
    write(mount / "INFO_UF2.TXT", "UF2 Bootloader v1.0\r\nBoard-ID: RPI-RP2\r\n");
    write(root / "proc/mounts", "/dev/sda1 /media/me/my\\040knob vfat rw 0 0\n");
  }

  /// A boot loader starts what it has got once all of it has come.
  void take() {
    if (!fs::exists(mount / "torsio.uf2") || read(mount / "torsio.uf2") != read(file)) return;
    fs::remove_all(mount);
    write(root / "proc/mounts", "");
    version = "0.9.7";
    other_release = false;
    if (loses_configuration) knob.load_defaults();
    plugged = true;
  }

  FirmwareUpdate update() { return update_firmware(file, {}, options); }
};

}  // namespace

TEST_CASE("a file that is cut off or damaged anywhere is read as what it is, or told") {
  test::TemporaryDirectory directory;
  const fs::path path = fs::path(directory.path()) / "torsio-pico.uf2";
  const std::string good = firmware_bytes();
  int told = 0;
  const auto look = [&](const std::string& bytes) {
    write(path, bytes);
    std::string chip = "rp2040";
    try {
      chip = read_firmware(path).chip;
    } catch (const InvalidArgument&) {
      ++told;
    }
    CHECK(chip == "rp2040");
  };
  for (std::size_t size = 0; size < good.size(); size += 31) look(good.substr(0, size));
  CHECK(told == 67);
  told = 0;
  for (std::size_t at = 0; at < good.size(); at += 3) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(~bytes[at]);
    look(bytes);
  }
  // All of the pages, and what says where they go; not what nobody reads.
  CHECK(told >= 342 + 4 * 8);
  look(good);
  CHECK(read_firmware(path).size == 1024);
}

TEST_CASE("an update disarms, copies, and sees the new version run with the old configuration") {
  StandIn board;
  const FirmwareUpdate done = board.update();
  REQUIRE(done.before.has_value());
  CHECK(done.before->firmware_version == "0.1.7");
  CHECK(done.after.firmware_version == "0.9.7");
  CHECK(done.kept == true);
  CHECK(board.started == std::vector<std::string>{"/dev/hidraw7"});
  CHECK(board.said.size() == 4);
  CHECK_FALSE(fs::exists(board.mount));
}

TEST_CASE("a configuration that is not kept is handed back, and one that will be lost is told") {
  StandIn board;
  board.loses_configuration = true;
  const FirmwareUpdate done = board.update();
  CHECK(done.kept == false);
  CHECK(board.knob.control_config().beta == 0.5);
  load_config(board.knob, done.configuration);
  CHECK(board.knob.control_config().beta == 0.25);

  StandIn old;
  old.other_release = true;
  const FirmwarePlan plan = prepare_update(old.file, {}, old.options);
  CHECK(plan.loses_configuration());
  CHECK(plan.text() ==
        "the knob E661 (whose firmware is of another release) gets firmware 0.9.7 for board pico");
  CHECK_FALSE(carry_out(plan).kept.has_value());
}

TEST_CASE("an update that waits can be interrupted") {
  StandIn board;
  board.options.host.start_bootloader = [](const std::string&) {};
  board.options.interrupted = [&] { return board.said.size() == 2; };
  CHECK_THROWS_WITH_AS(board.update(), doctest::Contains("unplugged"), Interrupted);
}

#ifndef _WIN32  // which has no limit of a file's size
TEST_CASE("a drive that fails at its last block is told, and that the board still waits") {
  StandIn board;
  write(board.file, firmware_bytes(129));  // the last alone in what is written at once
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  board.options.host.start_bootloader = [&](const std::string&) {
    board.plugged = false;
    board.appear();
    const rlimit all_but_one{512 * 128, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &all_but_one) == 0);
  };
  CHECK_THROWS_WITH_AS(board.update(), doctest::Contains("the board still waits"), Error);
  REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
  std::signal(SIGXFSZ, handler);
}
#endif
