#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

#include "device/config_store.hpp"
#include "device/rig.hpp"

using namespace torsio::protocol;
using torsio::device::Config;
using torsio::device::ConfigStore;
using torsio::device::SlotWrite;
using torsio::device::StoredSlots;
using torsio::test::Rig;

namespace {

Config with_beta(float beta) {
  Config config;
  config.control.beta = beta;
  return config;
}

void write(StoredSlots& slots, const SlotWrite& write,
           std::size_t bytes = torsio::device::kSlotSize) {
  std::copy_n(write.bytes.begin(), bytes, slots.slot[write.slot].begin());
}

}  // namespace

TEST_CASE("crc32 gives the check value of the standard") {
  constexpr std::string_view text = "123456789";
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  CHECK(torsio::device::crc32(bytes) == 0xCBF43926U);
}

TEST_CASE("empty flash holds no configuration") {
  CHECK_FALSE(ConfigStore(torsio::device::empty_slots()).loaded());
  CHECK_FALSE(ConfigStore(StoredSlots{}).loaded());
}

TEST_CASE("the newest save wins, slots take turns") {
  StoredSlots slots = torsio::device::empty_slots();
  for (int i = 1; i <= 5; ++i) {
    ConfigStore store(slots);
    const SlotWrite saved = store.prepare(with_beta(0.1F * static_cast<float>(i)));
    CHECK(saved.slot == (i - 1) % 2);
    write(slots, saved);
    const ConfigStore again(slots);
    REQUIRE(again.loaded());
    CHECK(again.loaded()->control.beta == 0.1F * static_cast<float>(i));
    CHECK(again.saves() == static_cast<std::uint32_t>(i));
  }
}

TEST_CASE("a power cut at any byte of a save keeps the old or has the new configuration") {
  // Three ways in which the rest of the slot may look: as it was, erased, or half erased garbage.
  StoredSlots slots = torsio::device::empty_slots();
  write(slots, ConfigStore(slots).prepare(with_beta(0.2F)));
  write(slots, ConfigStore(slots).prepare(with_beta(0.3F)));
  const SlotWrite next = ConfigStore(slots).prepare(with_beta(0.4F));
  std::mt19937 random(7);
  for (int rest = 0; rest < 3; ++rest) {
    for (std::size_t cut = 0; cut <= torsio::device::kSlotSize; ++cut) {
      StoredSlots cut_slots = slots;
      if (rest == 1) cut_slots.slot[next.slot].fill(0xFF);
      if (rest == 2) {
        for (auto& byte : cut_slots.slot[next.slot]) byte = static_cast<std::uint8_t>(random());
      }
      write(cut_slots, next, cut);
      const ConfigStore store(cut_slots);
      REQUIRE(store.loaded());
      const float beta = store.loaded()->control.beta;
      const bool old_or_new = beta == 0.3F || beta == 0.4F;
      REQUIRE(old_or_new);
      if (cut == torsio::device::kSlotSize) CHECK(beta == 0.4F);
    }
  }
}

TEST_CASE("any flipped bit in the newest slot falls back to the older one") {
  StoredSlots slots = torsio::device::empty_slots();
  write(slots, ConfigStore(slots).prepare(with_beta(0.2F)));
  const SlotWrite newest = ConfigStore(slots).prepare(with_beta(0.3F));
  write(slots, newest);
  for (std::size_t bit = 0; bit < 8 * 144; ++bit) {
    StoredSlots damaged = slots;
    damaged.slot[newest.slot][bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    const ConfigStore store(damaged);
    REQUIRE(store.loaded());
    REQUIRE(store.loaded()->control.beta == 0.2F);
  }
}

TEST_CASE("save is acknowledged when the board has written, and survives a power cycle") {
  StoredSlots slots = torsio::device::empty_slots();
  Rig rig({}, slots);
  ControlConfig config;
  config.beta = 0.375F;
  REQUIRE(rig.set(config).ok());
  const std::size_t before = rig.acknowledgements.size();
  REQUIRE(rig.device->receive(encode(Command{42, 0, Op::save})));
  rig.tick(20);
  CHECK(rig.acknowledgements.size() == before);  // not written yet
  const auto pending = rig.device->take_slot_write();
  REQUIRE(pending);
  CHECK_FALSE(rig.device->take_slot_write());
  write(slots, *pending);
  rig.device->storage_written();
  rig.tick(3);
  REQUIRE(rig.acknowledgements.size() == before + 1);
  CHECK(rig.acknowledgements.back().sequence == 42);
  CHECK(rig.get<Health>().saves == 1);

  Rig again({}, slots);
  CHECK(again.get<ControlConfig>().beta == 0.375F);
  CHECK(again.command(Op::load_defaults) == Status::ok);
  CHECK(again.get<ControlConfig>().beta == 0.5F);
}

TEST_CASE("the default lag of the motor is the board's, also where defaults are loaded again") {
  torsio::device::BoardInfo slow;
  slow.motor_lag_s = 0.16e-3F;
  Rig rig(slow);
  CHECK(rig.get<ActuatorConfig>().motor_time_constant_s == 0.16e-3F);
  ActuatorConfig config;
  config.motor_time_constant_s = 1e-3F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.command(Op::load_defaults) == Status::ok);
  CHECK(rig.get<ActuatorConfig>().motor_time_constant_s == 0.16e-3F);
  CHECK(Rig().get<ActuatorConfig>().motor_time_constant_s == 44e-6F);
}

TEST_CASE("save is refused as busy when the board could not write, and may be tried again") {
  Rig rig;
  const auto save = [&](bool works) {
    REQUIRE(rig.device->receive(encode(Command{3, 0, Op::save})));
    rig.tick(2);
    REQUIRE(rig.device->take_slot_write());
    if (works) {
      rig.device->storage_written();
    } else {
      rig.device->storage_failed();
    }
    rig.tick(2);
    return rig.status(rig.acknowledgements.back());
  };
  CHECK(save(false) == Status::busy);
  CHECK(rig.get<Health>().saves == 0);
  CHECK(save(true) == Status::ok);
  CHECK(rig.get<Health>().saves == 1);
}

namespace {

void put_u32(torsio::device::SlotBytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

/// Gives a slot the checksum that its bytes have.
void seal(torsio::device::SlotBytes& bytes) {
  put_u32(bytes, 508, torsio::device::crc32(std::span(bytes).first(508)));
}

}  // namespace

TEST_CASE(
    "a slot with a right checksum counts only with its mark, this layout and values in range") {
  const SlotWrite good = ConfigStore(torsio::device::empty_slots()).prepare(with_beta(0.3F));
  const auto loads = [&](auto change,
                         torsio::device::WiringRule rule = torsio::device::any_wiring) {
    StoredSlots slots = torsio::device::empty_slots();
    slots.slot[0] = good.bytes;
    change(slots.slot[0]);
    seal(slots.slot[0]);
    return ConfigStore(slots, rule).loaded().has_value();
  };
  using Bytes = torsio::device::SlotBytes;
  CHECK(loads([](Bytes&) {}));
  CHECK_FALSE(loads([](Bytes& bytes) { bytes[0] ^= 1; }));                  // the mark "TORS"
  CHECK_FALSE(loads([](Bytes& bytes) { put_u32(bytes, 4, 0x12345678); }));  // another layout
  // Each report begins with its id; a wrong id is refused.
  CHECK_FALSE(loads([](Bytes& bytes) { bytes[20] ^= 1; }));
  const auto never = [](const BoardConfig&, std::uint8_t) {
    return std::optional<torsio::device::PinConflict>(torsio::device::PinConflict{});
  };
  CHECK_FALSE(loads([](Bytes&) {}, never));
}

TEST_CASE("a stored value beyond its range makes its slot none, whichever report it is in") {
  const auto loads = [](auto change) {
    Config config;
    change(config);
    StoredSlots slots = torsio::device::empty_slots();
    slots.slot[0] = ConfigStore(slots).prepare(config).bytes;
    return ConfigStore(slots).loaded().has_value();
  };
  CHECK(loads([](Config&) {}));
  CHECK_FALSE(loads([](Config& c) { c.actuator.motor_torque_max_nm = 1000.0F; }));
  CHECK_FALSE(loads([](Config& c) { c.control.beta = 2.0F; }));
  CHECK_FALSE(loads([](Config& c) { c.board.light_pin = 200; }));
  CHECK_FALSE(loads([](Config& c) { c.game.gain = 100.0F; }));
  CHECK_FALSE(loads([](Config& c) { c.shaft.knee_1_rad = 200.0F; }));
  CHECK_FALSE(loads([](Config& c) { c.calibration.ambient_k = -1.0F; }));
  // In range each, but not together.
  CHECK_FALSE(loads([](Config& c) { c.actuator.brake_torque_min_nm = 0.2F; }));
  CHECK_FALSE(loads([](Config& c) { c.actuator.counter_bits = 8; }));
  CHECK_FALSE(loads([](Config& c) { c.shaft.knee_1_rad = 0.01F; }));
}

TEST_CASE("what a calibration is about is saved with it") {
  using torsio::device::calibration_now;
  using torsio::protocol::Basis;
  Config config;
  config.shaft.knee_1_rad = 0.02F;
  config.shaft.knee_1_nm_per_rad = 5.0F;
  config.calibration.values_are = Basis::measured;
  config.calibration.sigma_knee_1_rad = 1e-4F;
  config.calibrated_values = torsio::device::values_checksum(config);
  StoredSlots slots = torsio::device::empty_slots();
  slots.slot[0] = ConfigStore(slots).prepare(config).bytes;
  const std::optional<Config> loaded = ConfigStore(slots).loaded();
  REQUIRE(loaded);
  CHECK(loaded->calibration.sigma_knee_1_rad == 1e-4F);
  CHECK(calibration_now(*loaded).values_are == Basis::measured);
  Config other = *loaded;
  other.shaft.knee_1_nm_per_rad = 6.0F;
  CHECK(calibration_now(other).values_are == Basis::assumed);
  other = *loaded;
  other.actuator.counts_per_rev = 4096;
  CHECK(calibration_now(other).values_are == Basis::assumed);
  // Torques are measured by these; a pin or a limit is no part of it.
  using torsio::protocol::BoardConfig;
  for (float BoardConfig::* const value :
       {&BoardConfig::supply_v, &BoardConfig::motor_torque_constant_nm_per_a,
        &BoardConfig::motor_resistance_ohm, &BoardConfig::motor_inductance_h,
        &BoardConfig::brake_torque_constant_nm_per_a, &BoardConfig::current_sense_v_per_a}) {
    other = *loaded;
    other.board.*value *= 1.1F;
    CHECK(calibration_now(other).values_are == Basis::assumed);
    other.board.*value = loaded->board.*value;
    CHECK(calibration_now(other).values_are == Basis::measured);
  }
  other = *loaded;
  other.board.motor_current_max_a = 0.5F;
  other.board.light_pin = 3;
  CHECK(calibration_now(other).values_are == Basis::measured);
}

TEST_CASE("the same change of two values that stand at the same place of two reports is seen") {
  Config config;
  config.actuator.spring_stiffness_nm_per_rad = config.shaft.knee_3_nm_per_rad = 2.0F;
  const std::uint32_t before = torsio::device::values_checksum(config);
  config.actuator.spring_stiffness_nm_per_rad = config.shaft.knee_3_nm_per_rad = 3.0F;
  CHECK(torsio::device::values_checksum(config) != before);
}

TEST_CASE("the checksum of the values is the same in every release") {
  Config config;
  ActuatorConfig actuator = config.actuator;
  actuator.encoder_index_pin = 0;
  config.actuator.encoder_index_pin = 5;
  std::vector<std::uint8_t> values;
  const auto add = [&](const auto& bytes, std::size_t from) {
    values.insert(values.end(), bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.end());
  };
  add(encode(actuator), 3);
  add(encode(config.shaft), 3);
  const BoardConfig& board = config.board;
  for (const float value : {board.supply_v, board.motor_torque_constant_nm_per_a,
                            board.motor_resistance_ohm, board.motor_inductance_h,
                            board.brake_torque_constant_nm_per_a, board.current_sense_v_per_a}) {
    add(std::bit_cast<std::array<std::uint8_t, 4>>(value), 0);
  }
  CHECK(torsio::device::values_checksum(config) == torsio::device::crc32(values));
}

TEST_CASE("the newer of two slots is loaded, whichever it is") {
  for (const std::uint8_t newer : {std::uint8_t{0}, std::uint8_t{1}}) {
    StoredSlots slots = torsio::device::empty_slots();
    for (const std::uint8_t slot : {std::uint8_t{0}, std::uint8_t{1}}) {
      slots.slot[slot] =
          ConfigStore(StoredSlots{}).prepare(with_beta(slot == newer ? 0.4F : 0.1F)).bytes;
      put_u32(slots.slot[slot], 8, slot == newer ? 8U : 7U);
      seal(slots.slot[slot]);
    }
    const ConfigStore store(slots);
    REQUIRE(store.loaded());
    CHECK(store.loaded()->control.beta == 0.4F);
    CHECK(store.saves() == 8);
    CHECK(store.prepare({}).slot == 1 - newer);
  }
}

TEST_CASE("saves of one power-up take turns too") {
  ConfigStore store(torsio::device::empty_slots());
  const std::uint8_t first = store.prepare({}).slot;
  store.written();
  CHECK(store.prepare({}).slot == 1 - first);
  store.written();
  CHECK(store.prepare({}).slot == first);
  CHECK(store.saves() == 2);
}

TEST_CASE("a board that says it has written what nobody saved is not believed") {
  Rig rig;
  rig.device->storage_written();
  rig.device->storage_failed();
  rig.tick(3);
  CHECK(rig.acknowledgements.empty());
  CHECK(rig.get<Health>().saves == 0);
}
