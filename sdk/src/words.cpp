#include "words.hpp"

#include <array>
#include <cstdio>
#include <type_traits>

#include "protocol/registry.hpp"

namespace torsio {
namespace {

struct StatusWords {
  std::string_view name;
  std::string_view advice;
};

// In the order of protocol::Status.
constexpr std::array kStatusWords{
    StatusWords{"ok", "accepted"},
    StatusWords{"bad_length", "the report has the wrong length; it was damaged on the way"},
    StatusWords{"bad_padding", "the report has bytes too many; it was damaged on the way"},
    StatusWords{"unknown_report", "the device does not know this report"},
    StatusWords{"not_finite", "a value is not a finite number"},
    StatusWords{"out_of_range", "a value is outside the range that docs/protocol.md gives"},
    StatusWords{"inconsistent", "the values do not fit each other"},
    StatusWords{"bad_axis", "the device has no such axis"},
    StatusWords{"empty_slot", "the scene names a slot that was never written"},
    StatusWords{"not_armed", "the device must be armed for this: call arm() first"},
    StatusWords{"not_disarmed", "the device must be disarmed for this: call disarm() first"},
    StatusWords{"fault_latched",
                "a fault is latched: faults() names it, clear_fault() clears it once its cause is "
                "gone"},
    StatusWords{"fault_persists", "the cause of the fault is still there: faults() names it"},
    StatusWords{"stale", "the device already has something newer"},
    StatusWords{"busy", "the device has no room for it now: send it again"},
    StatusWords{"not_owner", "somebody else owns the actuator now"},
    StatusWords{"unsupported", "this board cannot do it"},
};
static_assert(kStatusWords.size() == static_cast<std::size_t>(protocol::Status::unsupported) + 1);

constexpr std::array<std::string_view, 6> kFaultNames{"emergency_stop", "over_speed", "encoder",
                                                      "actuator",       "overrun",    "numeric"};
static_assert(protocol::fault::numeric == 1U << (kFaultNames.size() - 1));

std::string format(const char* pattern, unsigned value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), pattern, value);
  return text.data();
}

}  // namespace

std::string status_name(std::uint8_t status) {
  return status < kStatusWords.size() ? std::string(kStatusWords.at(status).name)
                                      : format("status %u", status);
}

std::string_view status_advice(std::uint8_t status) {
  return status < kStatusWords.size() ? kStatusWords.at(status).advice
                                      : "this version of the library does not know the reason";
}

std::string report_name(std::uint8_t id) {
  std::string_view name;
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    if (protocol::Layout<Report>::id == id) name = protocol::Layout<Report>::name;
  });
  return name.empty() ? format("report 0x%02x", id) : std::string(name);
}

std::string report_field_name(std::uint8_t report_id, std::uint8_t field) {
  std::string_view name;
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    if (protocol::Layout<Report>::id == report_id) name = protocol::field_name<Report>(field);
  });
  return std::string(name);
}

std::vector<std::string> fault_names(std::uint16_t faults) {
  std::vector<std::string> names;
  for (unsigned bit = 0; bit < 16; ++bit) {
    if ((faults >> bit & 1U) == 0) continue;
    names.push_back(bit < kFaultNames.size() ? std::string(kFaultNames.at(bit))
                                             : format("fault bit %u", bit));
  }
  return names;
}

std::string hex32(std::uint32_t value) { return format("0x%08x", value); }

}  // namespace torsio
