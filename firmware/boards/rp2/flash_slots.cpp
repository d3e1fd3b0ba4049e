#include "boards/rp2/flash_slots.hpp"

#include <hardware/flash.h>

#include <algorithm>
#include <cstdint>
#include <span>

namespace torsio::boards {
namespace {

static_assert(device::kSlotSize % FLASH_PAGE_SIZE == 0 && device::kSlotSize <= FLASH_SECTOR_SIZE);

std::uint32_t offset_of(std::uint8_t slot, std::uint8_t pair) {
  return PICO_FLASH_SIZE_BYTES - (2U * pair + 2U - slot) * FLASH_SECTOR_SIZE;
}

/// The bytes in the flash, past the cache.
device::SlotView bytes_of(std::uint8_t slot, std::uint8_t pair) {
  const auto address =
      static_cast<std::uintptr_t>(XIP_NOCACHE_NOALLOC_BASE + offset_of(slot, pair));
  return device::SlotView(reinterpret_cast<const std::uint8_t*>(address), device::kSlotSize);
}

}  // namespace

device::SlotViews slots(std::uint8_t pair) { return {bytes_of(0, pair), bytes_of(1, pair)}; }

bool write_slot(const device::SlotWrite& write, std::uint8_t pair) {
  const std::uint32_t offset = offset_of(write.slot, pair);
  flash_range_erase(offset, FLASH_SECTOR_SIZE);
  flash_range_program(offset, write.bytes.data(), write.bytes.size());
  const auto bytes = bytes_of(write.slot, pair);
  return std::equal(bytes.begin(), bytes.end(), write.bytes.begin());
}

}  // namespace torsio::boards
