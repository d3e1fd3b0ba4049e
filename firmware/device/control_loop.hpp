/// @file
/// The side of the device that lives in the control interrupt: states, faults, watchdog, and the
/// controller between them. The main loop gives it orders through a ring and reads its answers from
/// another, so whatever the host asks takes effect between two ticks, whole.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "core/controller.hpp"
#include "device/config.hpp"
#include "device/guest.hpp"
#include "device/index_watch.hpp"
#include "device/ring.hpp"
#include "device/scene_builder.hpp"
#include "protocol/reports.hpp"

namespace torsio::device {

/// The board's measurements for this tick.
struct TickInputs {
  std::uint32_t encoder_count = 0;
  bool emergency_stop = false;
  bool actuator_fault = false;
  std::uint16_t power_faults = 0;  // with actuator_fault: which, as bits of `faults`; 0: `actuator`
  std::uint32_t missed_ticks = 0;  // since the last tick; they count as time
  std::uint32_t tick_time_ns = 0;  // how long the last tick took; 0: not known
  std::uint32_t step_time_ns = 0;  // and since then the interrupts between two ticks
};

/// The board's orders until the next tick.
struct TickOutputs {
  float motor_command_nm = 0;  // on the knob
  float brake_command_nm = 0;  // capacity, >= 0
  bool enabled = false;        // power stages on
};

/// Something for the control loop to do between two ticks, and to acknowledge.
struct Order {
  enum class Kind : std::uint8_t {
    settled,  // done already, or refused: only say so
    arm,
    disarm,
    stop,
    zero,
    relax,
    clear_fault,
    stream,
    play,
    local_model,
    excite,
    configure,
    keep_alive,
  };

  Kind kind = Kind::settled;
  bool acknowledged = true;
  std::uint8_t report = 0;
  std::uint16_t sequence = 0;
  protocol::Verdict verdict;
  std::uint8_t decimation = 0;         // stream
  SceneBuilder::Commit commit;         // play
  core::LocalModel local_model;        // local_model
  std::uint32_t deadline_ticks = 0;    // local_model; 0 ends it
  core::Excitation excitation;         // excite
  const LoopConfig* config = nullptr;  // configure
  bool clears_scene = false;
};

struct Answer {
  bool is_event = false;
  protocol::Acknowledgement acknowledgement;
  protocol::Event event;
};

struct LoopSample {
  std::uint64_t tick = 0;
  std::int64_t position_counts = 0;
  float speed_rad_s = 0;
  float desired_torque_nm = 0;
  float motor_command_nm = 0;
  float brake_capacity_nm = 0;
  float spring_torque_nm = 0;
  std::uint8_t flags = 0;
  std::uint8_t decimation = 1;
};

struct LoopCounters {
  std::uint32_t reports_accepted = 0;
  std::uint32_t reports_refused = 0;
  std::uint32_t samples_dropped = 0;
  std::uint32_t tick_overruns = 0;
  std::uint32_t tick_time_ns = 0;
  std::uint32_t tick_time_max_ns = 0;
  std::uint32_t zeroings = 0;
  std::uint32_t unexpected_swings = 0;
};

/// State of the control loop that the main loop may read at any time.
struct Snapshot {
  std::uint64_t tick = 0;
  std::int64_t position_counts = 0;
  protocol::State state = protocol::State::disarmed;
  protocol::Owner owner = protocol::Owner::none;
  std::uint16_t faults = 0;
  LoopCounters counters;
  IndexWatch index;
};

/// For the main loop: calls `take(number of this tick)` until no tick came while it read.
/// @param counted the ticks done, counted by the interrupt that writes what `take` reads
template <class Take>
auto between_ticks(const std::uint64_t& counted, Take&& take) {
  for (;;) {
    // Before anything is taken, and once more after everything: without the fences the compiler
    // may look twice at the same moment. A number that was read in two halves
    // does not come twice.
    const std::uint64_t tick = counted;
    std::atomic_signal_fence(std::memory_order_acq_rel);
    const auto copy = take(tick);
    std::atomic_signal_fence(std::memory_order_acq_rel);
    if (counted == tick) return copy;
  }
}

/// How the device stands to torque. docs/explanation/architecture.md has the table of its changes.
enum class Phase : std::uint8_t {
  disarmed,
  fault,
  // Armed from here on.
  rising,  // the scene's torque comes up
  playing,
  // It fades from here on.
  passive,     // for nobody is heard: the motor goes to zero along a line, the brake slows the knob
  letting_go,  // for somebody said so: the motor goes to zero along a line
};

/// Faults that are latched until they are cleared.
struct Faults {
  std::uint16_t latched = 0;
  std::uint16_t present = 0;  // causes that this tick has found so far, or the last one
  bool unpowered = false;     // nobody was armed, and the latched ones may come from missing power

  /// Latched faults go with their causes.
  bool forgives() const { return unpowered && (latched & protocol::fault::supply) != 0; }
  /// @returns whether any of the causes is latched only now
  bool latch(std::uint32_t now, Phase phase);
};

/// What the control loop tells the main loop, and `barred`. Orders have a ring of their own.
struct Mailbox {
  // 0 or 1: nobody may arm. The main loop sets it before it asks whether the device is armed. So
  // the device cannot arm between the question and the act that needs it disarmed.
  std::atomic<std::uint32_t> barred{0};
  Ring<Answer, 16> answers;
  Ring<LoopSample, 64> samples;
};

class ControlLoop {
 public:
  /// @param one_guest for life
  ControlLoop(const LoopConfig& config, Guest& one_guest) : config_(config), guest(one_guest) {
    guest.call_by(attention_);
  }
  ControlLoop(const ControlLoop&) = delete;
  ControlLoop& operator=(const ControlLoop&) = delete;

  // Control interrupt.
  TickOutputs tick(const TickInputs& in);
  /// Speed in the last tick.
  float speed_rad_s() const {
    return controller_.motion.speed_counts_per_tick * config_.controller.motion.speed_scale;
  }
  Phase phase() const { return phase_; }
  /// Whether a periodic effect played in the last tick.
  bool shakes() const { return plan_.scene != nullptr && core::shakes(*plan_.scene); }

  // Main loop.
  Snapshot snapshot() const;
  /// The part of a snapshot that every round needs.
  Moment now() const;
  protocol::Ledger ledger() const;
  /// An order may be given only while none is under way. Then nothing reads the last order's data,
  /// and every answer has its place.
  bool takes_order() const { return orders_.empty(); }
  void give(const Order& order);
  void set_connected(bool connected);
  /// The level of the encoder's index is another from the next tick on, says the interrupt.
  void see_index(bool level);
  bool connected() const { return connected_.load(std::memory_order_relaxed) != 0; }

 private:
  void decide(const TickInputs& in);
  void watch_index();
  void keep_centre();
  void move_origin(std::int64_t counts);
  void watch_time(const TickInputs& in);
  void fall_behind(std::uint32_t missed_ticks);
  bool at_rest() const;
  void take_order();
  void carry_out(const Order& order);
  protocol::Status execute(const Order& order);
  protocol::Status arm();
  protocol::Status zero();
  protocol::Status relax();
  protocol::Status configure(const Order& order);
  core::ForceSource* serve_guest();
  protocol::Status clear_fault();
  protocol::Status follow_local_model(const Order& order);
  protocol::Status excite(const Order& order);
  void end_excitation();
  void watch_host();
  void let_go();
  void begin_passive(protocol::EventKind why);
  bool may_take() const;
  void choose_torque(bool playing, core::ForceSource* guest_force);
  float rise();
  std::uint32_t find_causes(const TickInputs& in, const core::ControllerOutputs& out) const;
  TickOutputs hold_back(std::uint32_t causes, std::uint16_t power_faults);
  TickOutputs fade();
  void change(Phase phase, protocol::Owner owner, std::uint32_t ticks);
  void enter(Phase phase, protocol::Owner owner = protocol::Owner::none, std::uint32_t ticks = 0);
  void report_event(protocol::EventKind kind);
  void sample(float speed_rad_s, float desired_torque_nm, std::uint8_t saturated);

  protocol::State state() const;
  bool armed() const { return phase_ >= Phase::rising; }
  bool fades() const { return phase_ >= Phase::passive; }
  bool overruns() const;
  bool plays() const { return armed() && !fades(); }
  bool streams() const { return local_model_ticks_left_ != 0; }
  /// The next tick must decide anew.
  void call() { attention_.store(1, std::memory_order_release); }  // after the change

  static constexpr std::uint32_t kSample = 1;
  // The controller's commands are not followed: ticks are late, or what it says is not at rest yet
  // while nobody plays. So this may be while the stages are on, and while they are off.
  static constexpr std::uint32_t kHoldBack = 2;

  // Everything that a tick looks at stands together: its loads then need no computed addresses.

  // Not zero: something has changed since the last decision, or goes on changing. Set by both
  // contexts, by the main loop after the change itself; cleared by the interrupt before it looks.
  std::atomic<std::uint32_t> attention_{1};
  std::atomic<std::uint32_t> connected_{1};  // 0 or 1; a bool costs an instruction more
  // The last decision: it holds until the next one.
  core::Plan plan_;
  bool enabled_ = false;     // power stages on
  std::uint32_t after_ = 0;  // what follows the controller: kSample, kHoldBack
  std::uint8_t decimation_ = 0;
  std::uint8_t ticks_to_sample_ = 0;
  // The longest tick so far, but not more than the budget: a longer one is something to decide.
  std::uint32_t usual_tick_ns_ = 0;
  float speed_limit_rad_s_ = std::numeric_limits<float>::infinity();  // of the present scene
  std::uint32_t silent_ticks_left_ = 0;                               // until the watchdog bites

  LoopConfig config_;
  core::ControllerState controller_;
  Phase phase_ = Phase::disarmed;
  protocol::Owner owner_ = protocol::Owner::none;  // none unless armed
  Faults faults_;
  const core::Scene* scene_ = nullptr;

  core::LocalModel local_model_;
  std::uint32_t local_model_ticks_left_ = 0;  // 0: none is streamed; 1: it is late
  std::uint16_t local_model_sequence_ = 0;
  core::ExcitationState excitation_;

  IndexWatch index_;
  bool takes_centre_ = true;            // once the index is found
  std::uint32_t lateness_ = 0;          // points: late ticks cost some, the others earn some back
  std::uint32_t phase_ticks_left_ = 0;  // until what rises or fades has done so
  core::Fade motor_fade_;

  LoopCounters counters_;
  Ring<Order, 2> orders_;

 public:
  Mailbox mail;
  Guest& guest;
};

// Here, so that a round keeps it in registers: a copy in memory would be waited for.
inline Moment ControlLoop::now() const {
  return between_ticks(controller_.tick, [&](std::uint64_t tick) {
    return Moment{tick, controller_.motion.position_counts, counters_.zeroings, owner_};
  });
}

}  // namespace torsio::device
