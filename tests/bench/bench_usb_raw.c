// Round trips with nothing between the program and hidapi: prints the seconds of each, one a line.
// bench_usb.py compares the SDK with this.
#include <hidapi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// docs/reference/protocol.md: command (disarm, which a disarmed knob takes and answers) and acknowledgement.
enum { REPORT_SIZE = 64, COMMAND = 0x10, DISARM = 2, ACKNOWLEDGEMENT = 0x41 };
enum { TIMEOUT_MS = 5000 };

static double seconds_now(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int round_trip(hid_device* device, unsigned sequence) {
  unsigned char report[REPORT_SIZE] = {COMMAND, (unsigned char)(sequence & 0xFFU),
                                       (unsigned char)(sequence >> 8U), 0, DISARM};
  if (hid_write(device, report, sizeof report) != REPORT_SIZE) return -1;
  unsigned char answer[REPORT_SIZE];
  do {
    if (hid_read_timeout(device, answer, sizeof answer, TIMEOUT_MS) <= 0) return -1;
  } while (answer[0] != ACKNOWLEDGEMENT || answer[1] != report[1] || answer[2] != report[2]);
  return answer[4] == 0 ? 0 : -1;  // its status
}

int main(int argc, char** argv) {
  if (argc != 4) {
    fputs("usage: bench_usb_raw PATH WARM_UP TRIPS\n", stderr);
    return 2;
  }
  hid_device* device = hid_open_path(argv[1]);
  if (device == NULL) {
    fprintf(stderr, "bench_usb_raw: cannot open %s\n", argv[1]);
    return 1;
  }
  const int warm_up = atoi(argv[2]);
  const int trips = atoi(argv[3]);
  int status = 0;
  for (int i = 0; i < warm_up + trips && status == 0; ++i) {
    const double begin = seconds_now();
    status = round_trip(device, (unsigned)i % 0xFFFFU + 1U);
    if (i >= warm_up) printf("%.9f\n", seconds_now() - begin);
  }
  if (status != 0) fputs("bench_usb_raw: no answer, or a refusal\n", stderr);
  hid_close(device);
  return status == 0 ? 0 : 1;
}
