// The lock of a device in a folder that others may write to.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "device_lock.hpp"
#include "temporary_directory.hpp"
#include "torsio/error.hpp"

using namespace torsio;

namespace {

/// $XDG_RUNTIME_DIR for as long as it lives.
class RuntimeDirectory {
 public:
  explicit RuntimeDirectory(const char* path) {
    const char* before = std::getenv("XDG_RUNTIME_DIR");
    if (before != nullptr) before_ = before;
    path != nullptr ? setenv("XDG_RUNTIME_DIR", path, 1) : unsetenv("XDG_RUNTIME_DIR");
  }
  ~RuntimeDirectory() {
    before_.empty() ? unsetenv("XDG_RUNTIME_DIR") : setenv("XDG_RUNTIME_DIR", before_.c_str(), 1);
  }
  RuntimeDirectory(const RuntimeDirectory&) = delete;
  RuntimeDirectory& operator=(const RuntimeDirectory&) = delete;

 private:
  std::string before_;
};

/// The folder of this user's locks in one that is shared.
std::string own_in(const test::TemporaryDirectory& shared) {
  return shared.path() + "/torsio-" + std::to_string(getuid());
}

}  // namespace

TEST_CASE("a pipe or a link in the place of the lock file neither blocks nor is used") {
  const test::TemporaryDirectory directory;
  const RuntimeDirectory runtime(directory.path().c_str());
  const std::string place = directory.path() + "/torsio-dev-null.lock";

  REQUIRE(mkfifo(place.c_str(), 0666) == 0);
  {
    DeviceLock unguarded("/dev/null");  // would wait for ever for a writer
    CHECK_NOTHROW(DeviceLock("/dev/null"));
  }
  std::filesystem::remove(place);

  const std::string other = directory.path() + "/other";
  std::ofstream(other) << "kept";
  std::filesystem::create_symlink(other, place);
  {
    DeviceLock unguarded("/dev/null");
    CHECK_NOTHROW(DeviceLock("/dev/null"));
  }
  CHECK(std::filesystem::file_size(other) == 4);
}

TEST_CASE("a lock file that this user may not open is another's: the device is busy") {
  const test::TemporaryDirectory directory;
  REQUIRE(chmod(directory.path().c_str(), 0755) == 0);
  const RuntimeDirectory runtime(directory.path().c_str());
  const std::string place = directory.path() + "/torsio-dev-null.lock";
  std::ofstream(place) << "kept";
  REQUIRE(chmod(place.c_str(), 0) == 0);
  // Root may open everything.
  const uid_t user = geteuid();
  if (user == 0) REQUIRE(seteuid(65534) == 0);
  CHECK_THROWS_WITH_AS(DeviceLock("/dev/null"), doctest::Contains(place.c_str()), DeviceBusy);
  if (user == 0) REQUIRE(seteuid(0) == 0);
}

TEST_CASE("without a free descriptor there is no lock, and no device either") {
  const test::TemporaryDirectory directory;
  const RuntimeDirectory runtime(directory.path().c_str());
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_NOFILE, &before) == 0);
  const rlimit none{.rlim_cur = 0, .rlim_max = before.rlim_max};
  std::string told;
  REQUIRE(setrlimit(RLIMIT_NOFILE, &none) == 0);
  try {
    const DeviceLock unguarded("/dev/null");
  } catch (const DeviceBusy&) {
    told = "busy";
  } catch (const Error& error) {
    told = error.what();
  }
  REQUIRE(setrlimit(RLIMIT_NOFILE, &before) == 0);
  CHECK(told.starts_with(directory.path()));
  CHECK(told.ends_with("Too many open files"));
}

TEST_CASE("root leaves no lock in the runtime directory of the user who called it") {
  if (getuid() != 0) return;
  const test::TemporaryDirectory directory;
  const test::TemporaryDirectory shared;
  REQUIRE(chown(directory.path().c_str(), 65534, 65534) == 0);
  const RuntimeDirectory runtime(directory.path().c_str());
  const DeviceLock lock("/dev/null", shared.path());
  CHECK(std::filesystem::is_empty(directory.path()));
  CHECK_THROWS_AS(DeviceLock("/dev/null", shared.path()), DeviceBusy);
}

TEST_CASE("without a runtime directory the locks are in one that is the user's own") {
  const RuntimeDirectory runtime(nullptr);
  const test::TemporaryDirectory shared;
  const std::string directory = own_in(shared);
  const DeviceLock first("/dev/null", shared.path());
  CHECK_THROWS_AS(DeviceLock("/dev/null", shared.path()), DeviceBusy);
  struct stat there{};
  REQUIRE(lstat(directory.c_str(), &there) == 0);
  CHECK((there.st_mode & 07777) == 0700);
  CHECK(there.st_uid == getuid());
  CHECK(std::filesystem::exists(directory + "/torsio-dev-null.lock"));
}

TEST_CASE("a folder in the place of the user's own that others made or may write to is not used") {
  const RuntimeDirectory runtime(nullptr);
  const test::TemporaryDirectory shared;
  const std::string directory = own_in(shared);
  SUBCASE("its group may write to it") {
    REQUIRE(mkdir(directory.c_str(), 0700) == 0);
    REQUIRE(chmod(directory.c_str(), 0770) == 0);
  }
  SUBCASE("everybody may write to it") {
    REQUIRE(mkdir(directory.c_str(), 0700) == 0);
    REQUIRE(chmod(directory.c_str(), 0702) == 0);
  }
  SUBCASE("a link to another") {
    const std::string elsewhere = shared.path() + "/elsewhere";
    REQUIRE(mkdir(elsewhere.c_str(), 0700) == 0);
    std::filesystem::create_symlink(elsewhere, directory);
  }
  SUBCASE("another user's") {
    if (getuid() != 0) return;  // only root can make one
    REQUIRE(mkdir(directory.c_str(), 0755) == 0);
    REQUIRE(chown(directory.c_str(), 65534, 65534) == 0);
  }
  SUBCASE("no folder") { std::ofstream(directory) << "kept"; }

  const DeviceLock unguarded("/dev/null", shared.path());
  CHECK_NOTHROW(DeviceLock("/dev/null", shared.path()));
  if (std::filesystem::is_directory(directory)) CHECK(std::filesystem::is_empty(directory));
}

TEST_CASE("a lock is free as soon as it is let go, also if a child was forked meanwhile") {
  const test::TemporaryDirectory directory;
  const RuntimeDirectory runtime(directory.path().c_str());
  int kept = -1;
  {
    DeviceLock lock("/dev/null");
    // A child has the same open file, as a duplicate has.
    for (int file = 3; file < 256 && kept < 0; ++file) {
      struct stat open{};
      struct stat there{};
      if (fstat(file, &open) == 0 &&
          stat((directory.path() + "/torsio-dev-null.lock").c_str(), &there) == 0 &&
          open.st_ino == there.st_ino && open.st_dev == there.st_dev) {
        kept = dup(file);
      }
    }
    REQUIRE(kept >= 0);
  }
  CHECK_NOTHROW(DeviceLock("/dev/null"));
  close(kept);
}
