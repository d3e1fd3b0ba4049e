// A program for Windows that takes the knob that is plugged in, and tells what comes of it.
#include <stdbool.h>
#include <stdio.h>
#include <torsio.h>

// Ends the function that it stands in.
#define TRY(call)                                      \
  do {                                                 \
    if ((call) != TORSIO_OK) {                         \
      printf("%s: %s\n", #call, torsio_last_error()); \
      return false;                                    \
    }                                                  \
  } while (0)

static bool list(void) {
  torsio_listed_device found[4];
  size_t count = 0;
  TRY(torsio_list_devices(found, 4, sizeof *found, &count));
  for (size_t i = 0; i < count; ++i) {
    printf("listed %s %s%s\n", found[i].transport, found[i].serial, found[i].problem);
  }
  return true;
}

static bool play_wall(torsio_knob *knob) {
  torsio_wall wall;
  TRY(torsio_wall_init(&wall));
  wall.angle_rad = 0.1;
  wall.stiffness_nm_per_rad = 1.4;
  torsio_scene *scene = NULL;
  TRY(torsio_scene_new(&scene));
  TRY(torsio_scene_add_wall(scene, &wall));
  const torsio_result result = torsio_knob_play(knob, scene);
  torsio_scene_free(scene);
  TRY(result);
  return true;
}

static bool record(torsio_knob *knob, double duration_s) {
  torsio_recording *log = NULL;
  const torsio_result result = torsio_knob_record(knob, duration_s, 1000.0, true, &log);
  if (result != TORSIO_OK) printf("%s: %s\n", torsio_result_name(result), torsio_last_error());
  const torsio_telemetry_sample *samples = torsio_recording_samples(log);
  const size_t count = torsio_recording_count(log);
  double furthest_rad = 0.0;
  for (size_t i = 0; i < count; ++i) {
    if (samples[i].angle_rad > furthest_rad) furthest_rad = samples[i].angle_rad;
  }
  printf("recorded %zu samples, up to %.3f rad\n", count, furthest_rad);
  torsio_recording_free(log);
  return true;
}

static bool use(void) {
  if (!list()) return false;
  torsio_knob *knob = NULL;
  TRY(torsio_knob_open(NULL, NULL, &knob));
  torsio_device_info info;
  TRY(torsio_device_info_init(&info));
  TRY(torsio_knob_info(knob, &info));
  printf("opened %s\n", info.serial);
  torsio_knob *second = NULL;
  if (torsio_knob_open(NULL, NULL, &second) == TORSIO_DEVICE_BUSY) printf("busy\n");
  if (!play_wall(knob)) return false;
  TRY(torsio_knob_arm(knob));
  printf("armed\n");
  fflush(stdout);
  if (!record(knob, 1.5)) return false;
  printf("pull\n");
  fflush(stdout);
  if (!record(knob, 60.0)) return false;
  torsio_knob_free(knob);
  return true;
}

int main(void) {
  const bool used = use();
  fflush(stdout);
  return used ? 0 : 1;
}
