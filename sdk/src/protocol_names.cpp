#include "protocol_names.hpp"

#include <array>
#include <cstdio>
#include <type_traits>

#include "protocol/registry.hpp"
#include "torsio/fields.hpp"

namespace torsio {
namespace {

using Statuses = protocol::Enumerators<protocol::Status>;

// In the order of DisarmReason.
constexpr std::array kWhyDisarmed{"by an order",
                                  "because the host was silent for too long",
                                  "because a streamed local model outlived its deadline",
                                  "by a fault:",
                                  "because the game that had it played nothing more",
                                  "because it was unplugged or lost its power",
                                  "for a reason that did not arrive",
                                  "because the time of an excitation was over",
                                  "because an excitation left its bounds of travel or speed",
                                  "because nobody turned the dial any more"};
static_assert(kWhyDisarmed.size() == Names<DisarmReason>::values.size());

std::string format(const char* pattern, unsigned value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), pattern, value);
  return text.data();
}

}  // namespace

std::string status_name(std::uint8_t status) {
  return status < Statuses::names.size() ? std::string(Statuses::names.at(status))
                                         : format("status %u", status);
}

std::string_view status_advice(std::uint8_t status) {
  return status < Statuses::advice.size() ? Statuses::advice.at(status)
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
    names.push_back(bit < protocol::fault::names.size()
                        ? std::string(protocol::fault::names.at(bit))
                        : format("fault bit %u", bit));
  }
  return names;
}

std::string event_kind_name(std::uint8_t kind) {
  using Kinds = protocol::Enumerators<protocol::EventKind>;
  return kind < Kinds::names.size() ? std::string(Kinds::names.at(kind)) : format("event %u", kind);
}

std::string disarm_reason_name(DisarmReason reason) {
  return std::string(Names<DisarmReason>::values.at(static_cast<std::size_t>(reason)));
}

std::string disarm_text(const Disarm& disarm) {
  std::string text = "the device disarmed at tick " + std::to_string(disarm.tick) + " ";
  text += kWhyDisarmed.at(static_cast<std::size_t>(disarm.reason));
  if (disarm.reason != DisarmReason::fault) return text;
  for (const std::string& fault : disarm.faults) text += " " + fault;
  return disarm.faults.empty() ? text + " one that is cleared" : text;
}

std::string hex32(std::uint32_t value) { return format("0x%08x", value); }

}  // namespace torsio
