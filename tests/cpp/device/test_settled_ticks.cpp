// A tick with nothing to decide takes a shorter way. Whether it may must never show: a device that
// takes every chance goes through the same random life as one that is made to decide in every tick.
#include <bit>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::protocol;

namespace {

class Life {
 public:
  explicit Life(unsigned seed) : random_(seed) {
    const ControlConfig config = some_config();
    for (Twin* twin : {&free_, &bound_}) {
      REQUIRE(twin->rig.set(config).ok());
      for (const int type : {test::kConstant, test::kSine, test::kSpring}) {
        const int block = twin->rig.create(type);
        twin->rig.set_effect(block);
        if (type == test::kConstant) twin->rig.constant(block, 20000);
        if (type == test::kSine) twin->rig.periodic(block, 15000, 0, 0, 50);
        if (type == test::kSpring) twin->rig.condition(block, {});
      }
    }
  }

  /// One tick of both. @returns true if they are the same in everything that can be seen
  bool live() {
    happen();
    inputs_.encoder_count += static_cast<std::uint32_t>(speed_);
    inputs_.tick_time_ns = one_in(100) ? 990'000 : 1000 + number(50);  // of 1,000,000
    bound_.rig.device->set_connected(connected_);  // it knows this, but must look
    for (Twin* twin : {&free_, &bound_}) twin->step(inputs_);
    inputs_.missed_ticks = 0;
    const auto health = free_.rig.get<Health>();
    if (health.state == State::fault) ++ticks.fault;
    if (health.owner == Owner::sdk) ++ticks.sdk;
    if (health.owner == Owner::game) ++ticks.game;
    return free_.seen == bound_.seen;
  }

  struct Ticks {
    int fault = 0, sdk = 0, game = 0;
  };
  Ticks ticks;

 private:
  struct Twin {
    test::GameRig rig;
    std::vector<std::uint8_t> seen;

    void step(const device::TickInputs& inputs) {
      seen.clear();
      rig.device->service();
      const device::TickOutputs out = rig.device->tick(inputs);
      see(out.motor_command_nm);
      see(out.brake_command_nm);
      seen.push_back(out.enabled ? 1 : 0);
      if (!out.enabled) REQUIRE((out.motor_command_nm == 0.0F && out.brake_command_nm == 0.0F));
      ReportBytes bytes;
      while (rig.device->next_input(bytes)) see(bytes);
      REQUIRE(rig.device->get_feature(Layout<Health>::id, bytes) == Status::ok);
      see(bytes);
      REQUIRE(rig.device->get_feature(Layout<Clock>::id, bytes) == Status::ok);
      see(bytes);
    }
    void see(float value) {
      const auto bits = std::bit_cast<std::uint32_t>(value);
      for (unsigned shift = 0; shift < 32; shift += 8) {
        seen.push_back(static_cast<std::uint8_t>(bits >> shift));
      }
    }
    void see(const ReportBytes& bytes) { seen.insert(seen.end(), bytes.begin(), bytes.end()); }
  };

  std::uint32_t number(unsigned below) { return static_cast<std::uint32_t>(random_() % below); }
  bool one_in(unsigned n) { return number(n) == 0; }
  float share() { return static_cast<float>(number(1001)) / 1000.0F; }

  ControlConfig some_config() {
    ControlConfig config;
    config.law = static_cast<Law>(number(4));
    config.watchdog_s = 0.02F + 0.1F * share();
    config.passive_ramp_s = one_in(3) ? 0.0F : 0.03F * share();
    config.passive_brake_nm = 0.05F * share();
    config.motor_slew_nm_per_s = one_in(2) ? 0.0F : 20.0F;
    config.speed_limit_rad_s = one_in(2) ? 0.0F : 60.0F;
    config.autonomous = one_in(4) ? Toggle::on : Toggle::off;
    return config;
  }

  template <class Report>
  void send(const Report& report) {
    for (Twin* twin : {&free_, &bound_}) (void)twin->rig.device->receive(encode(report));
  }

  void happen() {
    if (one_in(15)) speed_ = static_cast<int>(number(41)) - 20;
    if (one_in(400)) speed_ *= 8;
    if (one_in(2000)) inputs_.encoder_count += 5000;
    if (one_in(500)) inputs_.missed_ticks = 1 + number(20);
    if (one_in(inputs_.emergency_stop ? 10 : 800)) inputs_.emergency_stop = !inputs_.emergency_stop;
    if (one_in(inputs_.actuator_fault ? 10 : 800)) inputs_.actuator_fault = !inputs_.actuator_fault;
    if (one_in(connected_ ? 600 : 10)) {
      connected_ = !connected_;
      for (Twin* twin : {&free_, &bound_}) twin->rig.device->set_connected(connected_);
    }
    if (one_in(40)) command();
    if (one_in(150)) play_game();
  }

  void command() {
    switch (number(12)) {
      case 0:
      case 1:
      case 2:
        return send(Command{1, 0, Op::arm});
      case 3:
        return send(Command{2, 0, one_in(2) ? Op::disarm : Op::stop});
      case 4:
        return send(Command{3, 0, Op::clear_fault});
      case 5:
        return send(Command{4, 0, one_in(2) ? Op::zero : Op::relax});
      case 6:
        return send(Command{5, 0, Op::keep_alive});
      case 7:
        return send(Stream{6, 0, static_cast<std::uint8_t>(number(4))});
      case 8: {
        LocalModel model{++model_, 0, 0.02F * share(), 1 << 28, share(), 0.001F, 0.02F * share()};
        return send(model);
      }
      case 9: {
        const ControlConfig config = some_config();
        for (Twin* twin : {&free_, &bound_}) (void)twin->rig.device->set_feature(encode(config));
        return;
      }
      default:
        if (one_in(2)) {
          send(Wall{{7, 0, 0}, 0, Side::below, 1.4F * share(), 0.002F});
        } else {
          send(Constant{{7, 0, 0}, 0.1F * share(), {}});
        }
        send(Spring{{8, 0, 1}, 123456789, share(), 0.01F, 0.06F});
        return send(Commit{9, 0, static_cast<std::uint16_t>(number(4))});
    }
  }

  void play_game() {
    const int block = 1 + static_cast<int>(number(3));
    const bool start = one_in(2);
    for (Twin* twin : {&free_, &bound_}) {
      if (start) {
        twin->rig.start(block);
      } else {
        twin->rig.stop(block);
      }
    }
  }

  std::mt19937 random_;
  Twin free_;
  Twin bound_;
  device::TickInputs inputs_;
  int speed_ = 0;
  bool connected_ = true;
  std::uint16_t model_ = 0;
};

}  // namespace

TEST_CASE("a tick that decides nothing does the same as one that looks at everything") {
  Life::Ticks ticks;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    Life life(seed);
    bool same = true;
    int tick = 0;
    for (; tick < 4000 && same; ++tick) same = life.live();
    CAPTURE(tick);
    REQUIRE(same);
    ticks.fault += life.ticks.fault;
    ticks.sdk += life.ticks.sdk;
    ticks.game += life.ticks.game;
  }
  // It was a life.
  CHECK(ticks.fault > 5000);
  CHECK(ticks.sdk > 5000);
  CHECK(ticks.game > 1000);
}
