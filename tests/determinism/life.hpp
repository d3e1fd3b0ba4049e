/// @file
/// An emulated knob that lives: random scenes, local models, experiments, games, hands, faults of
/// the cable, of the encoder and of the power stage, noise, saves and power cuts. The same seed
/// lives the same life.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <thread>

#include "emulator/emulated_device.hpp"
#include "emulator/random.hpp"
#include "protocol/codec.hpp"

namespace torsio::test {

namespace wire = protocol;

/// Is told all that comes out of a life.
class Witness {
 public:
  virtual ~Witness() = default;
  virtual void see(const wire::ReportBytes& report) = 0;
  virtual void see_game(std::span<const std::uint8_t> report) = 0;
  virtual void see(const TruthSample& sample) = 0;
};

class Life {
 public:
  /// @param cut  seed of how time is cut; 0: not at all
  /// @param pace times faster than the clock; 0: as fast as it goes
  Life(Witness& witness, std::uint64_t seed, std::uint64_t cut = 0, std::int64_t pace = 0)
      : witness_(witness),
        random_(seed),
        cut_(cut),
        cuts_(cut != 0),
        pace_(pace),
        device_(options(seed)) {
    configure();
    for (const int type : {1, 4, 8, 9, 10, 11}) make_game_effect(static_cast<std::uint8_t>(type));
    command(wire::Op::arm);
  }

  /// From 1 kHz to 20 kHz.
  static std::int64_t period_ns(std::uint64_t seed) {
    constexpr std::array<std::int64_t, 4> periods{1'000'000, 500'000, 100'000, 50'000};
    return periods[seed % periods.size()];
  }

  emulator::EmulatedDevice& device() { return device_; }

  void live(std::int64_t seconds) {
    for (const std::int64_t end_ns = device_.time_ns() + seconds * 1'000'000'000;
         device_.time_ns() < end_ns;) {
      happen();
      pass(1'000'000 + static_cast<std::int64_t>(below(29'000'000)));
      look();
    }
  }

  /// Ends all trouble: plugged in, powered, released, disarmed, without a fault.
  void recover() {
    device_.set_emergency_stop(false);
    device_.set_actuator_fault(false);
    device_.freeze_encoder(false);
    device_.set_powered(true);
    device_.set_plugged(true);
    device_.set_link_faults({});
    device_.set_hand(emulator::NoHand{});
    device_.set_buttons(0);
    pass(20'000'000);
    command(wire::Op::disarm);
    command(wire::Op::clear_fault);
    pass(500'000'000);
    look();
  }

  /// Hands over the reports since the last call.
  void look() {
    wire::ReportBytes report;
    while (device_.read(report)) witness_.see(report);
    for (auto bytes = device_.game_read(); !bytes.empty(); bytes = device_.game_read()) {
      witness_.see_game(bytes);
    }
    for (const TruthSample& sample : device_.take_truth()) witness_.see(sample);
  }

 private:
  static emulator::EmulatedDeviceOptions options(std::uint64_t seed) {
    emulator::EmulatedDeviceOptions options;
    options.seed = seed;
    options.control_period_ns = period_ns(seed);
    options.encoder.noise_counts = seed % 2 == 0 ? 0.3 : 0.0;
    options.log_truth = true;
    return options;
  }

  std::uint64_t below(std::uint64_t limit) { return random_.next() % limit; }
  bool one_in(std::uint64_t n) { return below(n) == 0; }
  /// Within [0, most], in steps that every compiler reads alike.
  double some(double most) { return most * static_cast<double>(below(1025)) / 1024.0; }
  double either(double most) { return one_in(2) ? some(most) : -some(most); }
  float somef(double most) { return static_cast<float>(some(most)); }
  float eitherf(double most) { return static_cast<float>(either(most)); }

  /// Lets time pass, in one call or in many.
  void pass(std::int64_t duration_ns) {
    if (!cuts_ && pace_ == 0) return device_.advance(duration_ns);
    while (duration_ns > 0) {
      const std::int64_t piece = pace_ != 0 ? by_the_clock() : by_chance();
      device_.advance(std::min(piece, duration_ns));
      duration_ns -= piece;
    }
  }

  std::int64_t by_chance() {
    return static_cast<std::int64_t>(
        1 + cut_.next() % static_cast<std::uint64_t>(cut_.next() % 4 == 0 ? 3000 : 5'000'000));
  }

  /// Time since the last call; much at once after a stop of the process.
  std::int64_t by_the_clock() {
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    const auto now = std::chrono::steady_clock::now();
    const std::int64_t passed = std::chrono::nanoseconds(now - last_look_).count();
    last_look_ = now;
    return 1 + passed * pace_;
  }

  template <class Report>
  void send(const Report& report) {
    (void)device_.write(wire::encode(report));
  }
  void command(wire::Op op) { send(wire::Command{1, 0, op}); }

  void configure() {
    wire::ControlConfig control;
    control.law = static_cast<wire::Law>(below(5));
    control.watchdog_s = 0.5F;
    control.motor_slew_nm_per_s = one_in(2) ? 0.0F : 20.0F;
    control.passive_brake_nm = 0.03F;
    (void)device_.set_feature(wire::encode(control));
    wire::GameConfig game;
    game.torque_max_nm = 0.06F;
    (void)device_.set_feature(wire::encode(game));
    send(wire::Stream{1, 0, static_cast<std::uint8_t>(1 + below(20))});
  }

  void happen() {
    command(wire::Op::keep_alive);
    if (one_in(3)) write_effect();
    if (one_in(3)) send(wire::Commit{2, 0, static_cast<std::uint16_t>(random_.next())});
    if (one_in(4)) command(wire::Op::arm);
    if (one_in(20)) command(wire::Op::disarm);
    if (one_in(6)) stream_model();
    if (one_in(5)) take_hold();
    if (one_in(6)) play_game();
    if (one_in(40)) experiment();
    if (one_in(25)) trouble();
  }

  std::int64_t some_angle() { return static_cast<std::int64_t>(below(1ULL << 33U)) - (1LL << 32); }

  void write_effect() {
    const wire::Target target{static_cast<std::uint16_t>(below(65536)), 0,
                              static_cast<std::uint8_t>(below(16))};
    switch (below(13)) {
      case 0:
        return send(wire::Wall{.target = target,
                               .angle_turns_q32 = some_angle(),
                               .side = one_in(2) ? wire::Side::above : wire::Side::below,
                               .stiffness_nm_per_rad = somef(3.0),
                               .damping_nm_s_per_rad = somef(0.001)});
      case 1:
        return send(wire::Spring{.target = target,
                                 .angle_turns_q32 = some_angle(),
                                 .stiffness_nm_per_rad = somef(1.0),
                                 .deadband_rad = somef(0.1)});
      case 2:
        return send(wire::Damper{.target = target, .damping_nm_s_per_rad = somef(0.002)});
      case 3:
        return send(wire::Friction{.target = target, .torque_nm = somef(0.03)});
      case 4:
        return send(wire::Inertia{.target = target, .inertia_kg_m2 = somef(2e-5)});
      case 5:
        return send(wire::Constant{.target = target, .torque_nm = eitherf(0.03), .timing = {}});
      case 6:
        return send(wire::Ramp{.target = target,
                               .end_torque_nm = eitherf(0.03),
                               .timing = {.duration_s = 0.01F + somef(1.0)}});
      case 7:
        return send(wire::Periodic{.target = target,
                                   .waveform = static_cast<wire::Waveform>(below(5)),
                                   .amplitude_nm = somef(0.03),
                                   .frequency_hz = somef(200.0),
                                   .timing = {}});
      case 8:
        return send(wire::Detents{.target = target,
                                  .per_turn_q32 = (1 + below(60)) << 32U,
                                  .torque_nm = somef(0.03),
                                  .profile = static_cast<wire::DetentProfile>(below(3))});
      case 9:
        return send(wire::EndStops{.target = target,
                                   .lower_turns_q32 = -(1LL << 32),
                                   .upper_turns_q32 = 1LL << 32,
                                   .stiffness_nm_per_rad = somef(3.0)});
      case 10:
        return send(wire::Impact{.target = target,
                                 .strength_nm_s_per_rad = somef(0.05),
                                 .frequency_hz = 30.0F + somef(470.0),
                                 .pulse_nm_s_per_rad = somef(0.05)});
      case 11: {
        wire::Texture texture;
        texture.target = target;
        texture.grain = static_cast<wire::Grain>(below(4));
        texture.torque_nm = somef(0.02);
        texture.seed = static_cast<std::uint32_t>(random_.next());
        return send(texture);
      }
      default: {
        wire::CurvePoints points{1, 0, 0, 13, {}};
        for (float& torque_nm : points.torque_nm) torque_nm = eitherf(0.03);
        send(points);
        wire::Curve curve;
        curve.target = target;
        curve.points = 13;
        curve.ends = one_in(2) ? wire::Ends::repeat : wire::Ends::hold;
        return send(curve);
      }
    }
  }

  void stream_model() {
    wire::LocalModel model;
    model.sequence = ++model_;
    model.torque_nm = eitherf(0.02);
    model.angle_turns_q32 = some_angle();
    model.stiffness_nm_per_rad = somef(0.5);
    model.damping_nm_s_per_rad = somef(0.001);
    model.deadline_s = one_in(3) ? 0.0F : 0.05F + somef(0.2);
    send(model);
  }

  void experiment() {
    wire::Excitation excitation;
    excitation.duration_s = 0.01F + somef(0.2);
    excitation.travel_rad = 0.05F + somef(2.0);
    excitation.speed_limit_rad_s = 5.0F + somef(50.0);
    excitation.torque_limit_nm = somef(0.05);
    excitation.motor_command_nm = eitherf(0.04);
    excitation.brake_command_nm = somef(0.05);
    excitation.ramp_s = somef(0.02);
    excitation.sine_nm = somef(0.02);
    excitation.sine_begin_hz = somef(20.0);
    excitation.sine_end_hz = somef(300.0);
    excitation.stiffness_nm_per_rad = somef(0.2);
    send(excitation);
  }

  void take_hold() {
    const std::int64_t now_ns = device_.next_tick_ns();
    const std::int64_t end_ns = now_ns + 1'000'000 + static_cast<std::int64_t>(below(300'000'000));
    const double angle_rad = device_.plant().state().knob_angle_rad();
    switch (below(4)) {
      case 0:
        return device_.set_hand(emulator::NoHand{});
      case 1:
        return device_.set_hand(emulator::TorqueHand{
            emulator::Profile({{now_ns, either(0.05)}, {end_ns, either(0.05)}})});
      case 2:
        return device_.set_hand(emulator::ImpedanceHand{
            .inertia_kg_m2 = some(2e-4),
            .stiffness_nm_per_rad = 0.5 + some(3.0),
            .damping_nm_s_per_rad = some(0.03),
            .intended_angle_rad =
                emulator::Profile({{now_ns, angle_rad}, {end_ns, angle_rad + either(3.0)}})});
      default:
        return device_.set_hand(emulator::PrescribedMotion{
            emulator::Profile({{now_ns, angle_rad}, {end_ns, angle_rad + either(1.0)}})});
    }
  }

  void make_game_effect(std::uint8_t type) {
    const std::array<std::uint8_t, 4> create{0x21, type, 0, 0};
    (void)device_.game_set_feature(create);
    const auto block = static_cast<std::uint8_t>(++blocks_);
    // Endless, full gain, from the left.
    const std::array<std::uint8_t, 18> effect{0x11, block, type, 0xFF, 0xFF, 0,    0, 0, 0,
                                              0xFF, 0x7F,  0,    2,    0xFF, 0x5F, 0, 0, 0};
    (void)device_.game_write(effect);
  }

  void play_game() {
    const auto level = [this] { return static_cast<std::uint8_t>(below(128)); };
    const std::array<std::uint8_t, 4> constant{0x15, 1, 0, level()};
    (void)device_.game_write(constant);
    const std::array<std::uint8_t, 10> sine{0x14, 2, 0, level(), 0, 0, 0, 0, 40, 0};
    (void)device_.game_write(sine);
    const std::array<std::uint8_t, 15> condition{0x13,    static_cast<std::uint8_t>(3 + below(4)),
                                                 0,       0,
                                                 0,       0xFF,
                                                 level(), 0xFF,
                                                 level(), 0xFF,
                                                 0x7F,    0xFF,
                                                 0x7F,    0,
                                                 0};
    (void)device_.game_write(condition);
    const std::array<std::uint8_t, 4> operate{0x1A, static_cast<std::uint8_t>(1 + below(6)),
                                              static_cast<std::uint8_t>(1 + below(3)), 1};
    (void)device_.game_write(operate);
    device_.set_buttons(static_cast<std::uint8_t>(below(4)));
  }

  /// Something goes wrong, and a little later it is right again.
  void trouble() {
    switch (below(9)) {
      case 0:
        device_.set_emergency_stop(true);
        pass(5'000'000);
        device_.set_emergency_stop(false);
        break;
      case 1:
        device_.set_actuator_fault(true);
        pass(2'000'000);
        device_.set_actuator_fault(false);
        break;
      case 2:
        device_.jump_encoder(static_cast<std::int32_t>(below(6000)) - 3000);
        break;
      case 3:
        device_.skip_ticks(static_cast<std::uint32_t>(below(30)));
        break;
      case 4:
        device_.set_plugged(false);
        pass(70'000'000);
        device_.set_plugged(true);
        break;
      case 5:
        device_.set_link_faults({some(0.1), some(0.1), some(0.1), some(0.1)});
        break;
      case 6:
        command(wire::Op::disarm);
        command(wire::Op::save);
        if (one_in(2)) device_.cut_power_in_next_save(below(300));
        break;
      case 7:
        device_.set_powered(false);
        pass(30'000'000);
        device_.set_powered(true);
        break;
      default:
        device_.freeze_encoder(one_in(2));
        return;
    }
    pass(5'000'000);
    if (!device_.connected()) device_.set_powered(true);
    command(wire::Op::clear_fault);
    configure();
    command(wire::Op::arm);
  }

  Witness& witness_;
  emulator::Random random_;
  emulator::Random cut_;
  bool cuts_;
  std::int64_t pace_;
  std::chrono::steady_clock::time_point last_look_ = std::chrono::steady_clock::now();
  emulator::EmulatedDevice device_;
  std::uint16_t model_ = 0;
  int blocks_ = 0;
};

}  // namespace torsio::test
