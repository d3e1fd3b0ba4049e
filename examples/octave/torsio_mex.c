// One knob for Octave and MATLAB: mkoctfile --mex torsio_mex.c $(pkg-config --cflags --libs torsio-c)
//
//   torsio_mex('open', 'emulated')           a selector as torsio_knob_open takes it
//   torsio_mex('wall', angle_rad, stiffness_nm_per_rad)
//   torsio_mex('push', [time_s, torque_nm])  the hand of an emulated knob, a row a knot
//   torsio_mex('arm')
//   log = torsio_mex('record', duration_s)   rows of time_s, angle_rad, felt torque in N m
//   torsio_mex('close')
#include <mex.h>
#include <stdlib.h>
#include <string.h>
#include <torsio.h>

static torsio_knob *knob = NULL;

static void close_knob(void) {
  torsio_knob_free(knob);
  knob = NULL;
}

static void check(torsio_result result) {
  if (result != TORSIO_OK) mexErrMsgIdAndTxt("torsio:error", "%s", torsio_last_error());
}

static double number(const mxArray *value) {
  if (!mxIsDouble(value) || mxGetNumberOfElements(value) != 1) {
    mexErrMsgIdAndTxt("torsio:usage", "a number is wanted here");
  }
  return mxGetScalar(value);
}

static void open_knob(const mxArray *selector) {
  char *text = mxArrayToString(selector);
  close_knob();
  const torsio_result result = torsio_knob_open(text, NULL, &knob);
  mxFree(text);
  check(result);
}

static void play_wall(double angle_rad, double stiffness_nm_per_rad) {
  torsio_wall wall;
  check(torsio_wall_init(&wall));
  wall.angle_rad = angle_rad;
  wall.stiffness_nm_per_rad = stiffness_nm_per_rad;
  torsio_scene *scene = NULL;
  check(torsio_scene_new(&scene));
  torsio_result result = torsio_scene_add_wall(scene, &wall);
  if (result == TORSIO_OK) result = torsio_knob_play(knob, scene);
  torsio_scene_free(scene);
  check(result);
}

static void push(const mxArray *rows) {
  if (!mxIsDouble(rows) || mxGetN(rows) != 2) {
    mexErrMsgIdAndTxt("torsio:usage", "rows of a time and a torque are wanted");
  }
  const size_t count = mxGetM(rows);
  const double *columns = mxGetPr(rows);
  torsio_knot *knots = mxMalloc((count + 1) * sizeof *knots);
  for (size_t i = 0; i < count; ++i) knots[i] = (torsio_knot){columns[i], columns[count + i]};
  torsio_torque_hand hand;
  torsio_result result = torsio_torque_hand_init(&hand);
  hand.torque_nm = knots;
  hand.torque_nm_count = count;
  if (result == TORSIO_OK) result = torsio_emulator_set_torque_hand(knob, &hand);
  mxFree(knots);
  check(result);
}

static mxArray *record(double duration_s) {
  torsio_recording *log = NULL;
  const torsio_result result = torsio_knob_record(knob, duration_s, 0.0, true, &log);
  const size_t count = torsio_recording_count(log);
  const torsio_telemetry_sample *samples = torsio_recording_samples(log);
  mxArray *rows = mxCreateDoubleMatrix(count, 3, mxREAL);
  double *columns = mxGetPr(rows);
  for (size_t i = 0; i < count; ++i) {
    columns[i] = samples[i].time_s;
    columns[count + i] = samples[i].angle_rad;
    columns[2 * count + i] = samples[i].spring_torque_nm + samples[i].motor_command_nm;
  }
  torsio_recording_free(log);
  check(result);
  return rows;
}

void mexFunction(int outputs, mxArray *output[], int inputs, const mxArray *input[]) {
  char word[16] = "";
  if (inputs > 0) mxGetString(input[0], word, sizeof word);
  (void)outputs;
  mexAtExit(close_knob);
  if (strcmp(word, "open") == 0 && inputs == 2 && mxIsChar(input[1])) {
    open_knob(input[1]);
  } else if (strcmp(word, "wall") == 0 && inputs == 3) {
    play_wall(number(input[1]), number(input[2]));
  } else if (strcmp(word, "push") == 0 && inputs == 2) {
    push(input[1]);
  } else if (strcmp(word, "arm") == 0 && inputs == 1) {
    check(torsio_knob_arm(knob));
  } else if (strcmp(word, "record") == 0 && inputs == 2) {
    output[0] = record(number(input[1]));
  } else if (strcmp(word, "close") == 0 && inputs == 1) {
    close_knob();
  } else {
    mexErrMsgIdAndTxt("torsio:usage", "open, wall, push, arm, record or close; see torsio_mex.c");
  }
}
