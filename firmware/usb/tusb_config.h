/* TinyUSB's settings, the same for every port. A port's own settings come from its build:
 * CFG_TUSB_MCU and CFG_TUSB_OS, and TUP_DCD_ENDPOINT_MAX where TinyUSB does not know the chip. */
#pragma once

#define CFG_TUD_ENABLED 1
#define CFG_TUD_ENDPOINT0_SIZE 64
#define CFG_TUSB_RHPORT0_MODE (OPT_MODE_DEVICE | OPT_MODE_FULL_SPEED)

/* No class driver of TinyUSB's. Its HID driver acknowledges a SET_REPORT before anybody has read
 * it, and accepts output reports without room for them. See hid_driver.cpp. */
#define CFG_TUD_HID 0
