// Refuses control transfers that the USB stack would answer into its own memory.
//
// TinyUSB 0.18 does not look at the direction of the standard requests that read. A host that sends
// GET_DESCRIPTOR, GET_STATUS ... with data *to* the device would have the stack write that data
// where it meant to read its answer from: over a descriptor, or into a stack frame that is gone.
// The linker puts this function in front of the one that starts every control transfer (--wrap).
#include <tusb.h>
// Behind tusb.h: the controller's driver.
#include <device/dcd.h>

#include <cstdint>

extern "C" {

// NOLINTBEGIN: these names are the linker's.
bool __real_tud_control_xfer(std::uint8_t port, const tusb_control_request_t* request, void* buffer,
                             std::uint16_t size);

bool __wrap_tud_control_xfer(std::uint8_t port, const tusb_control_request_t* request, void* buffer,
                             std::uint16_t size) {
  const bool standard = request->bmRequestType_bit.type == TUSB_REQ_TYPE_STANDARD;
  const bool to_device = request->bmRequestType_bit.direction == TUSB_DIR_OUT;
  // No standard request that the stack knows takes data. The stack itself stalls only some of what
  // is refused here.
  if (standard && to_device && request->wLength != 0) {
    dcd_edpt_stall(port, 0x00);
    dcd_edpt_stall(port, TUSB_DIR_IN_MASK);
    return false;
  }
  return __real_tud_control_xfer(port, request, buffer, size);
}
// NOLINTEND

}  // extern "C"
