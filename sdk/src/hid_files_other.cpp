// A knob's path where it is no file. On Windows it names a device interface, on macOS an entry of
// IOKit's registry. Every user may open them.
#include "hid_files.hpp"
#include "hid_transport.hpp"

namespace torsio {

// hidapi asks the system about the path before it does anything else.
void refuse_other_files(const std::string&) {}

std::string permission_text(const std::string& path) {
#ifdef _WIN32
  return "Windows does not let this program open " + path +
         ": another program may have it for itself; close that, and plug the knob in again";
#else
  return "macOS does not let this program open " + path +
         ": allow it under System Settings, Privacy & Security, Input Monitoring, and start it "
         "again. Or close another program that has the knob";
#endif
}

std::shared_ptr<const void> keep_open(const std::string&) { return nullptr; }

// No files tell of arrivals and departures.
std::string hid_files_directory() { return {}; }

std::optional<std::vector<HidListing>> list_hid_files() { return std::nullopt; }

std::string permission_problem(const std::string&) { return {}; }

}  // namespace torsio
