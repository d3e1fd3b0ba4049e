// torsio.h: the world round an emulated knob.
#include <algorithm>
#include <cstring>

#include "handles.hpp"

namespace {

using torsio::c::from_c;
using torsio::c::guarded;
using torsio::c::need;
using torsio::c::need_array;
using torsio::c::need_sized;

torsio::Emulator& emulator_of(torsio_knob* knob) { return torsio::c::knob_of(knob).emulator(); }

template <class C>
torsio_result give_to(torsio_knob* knob, const C* hand, const char* type) noexcept {
  return guarded([&] {
    const torsio::Hand wanted = from_c(need_sized(hand, "hand", type));
    emulator_of(knob).set_hand(wanted);
  });
}

}  // namespace

torsio_result torsio_emulator_release_knob(torsio_knob* knob) {
  return guarded([&] { emulator_of(knob).set_hand(torsio::NoHand{}); });
}

torsio_result torsio_emulator_set_torque_hand(torsio_knob* knob, const torsio_torque_hand* hand) {
  return give_to(knob, hand, "torsio_torque_hand");
}

torsio_result torsio_emulator_set_impedance_hand(torsio_knob* knob,
                                                 const torsio_impedance_hand* hand) {
  return give_to(knob, hand, "torsio_impedance_hand");
}

torsio_result torsio_emulator_set_prescribed_motion(torsio_knob* knob,
                                                    const torsio_prescribed_motion* hand) {
  return give_to(knob, hand, "torsio_prescribed_motion");
}

torsio_result torsio_emulator_time_s(torsio_knob* knob, double* time_s) {
  return guarded([&] {
    double& known = need(time_s, "time_s");
    known = emulator_of(knob).time_s();
  });
}

torsio_result torsio_emulator_advance(torsio_knob* knob, double duration_s) {
  return guarded([&] { emulator_of(knob).advance(duration_s); });
}

torsio_result torsio_emulator_truth(torsio_knob* knob, torsio_truth_sample* samples,
                                    size_t capacity, size_t item_size, size_t* count) {
  return guarded([&] {
    need_array(samples, capacity, item_size, "samples", "torsio_truth_sample");
    std::size_t& written = need(count, "count");
    torsio::Emulator& emulator = emulator_of(knob);
    const std::lock_guard lock(knob->mutex);
    const std::vector<torsio::TruthSample> taken = emulator.truth();
    knob->truth.insert(knob->truth.end(), taken.begin(), taken.end());
    written = std::min(capacity, knob->truth.size());
    for (std::size_t i = 0; i < written; ++i) {
      std::memcpy(&samples[i], &knob->truth.front(), sizeof samples[i]);
      knob->truth.pop_front();
    }
  });
}

torsio_result torsio_emulator_electrics(torsio_knob* knob, torsio_electrics_state* state) {
  return guarded([&] {
    torsio_electrics_state& known = need_sized(state, "state", "torsio_electrics_state");
    known = torsio::c::to_c(emulator_of(knob).electrics());
  });
}

torsio_result torsio_emulator_set_current_sensor(torsio_knob* knob, int32_t state) {
  return guarded([&] {
    emulator_of(knob).set_current_sensor(
        torsio::c::choice<torsio::CurrentSensorState>(state, "state"));
  });
}

torsio_result torsio_emulator_set_supply(torsio_knob* knob, double supply_v) {
  return guarded([&] { emulator_of(knob).set_supply(supply_v); });
}

torsio_result torsio_emulator_unplug(torsio_knob* knob, double after_s) {
  return guarded([&] { emulator_of(knob).unplug(after_s); });
}

torsio_result torsio_emulator_set_emergency_stop(torsio_knob* knob, bool pressed) {
  return guarded([&] { emulator_of(knob).set_emergency_stop(torsio::c::flag(pressed)); });
}

torsio_result torsio_emulator_set_actuator_fault(torsio_knob* knob, bool present) {
  return guarded([&] { emulator_of(knob).set_actuator_fault(torsio::c::flag(present)); });
}

torsio_result torsio_emulator_freeze_encoder(torsio_knob* knob, bool frozen) {
  return guarded([&] { emulator_of(knob).freeze_encoder(torsio::c::flag(frozen)); });
}

torsio_result torsio_emulator_jump_encoder(torsio_knob* knob, int32_t counts) {
  return guarded([&] { emulator_of(knob).jump_encoder(counts); });
}

torsio_result torsio_emulator_skip_ticks(torsio_knob* knob, uint32_t count) {
  return guarded([&] { emulator_of(knob).skip_ticks(count); });
}

torsio_result torsio_emulator_set_link_faults(torsio_knob* knob, const torsio_link_faults* faults) {
  return guarded([&] {
    const torsio::LinkFaults wanted = from_c(need_sized(faults, "faults", "torsio_link_faults"));
    emulator_of(knob).set_link_faults(wanted);
  });
}

torsio_result torsio_emulator_cut_power_in_next_save(torsio_knob* knob, uint32_t after_bytes) {
  return guarded([&] { emulator_of(knob).cut_power_in_next_save(after_bytes); });
}
