#include "file_sync.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace torsio {

void sync_file(const std::filesystem::path& path) noexcept {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

}  // namespace torsio
