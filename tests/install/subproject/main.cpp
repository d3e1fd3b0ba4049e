#include <cstdio>
#include <torsio/knob.hpp>

// Tells what this build says about the emulated knob, which it does not have.
int main() {
  for (const torsio::ListedDevice& device : torsio::list_devices()) {
    if (device.transport == "emulated") return 1;
  }
  try {
    const torsio::Knob knob = torsio::Knob::open("emulated");
  } catch (const torsio::DeviceNotFound& error) {
    std::puts(error.what());
    return 0;
  }
  return 1;
}
