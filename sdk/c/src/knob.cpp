// torsio.h: find a knob, open it, play on it, record it.
#include <algorithm>
#include <span>

#include "handles.hpp"

namespace {

using torsio::c::guarded;
using torsio::c::knob_of;
using torsio::c::need;
using torsio::c::need_array;
using torsio::c::need_sized;

/// Calls a member that gives nothing.
torsio_result call(torsio_knob* knob, void (torsio::Knob::*member)()) noexcept {
  return guarded([&] { (knob_of(knob).*member)(); });
}

std::optional<double> rate(double rate_hz) {
  return rate_hz == 0.0 ? std::nullopt : std::optional(rate_hz);
}

torsio::OpenOptions options_of(const torsio_open_options& from) {
  torsio::OpenOptions to;
  to.command_timeout_s = from.command_timeout_s;
  to.ring_samples = from.ring_samples;
  if (from.emulator != nullptr) {
    to.emulator =
        torsio::c::from_c(need_sized(from.emulator, "emulator", "torsio_emulator_options"));
  }
  return to;
}

/// Fills an array with as many as it takes, and tells how many there are.
template <class C, class Cpp>
void give(const std::vector<Cpp>& from, C* to, std::size_t capacity, std::size_t& count) {
  const std::size_t fitting = std::min(capacity, from.size());
  for (std::size_t i = 0; i < fitting; ++i) to[i] = torsio::c::to_c(from[i]);
  count = from.size();
}

/// C's sample has the same bytes as C++'s; structures.hpp asserts it.
torsio::TelemetrySample* as_cpp(torsio_telemetry_sample* samples) {
  return reinterpret_cast<torsio::TelemetrySample*>(samples);
}

}  // namespace

torsio_result torsio_open_options_init(torsio_open_options* structure) {
  return guarded([&] {
    const torsio::OpenOptions defaults;
    need(structure, "structure") = torsio_open_options{};
    structure->struct_size = sizeof *structure;
    structure->command_timeout_s = defaults.command_timeout_s;
    structure->ring_samples = defaults.ring_samples;
  });
}

torsio_result torsio_list_devices(torsio_listed_device* devices, size_t capacity, size_t item_size,
                                  size_t* count) {
  return guarded([&] {
    need_array(devices, capacity, item_size, "devices", "torsio_listed_device");
    std::size_t& found = need(count, "count");
    give(torsio::list_devices(), devices, capacity, found);
  });
}

torsio_result torsio_knob_open(const char* selector, const torsio_open_options* options,
                               torsio_knob** knob) {
  return guarded([&] {
    torsio_knob*& opened = need(knob, "knob");
    torsio::OpenOptions wanted;
    if (options != nullptr) {
      wanted = options_of(need_sized(options, "options", "torsio_open_options"));
    }
    auto made = std::make_unique<torsio_knob>(
        torsio::Knob::open(selector != nullptr ? selector : "", wanted));
    opened = made.release();
  });
}

torsio_result torsio_start_bootloader(const char* selector) {
  return guarded([&] { torsio::start_bootloader(&need(selector, "selector")); });
}

void torsio_knob_close(torsio_knob* knob) {
  if (knob != nullptr) knob->knob.close();
}

void torsio_knob_free(torsio_knob* knob) { delete knob; }

bool torsio_knob_is_open(const torsio_knob* knob) {
  return knob != nullptr && knob->knob.is_open();
}

bool torsio_knob_is_emulated(const torsio_knob* knob) {
  bool emulated = false;
  const torsio_result result = guarded([&] { emulated = need(knob, "knob").knob.is_emulated(); });
  return result == TORSIO_OK && emulated;
}

torsio_result torsio_knob_info(torsio_knob* knob, torsio_device_info* info) {
  return torsio::c::get(knob, info, "torsio_device_info", &torsio::Knob::info);
}

torsio_result torsio_knob_state(torsio_knob* knob, int32_t* state) {
  return guarded([&] {
    std::int32_t& known = need(state, "state");
    known = static_cast<std::int32_t>(knob_of(knob).state());
  });
}

torsio_result torsio_knob_last_disarm(torsio_knob* knob, torsio_disarm* disarm) {
  return guarded([&] {
    torsio_disarm& known = need_sized(disarm, "the structure to fill in", "torsio_disarm");
    const std::optional<torsio::Disarm> last = knob_of(knob).last_disarm();
    if (!last) throw torsio::Error("the torque has not gone since the knob was opened");
    known = torsio::c::to_c(*last);
  });
}

torsio_result torsio_knob_faults(torsio_knob* knob, uint32_t* faults) {
  return guarded([&] {
    std::uint32_t& known = need(faults, "faults");
    known = torsio::c::fault_bits(knob_of(knob).faults());
  });
}

torsio_result torsio_knob_health(torsio_knob* knob, torsio_health* health) {
  return torsio::c::get(knob, health, "torsio_health", &torsio::Knob::health);
}

torsio_result torsio_knob_energies(torsio_knob* knob, torsio_energies* energies) {
  return torsio::c::get(knob, energies, "torsio_energies", &torsio::Knob::energies);
}

torsio_result torsio_knob_motor_current(torsio_knob* knob, torsio_motor_current* motor_current) {
  return torsio::c::get(knob, motor_current, "torsio_motor_current", &torsio::Knob::motor_current);
}

torsio_result torsio_knob_limits(torsio_knob* knob, torsio_limits* limits) {
  return torsio::c::get(knob, limits, "torsio_limits", &torsio::Knob::limits);
}

torsio_result torsio_knob_clock(torsio_knob* knob, torsio_clock* clock) {
  return torsio::c::get(knob, clock, "torsio_clock", &torsio::Knob::clock);
}

torsio_result torsio_knob_position_rad(torsio_knob* knob, double* position_rad) {
  return guarded([&] {
    double& known = need(position_rad, "position_rad");
    known = knob_of(knob).position_rad();
  });
}

torsio_result torsio_knob_statistics(torsio_knob* knob, torsio_link_statistics* statistics) {
  return torsio::c::get(knob, statistics, "torsio_link_statistics", &torsio::Knob::statistics);
}

torsio_result torsio_knob_stable_stiffness(torsio_knob* knob, torsio_stable_stiffness* stiffness) {
  return torsio::c::get(knob, stiffness, "torsio_stable_stiffness",
                        &torsio::Knob::stable_stiffness);
}

torsio_result torsio_knob_game_status(torsio_knob* knob, torsio_game_status* status) {
  return torsio::c::get(knob, status, "torsio_game_status", &torsio::Knob::game_status);
}

torsio_result torsio_knob_game_effects(torsio_knob* knob, torsio_game_effect* effects,
                                       size_t capacity, size_t item_size, size_t* count) {
  return guarded([&] {
    need_array(effects, capacity, item_size, "effects", "torsio_game_effect");
    std::size_t& found = need(count, "count");
    give(knob_of(knob).game_effects(), effects, capacity, found);
  });
}

torsio_result torsio_knob_arm(torsio_knob* knob) { return call(knob, &torsio::Knob::arm); }
torsio_result torsio_knob_disarm(torsio_knob* knob) { return call(knob, &torsio::Knob::disarm); }
torsio_result torsio_knob_stop(torsio_knob* knob) { return call(knob, &torsio::Knob::stop); }
torsio_result torsio_knob_zero(torsio_knob* knob) { return call(knob, &torsio::Knob::zero); }
torsio_result torsio_knob_relax(torsio_knob* knob) { return call(knob, &torsio::Knob::relax); }
torsio_result torsio_knob_clear_fault(torsio_knob* knob) {
  return call(knob, &torsio::Knob::clear_fault);
}
torsio_result torsio_knob_save(torsio_knob* knob) { return call(knob, &torsio::Knob::save); }
torsio_result torsio_knob_load_defaults(torsio_knob* knob) {
  return call(knob, &torsio::Knob::load_defaults);
}
torsio_result torsio_knob_stop_telemetry(torsio_knob* knob) {
  return call(knob, &torsio::Knob::stop_telemetry);
}

torsio_result torsio_scene_new(torsio_scene** scene) {
  return guarded([&] { need(scene, "scene") = new torsio_scene; });
}

torsio_result torsio_scene_clear(torsio_scene* scene) {
  return guarded([&] { need(scene, "scene").effects.clear(); });
}

size_t torsio_scene_count(const torsio_scene* scene) {
  return scene != nullptr ? scene->effects.size() : 0;
}

void torsio_scene_free(torsio_scene* scene) { delete scene; }

torsio_result torsio_knob_play(torsio_knob* knob, const torsio_scene* scene) {
  return guarded([&] {
    torsio::c::warn("");  // clears an earlier scene's warning
    torsio::c::warn(knob_of(knob).play(need(scene, "scene").effects));
  });
}

torsio_result torsio_knob_excite(torsio_knob* knob, const torsio_excitation* excitation) {
  return guarded([&] {
    knob_of(knob).excite(
        torsio::c::from_c(need_sized(excitation, "excitation", "torsio_excitation")));
  });
}

torsio_result torsio_knob_stream_local_model(torsio_knob* knob, const torsio_local_model* model) {
  return guarded([&] {
    torsio::c::warn("");
    torsio::c::warn(knob_of(knob).stream_local_model(
        torsio::c::from_c(need_sized(model, "model", "torsio_local_model"))));
  });
}

torsio_result torsio_knob_next_event(torsio_knob* knob, double timeout_s, torsio_event* event) {
  return guarded([&] {
    torsio_event& known = need_sized(event, "the structure to fill in", "torsio_event");
    torsio::Knob& own = knob_of(knob);
    const auto take = [&] {
      const std::lock_guard lock(knob->mutex);
      if (knob->events.empty()) return false;
      known = torsio::c::to_c(knob->events.front());
      knob->events.pop_front();
      return true;
    };
    if (take()) return;
    std::vector<torsio::Event> arrived = own.events(timeout_s);
    {
      const std::lock_guard lock(knob->mutex);
      knob->events.insert(knob->events.end(), std::move_iterator(arrived.begin()),
                          std::move_iterator(arrived.end()));
    }
    if (!take()) throw torsio::Timeout("no event came in time");
  });
}

torsio_result torsio_knob_start_telemetry(torsio_knob* knob, double rate_hz, bool prompt,
                                          double* true_rate_hz) {
  return guarded([&] {
    const double is_hz = knob_of(knob).start_telemetry(rate(rate_hz), torsio::c::flag(prompt));
    if (true_rate_hz != nullptr) *true_rate_hz = is_hz;
  });
}

torsio_result torsio_knob_latest(torsio_knob* knob, torsio_telemetry_sample* sample,
                                 size_t item_size) {
  return guarded([&] {
    need_array(sample, 1, item_size, "sample", "torsio_telemetry_sample");
    *as_cpp(sample) = knob_of(knob).latest();
  });
}

torsio_result torsio_knob_read(torsio_knob* knob, torsio_telemetry_sample* samples, size_t capacity,
                               size_t item_size, double timeout_s, size_t* count) {
  return guarded([&] {
    need_array(samples, capacity, item_size, "samples", "torsio_telemetry_sample");
    std::size_t& written = need(count, "count");
    written = knob_of(knob).read(std::span(as_cpp(samples), capacity), timeout_s);
  });
}

torsio_result torsio_knob_record(torsio_knob* knob, double duration_s, double rate_hz,
                                 bool must_stay_armed, torsio_recording** recording) {
  return guarded([&] {
    torsio_recording*& made = need(recording, "recording");
    torsio::Knob& own = knob_of(knob);
    auto kept = std::make_unique<torsio_recording>();
    try {
      own.record(kept->samples, duration_s, rate(rate_hz), torsio::c::flag(must_stay_armed));
    } catch (const torsio::InvalidArgument&) {
      throw;  // before anything was done
    } catch (...) {
      made = kept.release();  // the caller gets the samples so far
      throw;
    }
    made = kept.release();
  });
}

const torsio_telemetry_sample* torsio_recording_samples(const torsio_recording* recording) {
  if (recording == nullptr || recording->samples.empty()) return nullptr;
  return reinterpret_cast<const torsio_telemetry_sample*>(recording->samples.data());
}

size_t torsio_recording_count(const torsio_recording* recording) {
  return recording != nullptr ? recording->samples.size() : 0;
}

bool torsio_recording_was_disarmed(const torsio_recording* recording, torsio_disarm* disarm) {
  if (recording == nullptr || !recording->samples.disarmed) return false;
  if (disarm != nullptr) *disarm = torsio::c::to_c(*recording->samples.disarmed);
  return true;
}

void torsio_recording_free(torsio_recording* recording) { delete recording; }

torsio_result torsio_knob_sleep(torsio_knob* knob, double duration_s) {
  return guarded([&] { knob_of(knob).sleep(duration_s); });
}

torsio_result torsio_knob_wait_for(torsio_knob* knob, int32_t state, double timeout_s) {
  return guarded([&] {
    if (!knob_of(knob).wait_for(torsio::c::choice<torsio::State>(state, "state"), timeout_s)) {
      throw torsio::Timeout(std::string("the device was not ") + torsio_state_name(state) +
                            " in time");
    }
  });
}

torsio_result torsio_knob_every(torsio_knob* knob, double period_s, torsio_steps** steps) {
  return guarded([&] {
    torsio_steps*& made = need(steps, "steps");
    made = new torsio_steps{knob_of(knob).every(period_s)};
  });
}

torsio_result torsio_steps_wait(torsio_steps* steps, double* time_s, uint64_t* late_steps) {
  return guarded([&] {
    const torsio::Step step = need(steps, "steps").steps.wait();
    if (time_s != nullptr) *time_s = step.time_s;
    if (late_steps != nullptr) *late_steps = step.late_steps;
  });
}

void torsio_steps_free(torsio_steps* steps) { delete steps; }

torsio_result torsio_watch_new(bool include_present, torsio_watch** watch) {
  return guarded([&] {
    torsio_watch*& made = need(watch, "watch");
    // A DeviceWatch cannot be moved.
    made = new torsio_watch{torsio::DeviceWatch(
        torsio::WatchOptions{.include_present = torsio::c::flag(include_present)})};
  });
}

torsio_result torsio_watch_next(torsio_watch* watch, double timeout_s, bool* arrived,
                                torsio_listed_device* device, size_t item_size) {
  return guarded([&] {
    need_array(device, 1, item_size, "device", "torsio_listed_device");
    bool& came = need(arrived, "arrived");
    const auto event = need(watch, "watch").watch.next(timeout_s);
    if (!event) throw torsio::Timeout("no knob came or went in time");
    came = event->kind == torsio::DeviceEvent::Kind::arrived;
    *device = torsio::c::to_c(event->device);
  });
}

void torsio_watch_free(torsio_watch* watch) { delete watch; }
