/// @file
/// Shared by all parts of torsio.h: results, handles, and the mark of visible functions.
#ifndef TORSIO_BASE_H
#define TORSIO_BASE_H

#include <stdint.h>

#if defined(_WIN32) && defined(TORSIO_C_BUILD)
#define TORSIO_API __declspec(dllexport)
#elif defined(_WIN32)
#define TORSIO_API __declspec(dllimport)
#else
#define TORSIO_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/// Result of a function. After anything but TORSIO_OK, torsio_last_error() has a sentence that says
/// what was wrong and what to do. Outputs are then unchanged, unless the function says otherwise.
typedef enum torsio_result {
  TORSIO_OK = 0,
  TORSIO_INVALID_ARGUMENT = 1,   ///< NULL, a wrong size, or a value that the device would refuse
  TORSIO_DEVICE_NOT_FOUND = 2,   ///< no such device, no device, or more than one to choose from
  TORSIO_PERMISSION_DENIED = 3,  ///< it is there, but this user may not open it
  TORSIO_DEVICE_BUSY = 4,        ///< somebody, maybe this very program, has opened it already
  TORSIO_PROTOCOL_MISMATCH = 5,  ///< firmware and library are of different releases
  TORSIO_REFUSED = 6,            ///< the device said no; see torsio_last_refusal()
  TORSIO_DISARMED = 7,           ///< the torque went while it was to stay
  TORSIO_TIMEOUT = 8,            ///< the device did not answer, or what was waited for did not come
  TORSIO_DISCONNECTED = 9,       ///< unplugged, or without power; open it again once it is back
  TORSIO_CLOSED = 10,            ///< the knob was closed
  TORSIO_OUT_OF_MEMORY = 11,
  TORSIO_ERROR = 12,  ///< anything else
} torsio_result;

/// Number of this interface. It grows when a program that is linked with the library would break;
/// new functions leave it alone. torsio_abi_version() gives the library's number.
#define TORSIO_ABI_VERSION 1

/// Bytes of every text in a structure, with the 0 at its end. A longer text is cut.
#define TORSIO_TEXT_BYTES 256

// Handles: the library makes them, and only it looks inside. Each has a function that frees it.
typedef struct torsio_knob torsio_knob;            ///< an open knob
typedef struct torsio_scene torsio_scene;          ///< effects that play together
typedef struct torsio_recording torsio_recording;  ///< samples of a span of time
typedef struct torsio_steps torsio_steps;          ///< steps at equal distances of time
typedef struct torsio_watch torsio_watch;  ///< a look-out for knobs plugged in and pulled out

#ifdef __cplusplus
}
#endif

#endif
