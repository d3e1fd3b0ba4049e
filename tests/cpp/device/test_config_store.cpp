#include <algorithm>
#include <cstdint>
#include <random>
#include <string_view>

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
