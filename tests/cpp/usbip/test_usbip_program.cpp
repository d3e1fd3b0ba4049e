// The parts of torsio_virtual_knob: its clock, its hands, its options and its log.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <variant>

#include "emulator/usbip/hands.hpp"
#include "emulator/usbip/options.hpp"
#include "emulator/usbip/pacer.hpp"
#include "emulator/usbip/storage.hpp"
#include "emulator/usbip/truth_log.hpp"
#include "temporary_directory.hpp"

using namespace torsio::emulator;
using namespace torsio::emulator::usbip;
using namespace std::chrono_literals;

namespace {

Hand hand_from(const std::string& text) {
  std::istringstream stream(text);
  return read_hand(stream, "hand.txt");
}

std::string complaint(const std::string& text) {
  try {
    (void)hand_from(text);
  } catch (const BadScript& error) {
    return error.what();
  }
  return "";
}

ProgramOptions options_from(std::initializer_list<std::string_view> arguments) {
  return read_options(std::span(arguments.begin(), arguments.size()));
}

}  // namespace

TEST_CASE("pacer gives one frame a millisecond") {
  const Pacer::Time start{};
  Pacer pacer(start);
  CHECK_FALSE(pacer.take(start));
  CHECK(pacer.until_next(start + 400us) == 600us);
  CHECK(pacer.in_frame(start + 400us) == 400us);
  CHECK(pacer.in_frame(start + 5ms) == 1ms);
  CHECK(pacer.take(start + 1ms));
  CHECK_FALSE(pacer.take(start + 1ms));
  CHECK(pacer.until_next(start + 1ms) == 1ms);
}

TEST_CASE("pacer that is a little late catches up and slips nothing") {
  const Pacer::Time start{};
  Pacer pacer(start);
  int frames = 0;
  while (pacer.take(start + 9ms)) ++frames;
  CHECK(frames == 9);
  CHECK(pacer.take_slipped() == 0ms);
}

TEST_CASE("pacer that is very late slips instead of racing") {
  const Pacer::Time start{};
  Pacer pacer(start);
  int frames = 0;
  while (pacer.take(start + 10s)) ++frames;
  CHECK(frames <= 2);
  CHECK(pacer.take_slipped() >= 9990ms);
  CHECK(pacer.take_slipped() == 0ms);
}

TEST_CASE("script of torques is a path that may jump") {
  const Hand hand = hand_from("# a push\n torque_nm\n\n0 0\n1 0.02 # now\n1 -0.03\r\n2.5 0\n");
  const Profile& profile = std::get<TorqueHand>(hand).torque_nm;
  CHECK(profile.value(500'000'000) == doctest::Approx(0.01));
  CHECK(profile.value(1'000'000'000) == doctest::Approx(-0.03));
  CHECK(profile.value(9'000'000'000) == doctest::Approx(0.0));
}

TEST_CASE("script of angles is a firm hand or an exact motion") {
  CHECK(std::get<ImpedanceHand>(hand_from("angle_rad\n0 0\n1 0.5\n"))
            .intended_angle_rad.value(500'000'000) == doctest::Approx(0.25));
  CHECK(std::get<PrescribedMotion>(hand_from("motion_rad\n0 0\n1 0.5\n"))
            .angle_rad.value(500'000'000) == doctest::Approx(0.25));
}

TEST_CASE("bad script is refused with its line") {
  CHECK(complaint("") == "hand.txt:0: the file ends before its first corner TIME_S VALUE");
  CHECK(complaint("torque_nm\n# none\n").starts_with("hand.txt:2: the file ends"));
  CHECK(complaint("\xEF\xBB\xBFtorque_nm\n0 0\n").empty());
  CHECK(complaint("\xFF\xFEt") == "hand.txt:1: is in UTF-16: save it as UTF-8");
  CHECK(complaint("\xFE\xFF") == "hand.txt:1: is in UTF-16: save it as UTF-8");
  CHECK(complaint("torque\n0 0\n").starts_with("hand.txt:1: the first line must be"));
  CHECK(complaint("torque_nm\n0 zero\n").starts_with("hand.txt:2: needs TIME_S VALUE"));
  CHECK(complaint("torque_nm\n0\n").starts_with("hand.txt:2: needs TIME_S VALUE"));
  CHECK(complaint("torque_nm\n0 0 0\n").starts_with("hand.txt:2: needs TIME_S VALUE"));
  CHECK(complaint("torque_nm\nnan 0\n").starts_with("hand.txt:2: needs TIME_S VALUE"));
  CHECK(complaint("torque_nm\n0 inf\n").starts_with("hand.txt:2: needs TIME_S VALUE"));
  CHECK(complaint("torque_nm\n0 11\n").starts_with("hand.txt:2: needs TIME_S VALUE"));
  CHECK(complaint("torque_nm\n1 0\n0 0\n") == "hand.txt:3: is earlier than the line before it");
  CHECK(complaint("torque_nm\n1 0\n1 1\n1 0\n").starts_with("hand.txt:4: is the third"));
  CHECK(complaint("angle_rad\n1 0\n1 1\n").starts_with("hand.txt:3: has the time of the line"));
  CHECK(complaint("angle_rad\n0 0\n1e-3 99\n2e-3 -2\n").starts_with("hand.txt:4: is further"));
  CHECK(complaint("motion_rad\n0 0\n1e-9 1.5\n2 0\n").starts_with("hand.txt:3: is further"));
  CHECK(complaint("motion_rad\n0 0\n1 1e5\n1.001 99900\n").empty());
  CHECK(complaint("torque_nm\n0 0\n1e-9 10\n").empty());
}

TEST_CASE("hand follows commands and refuses what is none") {
  EmulatedDevice device({.hand = still_hand()});
  device.advance(1'000'000);
  HandCommands commands(device);
  CHECK(commands.follow("torque 0.03"));
  device.advance(100'000'000);
  CHECK(device.plant().state().knob_speed_rad_s() > 0.1);
  CHECK(commands.follow("still"));
  device.advance(10'000'000);
  CHECK(device.plant().state().knob_speed_rad_s() == 0.0);
  CHECK(commands.follow(" angle 0.5\r"));
  CHECK(commands.follow("angle -0.25"));
  device.advance(2'000'000'000);
  // A firm hand against the friction of the knob and the brake's drag.
  CHECK(device.plant().state().knob_angle_rad() == doctest::Approx(-0.25).scale(0).epsilon(0.05));
  CHECK(commands.follow("free"));
  for (const char* line : {"", "torque", "torque x", "torque nan", "torque 11", "angle",
                           "angle 1 2", "still 1", "free now", "dance"}) {
    CHECK_FALSE(commands.follow(line));
  }
}

TEST_CASE("a hand that is told an angle does not jump there, however near or far it is") {
  for (const double angle_rad : {0.1, 1.0}) {
    CAPTURE(angle_rad);
    EmulatedDevice device({.hand = still_hand()});
    device.advance(1'000'000);
    HandCommands commands(device);
    REQUIRE(commands.follow("angle " + std::to_string(angle_rad)));
    double fastest_rad_s = 0.0;
    for (int ms = 0; ms < 300; ++ms) {
      device.advance(1'000'000);
      fastest_rad_s = std::max(fastest_rad_s, device.plant().state().knob_speed_rad_s());
    }
    // In 50 ms, and at 10 rad/s; the hand is soft enough to swing a little beyond that.
    CHECK(fastest_rad_s < 1.5 * std::min(angle_rad / 0.05, 10.0));
    CHECK(fastest_rad_s > 0.5 * std::min(angle_rad / 0.05, 10.0));
  }
}

TEST_CASE("hand follows a script while the knob runs, and one that no hand can is refused") {
  const torsio::test::TemporaryDirectory folder;
  const std::string path = folder.path() + "/a script";
  EmulatedDevice device({.hand = still_hand()});
  device.advance(1'000'000);
  HandCommands commands(device);
  std::ofstream(path) << "motion_rad\n0 0\n0.1 0.5\n";
  CHECK(commands.follow("script " + path));
  device.advance(200'000'000);
  CHECK(device.plant().state().knob_angle_rad() == doctest::Approx(0.5));
  std::ofstream(path) << "motion_rad\n0 0\n1e-9 1.5\n";
  CHECK_FALSE(commands.follow("script " + path));
  CHECK_FALSE(commands.follow("script " + path + " that is not there"));
}

namespace {

torsio::device::StoredSlots filled_with(std::uint8_t byte) {
  torsio::device::StoredSlots slots;
  for (auto& bytes : slots.slot) bytes.fill(byte);
  return slots;
}

/// No file may become longer than half a slot, as on a disk that is nearly full.
class SmallDisk {
 public:
  SmallDisk() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before_) == 0);
    rlimit small = before_;
    small.rlim_cur = torsio::device::kSlotSize / 2;
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    (void)setrlimit(RLIMIT_FSIZE, &before_);
    (void)std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace

TEST_CASE("storage that cannot be written stays whole, is told, and is written with the next try") {
  const torsio::test::TemporaryDirectory folder;
  const std::string path = folder.path() + "/" + std::string(255, 'x');
  Storage storage(path);
  CHECK(storage.slots().slot == torsio::device::empty_slots().slot);
  const torsio::device::StoredSlots old = filled_with(1);
  const torsio::device::StoredSlots later = filled_with(2);
  CHECK(storage.keep(old).empty());
  using std::filesystem::perms;
  const perms mode = perms::owner_read | perms::owner_write;
  std::filesystem::permissions(path, mode);
  std::filesystem::create_symlink(path, folder.path() + "/link");
  Storage linked(folder.path() + "/link");
  for (const int attempt : {1, 2}) {
    CAPTURE(attempt);
    std::string told;
    {
      const SmallDisk small;
      told = linked.keep(later);
    }
    CHECK(told == path + ": cannot be written: File too large");
    CHECK(Storage(path).slots().slot == old.slot);
  }
  CHECK(linked.keep(later).empty());
  CHECK(Storage(path).slots().slot == later.slot);
  CHECK(std::filesystem::is_symlink(folder.path() + "/link"));
  CHECK(std::filesystem::status(path).permissions() == mode);
  using Files = std::filesystem::directory_iterator;
  CHECK(std::distance(Files(folder.path()), Files()) == 2);  // nothing is left beside
  // A process of the same number was killed in the middle.
  std::ofstream(folder.path() + "/.torsio-" + std::to_string(getpid())) << "half";
  CHECK(linked.keep(old).empty());
}

TEST_CASE("storage that is there and cannot be read is told, and is no new one") {
  const torsio::test::TemporaryDirectory folder;
  const std::string path = folder.path() + "/round";
  std::filesystem::create_symlink(path, path);
  CHECK_THROWS_WITH_AS(
      Storage{path},
      ("--storage " + path + ": cannot be read: Too many levels of symbolic links").c_str(),
      BadOption);
}

TEST_CASE("storage that no file can take the place of is refused before the program starts") {
  const torsio::test::TemporaryDirectory folder;
  const std::string path = folder.path() + "/pipe";
  REQUIRE(mkfifo(path.c_str(), 0600) == 0);
  CHECK_THROWS_WITH_AS(Storage{path}, ("--storage " + path + " is no file").c_str(), BadOption);
  const std::string nowhere = folder.path() + "/nowhere/x";
  CHECK_THROWS_WITH_AS(
      Storage{nowhere},
      ("--storage " + nowhere + ": there is no folder " + folder.path() + "/nowhere").c_str(),
      BadOption);
}

TEST_CASE("options are read in both ways of writing them") {
  const ProgramOptions options =
      options_from({"--port", "0", "--rate-hz=10000", "--serial", "K-2", "--seed=7", "--status",
                    "--hand", "scripted:a file", "--log=x.csv", "--address", "0.0.0.0"});
  CHECK(options.port == 0);
  CHECK(options.rate_hz == 10000.0);
  CHECK(options.serial == "K-2");
  CHECK(options.seed == 7);
  CHECK(options.status);
  CHECK_FALSE(options.commands);
  CHECK(options.hand == "scripted:a file");
  CHECK(options.log == "x.csv");
  CHECK(options.address == "0.0.0.0");
}

TEST_CASE("a hand that pushes is a free one that follows commands") {
  const ProgramOptions pushes = options_from({"--hand", "pushes"});
  CHECK(pushes.hand == "free");
  CHECK(pushes.commands);
  const ProgramOptions still = options_from({"--commands"});
  CHECK(still.hand == "still");
  CHECK(still.commands);
}

TEST_CASE("bad options are refused") {
  CHECK_THROWS_AS(options_from({"--port", "65536"}), BadOption);
  CHECK_THROWS_AS(options_from({"--port", "-1"}), BadOption);
  CHECK_THROWS_AS(options_from({"--port", ""}), BadOption);
  CHECK_THROWS_AS(options_from({"--port"}), BadOption);
  CHECK_THROWS_AS(options_from({"--rate-hz", "nan"}), BadOption);
  CHECK_THROWS_AS(options_from({"--rate-hz", "999"}), BadOption);
  CHECK_THROWS_AS(options_from({"--rate-hz", "20001"}), BadOption);
  CHECK_THROWS_AS(options_from({"--port", "80x"}), BadOption);
  CHECK_THROWS_AS(options_from({"--hand", "tight"}), BadOption);
  CHECK_THROWS_AS(options_from({"--hand", "scripted:"}), BadOption);
  CHECK_THROWS_AS(options_from({"--colour", "red"}), BadOption);
  CHECK_THROWS_AS(options_from({"port"}), BadOption);
  CHECK_THROWS_WITH_AS(options_from({"--status=1"}), "--status takes no value", BadOption);
}
