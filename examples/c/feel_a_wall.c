// Pushes the emulated knob into a wall, from C: cc feel_a_wall.c $(pkg-config --cflags --libs torsio-c)
#include <stdbool.h>
#include <stdio.h>
#include <torsio.h>

// Ends the function that it stands in.
#define TRY(call)                                        \
  do {                                                   \
    if ((call) != TORSIO_OK) {                           \
      fprintf(stderr, "%s: %s\n", #call, torsio_last_error()); \
      return false;                                      \
    }                                                    \
  } while (0)

static bool play_wall(torsio_knob *knob, double angle_rad, double stiffness_nm_per_rad) {
  torsio_wall wall;
  TRY(torsio_wall_init(&wall));
  wall.angle_rad = angle_rad;
  wall.stiffness_nm_per_rad = stiffness_nm_per_rad;

  torsio_scene *scene = NULL;
  TRY(torsio_scene_new(&scene));
  const bool played = torsio_scene_add_wall(scene, &wall) == TORSIO_OK &&
                      torsio_knob_play(knob, scene) == TORSIO_OK;
  if (!played) fprintf(stderr, "no wall: %s\n", torsio_last_error());
  torsio_scene_free(scene);
  return played;
}

static bool push(torsio_knob *knob) {
  const torsio_knot ever_harder[] = {{0.0, 0.0}, {1.0, 0.05}};  // up to 50 mN m
  torsio_torque_hand hand;
  TRY(torsio_torque_hand_init(&hand));
  hand.torque_nm = ever_harder;
  hand.torque_nm_count = sizeof ever_harder / sizeof *ever_harder;
  TRY(torsio_emulator_set_torque_hand(knob, &hand));
  return true;
}

static void tell(const torsio_recording *log) {
  const torsio_telemetry_sample *samples = torsio_recording_samples(log);
  double furthest_rad = 0.0;
  double strongest_nm = 0.0;
  for (size_t i = 0; i < torsio_recording_count(log); ++i) {
    const double felt_nm = samples[i].spring_torque_nm + samples[i].motor_command_nm;
    if (samples[i].angle_rad > furthest_rad) furthest_rad = samples[i].angle_rad;
    if (-felt_nm > strongest_nm) strongest_nm = -felt_nm;
  }
  printf("the knob was pushed to %.3f rad, into a wall at 0.1 rad,\n", furthest_rad);
  printf("which pushed back with %.0f mN m\n", 1e3 * strongest_nm);
}

static bool feel(torsio_knob *knob) {
  if (!play_wall(knob, 0.1, 1.4) || !push(knob)) return false;
  TRY(torsio_knob_arm(knob));
  torsio_recording *log = NULL;
  const bool recorded = torsio_knob_record(knob, 1.5, 0.0, true, &log) == TORSIO_OK;
  if (!recorded) fprintf(stderr, "the recording ended early: %s\n", torsio_last_error());
  tell(log);
  torsio_recording_free(log);
  return recorded;
}

int main(void) {
  torsio_knob *knob = NULL;
  if (torsio_knob_open("emulated", NULL, &knob) != TORSIO_OK) {
    fprintf(stderr, "no knob: %s\n", torsio_last_error());
    return 1;
  }
  const bool felt = feel(knob);
  torsio_knob_free(knob);
  return felt ? 0 : 1;
}
