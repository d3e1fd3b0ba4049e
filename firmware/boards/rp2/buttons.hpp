/// @file
/// Two buttons, each from a pin to ground.
#pragma once

#include <cstdint>

namespace torsio::boards {

inline constexpr std::uint8_t kFirstButtonPin = 13;  // the second one's is the next
inline constexpr std::uint32_t kButtonPins = 3U << kFirstButtonPin;

class Buttons {
 public:
  /// Contacts bounce, so a change counts when it has lasted.
  /// @param pins the levels of all pins, bit n for GPn
  /// @returns whether pressed() has changed
  bool see(std::uint32_t pins, std::uint32_t now_us) {
    const auto level = static_cast<std::uint8_t>((~pins & kButtonPins) >> kFirstButtonPin);
    if (level != level_) {
      level_ = level;
      since_us_ = now_us;
    }
    if (level_ == pressed_ || now_us - since_us_ < kStillUs) return false;
    pressed_ = level_;
    return true;
  }
  /// Bit 0 is the first button.
  std::uint8_t pressed() const { return pressed_; }

 private:
  static constexpr std::uint32_t kStillUs = 5000;

  std::uint8_t level_ = 0;
  std::uint8_t pressed_ = 0;
  std::uint32_t since_us_ = 0;
};

}  // namespace torsio::boards
