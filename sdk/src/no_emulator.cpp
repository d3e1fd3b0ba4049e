// In place of the folder emulated/ in a build without the emulator.
#include "emulated_transport.hpp"
#include "torsio/error.hpp"

namespace torsio {

bool has_emulator() noexcept { return false; }

Connection open_emulated(const std::string& /*name*/, const EmulatorOptions& /*options*/) {
  throw DeviceNotFound(
      "this build of the library has no emulated knob; build it with TORSIO_WITH_EMULATOR=ON, or "
      "plug a knob in");
}

}  // namespace torsio
