// The lock of a device where others may write: what they put in its place neither blocks nor helps.
#include <doctest/doctest.h>
#include <fcntl.h>
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

TEST_CASE("without a runtime directory the locks are in one that is the user's own") {
  const RuntimeDirectory runtime(nullptr);
  const std::string directory = "/tmp/torsio-" + std::to_string(getuid());
  {
    DeviceLock first("/dev/null");
    CHECK_THROWS_AS(DeviceLock("/dev/null"), DeviceBusy);
    struct stat there{};
    REQUIRE(lstat(directory.c_str(), &there) == 0);
    CHECK((there.st_mode & 0777) == 0700);
    CHECK(there.st_uid == getuid());
    first.remove_file();
  }
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
