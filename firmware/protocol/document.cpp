// Writes docs/protocol.md from the field lists to standard output.
#include <cstdio>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>

#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

namespace {

using namespace torsio::protocol;

constexpr const char* kIntroduction = R"(# Protocol

This page is generated from the field lists in `firmware/protocol/` by the program
`torsio_protocol_doc`; do not edit it. `./dev docs` writes it anew.

Torsio talks HID. A report is 64 bytes: its id, its fields without gaps in little-endian order, and
zeros. Floats are IEEE 754 binary32. Angles that may lie many turns away are 64-bit integers in units
of 2^-32 turn. Torques are torques on the knob, positive along positive angle.

- **Output** reports go from the host to the device, **input** reports come back, **feature** reports
  are asked for, and some of them set, by control requests.
- The device checks every report before it looks at what it means: length, padding, finite numbers,
  ranges, then the fields against each other. What fails changes nothing.
- Every output report and every setting of a feature report is answered by an `acknowledgement` with
  its sequence number, except `keep_alive` commands and accepted `local_model` reports, of which there
  may be a thousand in a second.
- Both sides compute a fingerprint over the ids, names and types of all reports. The host compares it
  with the one in `identity` and goes no further if they differ. The first two fields of `identity`
  are the same in every version.
- A scene is written effect by effect into slots, then committed: the whole change takes effect
  between two ticks of the control loop.
- While it is armed the device wants to hear from the host within `watchdog_s` of `control_config`.
  If it does not, or if a `local_model` outlives its deadline, it *fails passive*: the motor goes to
  zero in `passive_ramp_s`, the brake holds `passive_brake_nm` meanwhile, then the device is disarmed.
)";

constexpr std::array<const char*, 17> kStatusDocs{
    "accepted",
    "not exactly 64 bytes",
    "bytes behind the last field are not zero",
    "no report of this id in this direction",
    "a number is not finite",
    "a value is outside the range given below, or beyond what this encoder or rate can do",
    "the fields do not fit each other",
    "the device has no such axis",
    "a commit names a slot that was never written",
    "only while armed",
    "only while disarmed",
    "a fault must be cleared first",
    "the cause of the fault is still there",
    "older than what the device already has",
    "cannot be taken now; try again",
    "somebody else owns the actuator",
    "this board cannot do it",
};
constexpr std::array<const char*, 17> kStatusNames{
    "ok",           "bad_length",    "bad_padding",    "unknown_report", "not_finite",
    "out_of_range", "inconsistent",  "bad_axis",       "empty_slot",     "not_armed",
    "not_disarmed", "fault_latched", "fault_persists", "stale",          "busy",
    "not_owner",    "unsupported"};
static_assert(static_cast<std::size_t>(Status::unsupported) + 1 == kStatusNames.size());

std::string text(std::string_view view) { return std::string(view); }

std::string hex(unsigned value, int digits) {
  char buffer[16];
  std::snprintf(buffer, sizeof buffer, "0x%0*X", digits, value);
  return buffer;
}

template <class T>
std::string number_text(T value) {
  std::ostringstream out;
  out << +value;
  return out.str();
}

template <class FieldType>
std::string range_text(const FieldType& field) {
  using Value = typename FieldType::Value;
  using Bound = typename FieldType::Bound;
  if constexpr (Enumeration<Value>) {
    std::string choices;
    for (std::size_t i = 0; i < Enumerators<Value>::names.size(); ++i) {
      if (i != 0) choices += ", ";
      choices += std::to_string(i) + " " + text(Enumerators<Value>::names[i]);
    }
    return choices;
  } else {
    if (field.min == std::numeric_limits<Bound>::lowest() &&
        field.max == std::numeric_limits<Bound>::max()) {
      return "any";
    }
    return number_text(field.min) + " to " + number_text(field.max);
  }
}

/// Prints the rows of a structure and returns the offset behind it.
template <class Struct>
std::size_t print_fields(std::ostream& out, std::size_t offset, int& index,
                         const std::string& prefix) {
  const auto one = [&](const auto& field) {
    using Value = typename std::remove_cvref_t<decltype(field)>::Value;
    using Element = typename ArrayTraits<Value>::Element;
    const std::string name = prefix + text(field.name);
    if constexpr (Structure<Value>) {
      offset = print_fields<Value>(out, offset, index, name + ".");
    } else {
      std::string type = text(type_name<Element>());
      if constexpr (Array<Value>) {
        type += "[" + std::to_string(ArrayTraits<Value>::size) + "]";
      }
      std::string range = "see `sample`";
      if constexpr (!Structure<Element>) range = range_text(field);
      out << "| " << index++ << " | " << offset << " | `" << name << "` | " << type << " | "
          << range << " | " << field.unit << " | " << field.doc << " |\n";
      offset += wire_size<Value>();
    }
  };
  std::apply([&](const auto&... field) { (one(field), ...); }, Layout<Struct>::fields);
  return offset;
}

template <class Struct>
void print_table(std::ostream& out, std::size_t offset) {
  out << "\n| # | byte | field | type | range | unit | |\n|--:|--:|---|---|---|---|---|\n";
  int index = 0;
  print_fields<Struct>(out, offset, index, "");
}

void print_bits(std::ostream& out) {
  out << "\n## Bits\n\n"
         "`faults` (latched until `clear_fault`): "
      << hex(fault::emergency_stop, 2) << " emergency stop, " << hex(fault::over_speed, 2)
      << " over-speed, " << hex(fault::encoder, 2) << " encoder jump, " << hex(fault::actuator, 2)
      << " power stage, " << hex(fault::overrun, 2) << " missed or overlong ticks, "
      << hex(fault::numeric, 2)
      << " torque not finite.\n\n`flags` of telemetry: bits 0 and 1 are the state (0 disarmed, 1 "
         "armed, 2 fault), "
      << hex(flag::motor_saturated, 2) << " motor saturated, " << hex(flag::brake_saturated, 2)
      << " brake saturated, " << hex(flag::local_model, 2) << " local model in force, "
      << hex(flag::passive, 2) << " failing passive, " << hex(flag::game, 2)
      << " a game has the actuator.\n";
}

}  // namespace

int main() {
  std::ostream& out = std::cout;
  out << kIntroduction << "\nProtocol version " << protocol_version << ", fingerprint `"
      << hex(fingerprint(), 8) << "`.\n\n## Reports\n\n| id | report | direction | bytes |\n"
      << "|---|---|---|--:|\n";
  constexpr std::array directions{"input", "output", "feature"};
  for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
    using L = Layout<Report>;
    out << "| " << hex(L::id, 2) << " | [" << L::name << "](#" << L::name << ") | "
        << directions[static_cast<std::size_t>(L::direction)] << " | " << 1 + wire_size<Report>()
        << " |\n";
  });
  out << "\n## Status codes\n\n| code | name | meaning |\n|--:|---|---|\n";
  for (std::size_t i = 0; i < kStatusNames.size(); ++i) {
    out << "| " << i << " | `" << kStatusNames[i] << "` | " << kStatusDocs[i] << " |\n";
  }
  print_bits(out);
  out << "\n## Fields\n\n`#` is the index that an acknowledgement names, `byte` counts from the "
         "report's id.\n";
  for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
    out << "\n### " << Layout<Report>::name << "\n\n" << Layout<Report>::doc << '\n';
    print_table<Report>(out, 1);
  });
  out << "\n### sample\n\n" << Layout<Sample>::doc << " Bytes count from the sample's start.\n";
  print_table<Sample>(out, 0);
  return out.good() ? 0 : 1;
}
