/// @file
/// Torsio from C and languages that call C: find a knob, open it, arm it, play scenes, record.
/// docs/reference/c.md is the guide.
///
/// Nearly every function returns a torsio_result and gives its product through its last pointers.
/// Functions that free, close or look something up do not. None of them lets an exception out.
///
/// Threads: a knob and a watch may be used from any thread at any time. `torsio_knob_close` ends
/// calls that wait in other threads with TORSIO_CLOSED. `torsio_..._free` needs that no thread is
/// in a call with the handle, and none calls with it again. Scenes, recordings and steps belong to
/// one thread at a time. A thread must not be cancelled while it is in a call. After fork() the
/// child may only exit or exec.
///
/// Time: with a plugged-in knob, or an emulated one that is `paced`, time is the wall clock's.
/// Otherwise it is virtual and passes only in calls that wait, as fast as it can be computed.
#ifndef TORSIO_H
#define TORSIO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "torsio_base.h"
#include "torsio_types.h"

#ifdef __cplusplus
extern "C" {
#endif

// Errors -----------------------------------------------------------------------------------------

/// The last error of this thread, as a sentence; "" without an error. Valid until the next call of
/// this thread that fails.
TORSIO_API const char* torsio_last_error(void);

/// A sentence if the knob may swing or hum for ever in what this thread played or streamed last. It plays
/// all the same: torsio_knob_play() or torsio_knob_stream_local_model() has succeeded. "" if not. A
/// local model is judged when it is stiffer or damps more than all since the scene began. Valid
/// until the next such call of this thread.
TORSIO_API const char* torsio_last_warning(void);

/// Parts of a refusal by the device.
typedef struct torsio_refusal {
  uint32_t struct_size;            ///< bytes of a torsio_refusal
  char status[TORSIO_TEXT_BYTES];  ///< why, in one word of docs/reference/protocol.md: "not_armed",
                                   ///< ...
  char report[TORSIO_TEXT_BYTES];  ///< what was refused: "wall", "command", ...
  char field[TORSIO_TEXT_BYTES];   ///< the offending field; "" if none in particular
  char reason[TORSIO_TEXT_BYTES];  ///< if the torque had gone before, why: "watchdog", ...
} torsio_refusal;
TORSIO_API torsio_result torsio_refusal_init(torsio_refusal* structure);

/// The parts of the last refusal in this thread. TORSIO_ERROR if there has been none.
TORSIO_API torsio_result torsio_last_refusal(torsio_refusal* refusal);

/// The name of a result: "TORSIO_OK", ...; NULL if there is no such result.
TORSIO_API const char* torsio_result_name(int32_t result);

/// "major.minor.patch" of the library.
TORSIO_API const char* torsio_version(void);

/// TORSIO_ABI_VERSION of the library; another number than the header's will not work.
TORSIO_API int32_t torsio_abi_version(void);

// Opening ----------------------------------------------------------------------------------------

typedef struct torsio_open_options {
  uint32_t struct_size;      ///< bytes of a torsio_open_options
  double command_timeout_s;  ///< longest wait for an answer of the device; at first 1
  uint64_t ring_samples;     ///< telemetry kept until it is read; 1 to 2^24; at first 65,536
  /// Options of an emulated knob; NULL: the reference. An error if the selector means hardware.
  const torsio_emulator_options* emulator;
} torsio_open_options;
TORSIO_API torsio_result torsio_open_options_init(torsio_open_options* structure);

/// Lists all knobs that are plugged in, and the emulated one, which is always last.
/// @param devices   room for `capacity` of them; may be NULL if that is 0
/// @param item_size sizeof(torsio_listed_device)
/// @param count     how many there are; if more than `capacity`, the rest was left out
TORSIO_API torsio_result torsio_list_devices(torsio_listed_device* devices, size_t capacity,
                                             size_t item_size, size_t* count);

/// Opens a device. It is as it was left: torsio_knob_state() tells whether it is armed.
/// @param selector path, serial number, "emulated", "emulated:NAME"; NULL or "": the only real
///                 device. A named emulated device keeps its saved configuration while the process
///                 lives.
/// @param options  NULL: as torsio_open_options_init() has them
/// @param knob     to be freed with torsio_knob_free()
TORSIO_API torsio_result torsio_knob_open(const char* selector, const torsio_open_options* options,
                                          torsio_knob** knob);

/// Disarms a device and has it wait for new firmware, as a drive of its boot loader. Devices of
/// other releases understand this too. TORSIO_REFUSED if it has no boot loader, as an emulated one.
/// @param selector path or serial number; "": the only real device
TORSIO_API torsio_result torsio_start_bootloader(const char* selector);

/// Disarms, unless the device was told to be autonomous or a game or the dial has the actuator, and
/// lets go of it. NULL is ignored.
TORSIO_API void torsio_knob_close(torsio_knob* knob);
/// Closes and frees. NULL is ignored.
TORSIO_API void torsio_knob_free(torsio_knob* knob);
TORSIO_API bool torsio_knob_is_open(const torsio_knob* knob);
TORSIO_API bool torsio_knob_is_emulated(const torsio_knob* knob);

// State -------------------------------------------------------------------------------------

TORSIO_API torsio_result torsio_knob_info(torsio_knob* knob, torsio_device_info* info);
/// A torsio_state, as last heard of; costs nothing.
TORSIO_API torsio_result torsio_knob_state(torsio_knob* knob, int32_t* state);
/// How the torque went the last time since the knob was opened. TORSIO_ERROR if it never has.
TORSIO_API torsio_result torsio_knob_last_disarm(torsio_knob* knob, torsio_disarm* disarm);
/// The latched faults as the device says now: TORSIO_FAULT_...
TORSIO_API torsio_result torsio_knob_faults(torsio_knob* knob, uint32_t* faults);
TORSIO_API torsio_result torsio_knob_health(torsio_knob* knob, torsio_health* health);
/// Work of motor, brake and shaft on the knob, if the law is TORSIO_LAW_CALIBRATED.
TORSIO_API torsio_result torsio_knob_energies(torsio_knob* knob, torsio_energies* energies);
/// Sums of current readings and of the bridge's shares since the board started.
TORSIO_API torsio_result torsio_knob_motor_current(torsio_knob* knob,
                                                   torsio_motor_current* motor_current);
/// The most that the device gives now, and whether it is held low until its parts are confirmed.
TORSIO_API torsio_result torsio_knob_limits(torsio_knob* knob, torsio_limits* limits);
TORSIO_API torsio_result torsio_knob_clock(torsio_knob* knob, torsio_clock* clock);
TORSIO_API torsio_result torsio_knob_position_rad(torsio_knob* knob, double* position_rad);
TORSIO_API torsio_result torsio_knob_statistics(torsio_knob* knob,
                                                torsio_link_statistics* statistics);
/// Stiffest spring that its parts can render, by its configuration. Beyond it the knob may swing
/// for ever, unless the law is `calibrated`.
TORSIO_API torsio_result torsio_knob_stable_stiffness(torsio_knob* knob,
                                                      torsio_stable_stiffness* stiffness);
/// Effects of games on the device.
TORSIO_API torsio_result torsio_knob_game_status(torsio_knob* knob, torsio_game_status* status);
/// The effects that games have made; parameters as in torsio_list_devices().
TORSIO_API torsio_result torsio_knob_game_effects(torsio_knob* knob, torsio_game_effect* effects,
                                                  size_t capacity, size_t item_size, size_t* count);

// Actions -----------------------------------------------------------------------------------

/// Torque on, softly. TORSIO_REFUSED while a fault is latched.
TORSIO_API torsio_result torsio_knob_arm(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_disarm(torsio_knob* knob);  ///< torque off; the scene stays
TORSIO_API torsio_result torsio_knob_stop(torsio_knob* knob);    ///< torque off, the scene emptied
/// This position becomes angle 0. TORSIO_REFUSED unless disarmed, as for the next two functions.
TORSIO_API torsio_result torsio_knob_zero(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_relax(torsio_knob* knob);        ///< the shaft is relaxed now
TORSIO_API torsio_result torsio_knob_clear_fault(torsio_knob* knob);  ///< once its cause is gone

/// Makes an empty scene; it takes up to 16 effects with torsio_scene_add_...
TORSIO_API torsio_result torsio_scene_new(torsio_scene** scene);
TORSIO_API torsio_result torsio_scene_clear(torsio_scene* scene);
TORSIO_API size_t torsio_scene_count(const torsio_scene* scene);
TORSIO_API void torsio_scene_free(torsio_scene* scene);  ///< NULL is ignored

/// Plays a scene in place of the one before, all of it from the same tick on. The scene may be
/// changed or freed afterwards. If it is refused the old one goes on. No law bounds what keeps
/// moving: a wall or a streamed spring may swing. Keep it below a quarter of
/// torsio_knob_stable_stiffness(), and move it slower than a hand moves.
TORSIO_API torsio_result torsio_knob_play(torsio_knob* knob, const torsio_scene* scene);

/// Sends a local model and does not wait for the device. TORSIO_REFUSED if it is not armed. Later
/// refusals of the device only count, in torsio_knob_statistics().
TORSIO_API torsio_result torsio_knob_stream_local_model(torsio_knob* knob,
                                                        const torsio_local_model* model);
/// Plays one piece of a bounded experiment past scene and law. The knob must be armed. It disarms
/// at the end of the piece without a next one, and beyond a bound.
TORSIO_API torsio_result torsio_knob_excite(torsio_knob* knob, const torsio_excitation* excitation);

/// Takes the oldest event that nobody has taken yet.
/// @param timeout_s how long to wait for one; TORSIO_TIMEOUT if none comes
TORSIO_API torsio_result torsio_knob_next_event(torsio_knob* knob, double timeout_s,
                                                torsio_event* event);

// Configuration: torsio_types.h has what reads and sets it ---------------------------------------

TORSIO_API torsio_result torsio_knob_save(torsio_knob* knob);           ///< returns when it is safe
TORSIO_API torsio_result torsio_knob_load_defaults(torsio_knob* knob);  ///< only while disarmed

// Telemetry --------------------------------------------------------------------------------------

/// Starts telemetry, or changes its rate, and forgets what was not read.
/// @param rate_hz      highest rate wanted; 0: the highest up to 3,600 Hz, or 2,000 if prompt
/// @param prompt       every millisecond the newest samples, up to the control rate, for loops that
///                     use torsio_knob_latest()
/// @param true_rate_hz the rate that it has; may be NULL
TORSIO_API torsio_result torsio_knob_start_telemetry(torsio_knob* knob, double rate_hz, bool prompt,
                                                     double* true_rate_hz);
TORSIO_API torsio_result torsio_knob_stop_telemetry(torsio_knob* knob);

/// The newest sample that has arrived; it can still be read. Waits only for the very first.
/// @param item_size sizeof(torsio_telemetry_sample)
TORSIO_API torsio_result torsio_knob_latest(torsio_knob* knob, torsio_telemetry_sample* sample,
                                            size_t item_size);
/// Takes samples, oldest first; waits until there is one or the time is over.
/// @param count how many were written; 0 if none came in time
TORSIO_API torsio_result torsio_knob_read(torsio_knob* knob, torsio_telemetry_sample* samples,
                                          size_t capacity, size_t item_size, double timeout_s,
                                          size_t* count);

/// Lets `duration_s` pass and keeps every sample of that span. Starts telemetry if it does not run,
/// or if a rate is given.
/// @param rate_hz         as for torsio_knob_start_telemetry(); 0: as it runs
/// @param must_stay_armed return TORSIO_DISARMED when the torque goes meanwhile
/// @param recording       to be freed; if it ends early it has what came until then. As it was
///                        after TORSIO_INVALID_ARGUMENT
TORSIO_API torsio_result torsio_knob_record(torsio_knob* knob, double duration_s, double rate_hz,
                                            bool must_stay_armed, torsio_recording** recording);
/// Its samples, for as long as it lives; each has sizeof(torsio_telemetry_sample) bytes. NULL if
/// there are none.
TORSIO_API const torsio_telemetry_sample* torsio_recording_samples(
    const torsio_recording* recording);
TORSIO_API size_t torsio_recording_count(const torsio_recording* recording);
/// True, and how in `disarm`, which may be NULL, if the torque went meanwhile.
TORSIO_API bool torsio_recording_was_disarmed(const torsio_recording* recording,
                                              torsio_disarm* disarm);
TORSIO_API void torsio_recording_free(torsio_recording* recording);  ///< NULL is ignored

// Waiting ----------------------------------------------------------------------------------------

TORSIO_API torsio_result torsio_knob_sleep(torsio_knob* knob, double duration_s);
/// Waits until the device is in a torsio_state. TORSIO_TIMEOUT if it is not so in time.
TORSIO_API torsio_result torsio_knob_wait_for(torsio_knob* knob, int32_t state, double timeout_s);

/// Makes steps of a program's own loop, every `period_s`, 0.0001 to 3600. Free them before the
/// knob.
TORSIO_API torsio_result torsio_knob_every(torsio_knob* knob, double period_s,
                                           torsio_steps** steps);
/// Waits for the next step; one that is late by a whole period or more is left out and counted.
/// @param time_s     when it was due, since the loop began; may be NULL
/// @param late_steps how many were left out so far; may be NULL
TORSIO_API torsio_result torsio_steps_wait(torsio_steps* steps, double* time_s,
                                           uint64_t* late_steps);
TORSIO_API void torsio_steps_free(torsio_steps* steps);  ///< NULL is ignored

// The world round an emulated knob; with any other these are TORSIO_ERROR ------------------------

TORSIO_API torsio_result torsio_emulator_release_knob(torsio_knob* knob);  ///< nobody touches it
/// Give the knob to a hand; it takes over at the next tick, which is time 0 of its profiles.
TORSIO_API torsio_result torsio_emulator_set_torque_hand(torsio_knob* knob,
                                                         const torsio_torque_hand* hand);
TORSIO_API torsio_result torsio_emulator_set_impedance_hand(torsio_knob* knob,
                                                            const torsio_impedance_hand* hand);
TORSIO_API torsio_result
torsio_emulator_set_prescribed_motion(torsio_knob* knob, const torsio_prescribed_motion* hand);
TORSIO_API torsio_result torsio_emulator_time_s(torsio_knob* knob, double* time_s);
TORSIO_API torsio_result torsio_emulator_advance(torsio_knob* knob, double duration_s);
/// Takes what no sensor sees, a sample a tick, oldest first; the rest stays for the next call.
/// @param item_size sizeof(torsio_truth_sample)
TORSIO_API torsio_result torsio_emulator_truth(torsio_knob* knob, torsio_truth_sample* samples,
                                               size_t capacity, size_t item_size, size_t* count);
/// True electric values, now. TORSIO_ERROR unless the plant has electrics.
TORSIO_API torsio_result torsio_emulator_electrics(torsio_knob* knob,
                                                   torsio_electrics_state* state);
/// Pulls the plug. As with hardware the knob must be opened again.
/// @param after_s of the knob's time from now on, to the millisecond; 0 is at once
TORSIO_API torsio_result torsio_emulator_unplug(torsio_knob* knob, double after_s);
TORSIO_API torsio_result torsio_emulator_set_emergency_stop(torsio_knob* knob, bool pressed);
TORSIO_API torsio_result torsio_emulator_set_actuator_fault(torsio_knob* knob, bool present);
/// State of the current sensor from now on, a torsio_current_sensor_state. TORSIO_ERROR unless the
/// plant has electrics.
TORSIO_API torsio_result torsio_emulator_set_current_sensor(torsio_knob* knob, int32_t state);
/// The supply gives that many volts from now on, 0 to 1000. TORSIO_ERROR unless the plant has
/// electrics.
TORSIO_API torsio_result torsio_emulator_set_supply(torsio_knob* knob, double supply_v);
/// The encoder's counter stands still.
TORSIO_API torsio_result torsio_emulator_freeze_encoder(torsio_knob* knob, bool frozen);
/// The encoder's counter is wrong from now on.
TORSIO_API torsio_result torsio_emulator_jump_encoder(torsio_knob* knob, int32_t counts);
/// The control loop comes that many ticks late.
TORSIO_API torsio_result torsio_emulator_skip_ticks(torsio_knob* knob, uint32_t count);
/// Damage to reports on the way, as probabilities per report: lost or changed, to the device
/// (output) and from it (input).
TORSIO_API torsio_result torsio_emulator_set_link_faults(torsio_knob* knob,
                                                         const torsio_link_faults* faults);
/// The next save loses power after so many bytes: the device vanishes.
TORSIO_API torsio_result torsio_emulator_cut_power_in_next_save(torsio_knob* knob,
                                                                uint32_t after_bytes);

// Knobs plugged in and pulled out ----------------------------------------------------------------

/// Begins to watch for knobs. @param include_present report first those that are there already
TORSIO_API torsio_result torsio_watch_new(bool include_present, torsio_watch** watch);
/// Waits for the next event. @param arrived true if the device came, false if it went
/// @param timeout_s TORSIO_TIMEOUT if nothing happens so long
TORSIO_API torsio_result torsio_watch_next(torsio_watch* watch, double timeout_s, bool* arrived,
                                           torsio_listed_device* device, size_t item_size);
TORSIO_API void torsio_watch_free(torsio_watch* watch);  ///< ends it; NULL is ignored

#ifdef __cplusplus
}
#endif

#endif
