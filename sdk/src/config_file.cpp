// A configuration as JSON: as much of it as there is in one, two objects deep, with plain names.
#include "torsio/config_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "conversion/config_kinds.hpp"
#include "conversion/field_check.hpp"
#include "torsio/error.hpp"
#include "torsio/fields.hpp"

namespace torsio {
namespace {

// Writing --------------------------------------------------------------------------------------

template <class T>
std::string value_text(const T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_enum_v<T>) {
    return '"' + std::string(Names<T>::values[static_cast<std::size_t>(value)]) + '"';
  } else if constexpr (std::is_integral_v<T>) {
    return std::to_string(value);
  } else {
    std::string text = number_text(value, 0);
    // Also where it is whole it is no integer.
    if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
    return text;
  }
}

template <class Config>
std::string fields_text(const Config& config) {
  std::string text;
  Fields<Config>::apply([&](const auto&... field) {
    ((text += (text.empty() ? "    \"" : ",\n    \"") + std::string(field.name) +
              "\": " + value_text(config.*field.member)),
     ...);
  });
  return text;
}

// Reading --------------------------------------------------------------------------------------

using ConfigScalar = std::variant<bool, double, std::string>;

struct ConfigMember {
  std::string name;
  ConfigScalar value;
};

struct ConfigPart {
  std::string name;
  std::vector<ConfigMember> members;
};

class ConfigReader {
 public:
  explicit ConfigReader(std::string_view text) : whole_(text), text_(text) {
    take("\xEF\xBB\xBF");  // as Notepad begins
  }

  std::vector<ConfigPart> read() {
    std::vector<ConfigPart> parts;
    each_member([&](std::string name) {
      ConfigPart part{std::move(name), {}};
      each_member([&](std::string field) { part.members.push_back({std::move(field), scalar()}); });
      parts.push_back(std::move(part));
    });
    skip();
    if (!text_.empty()) fail();
    return parts;
  }

 private:
  [[noreturn]] void fail() const {
    const auto* const at = whole_.data() + (whole_.size() - text_.size());
    throw InvalidArgument("line " + std::to_string(1 + std::count(whole_.data(), at, '\n')) +
                          " is no text of dump_config() or `torsio config dump`");
  }

  void skip() { text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size())); }

  bool take(std::string_view word) {
    skip();
    if (!text_.starts_with(word)) return false;
    text_.remove_prefix(word.size());
    return true;
  }

  void expect(std::string_view word) {
    if (!take(word)) fail();
  }

  /// An object: `read` reads the value of each name.
  template <class Read>
  void each_member(Read&& read) {
    expect("{");
    if (take("}")) return;
    do {
      std::string name = word();
      expect(":");
      read(std::move(name));
    } while (take(","));
    expect("}");
  }

  std::string word() {
    expect("\"");
    const std::size_t end = text_.find_first_of("\"\\\n");
    if (end == std::string_view::npos || text_[end] != '"') fail();
    std::string found(text_.substr(0, end));
    text_.remove_prefix(end + 1);
    return found;
  }

  ConfigScalar scalar() {
    if (take("true")) return true;
    if (take("false")) return false;
    if (!text_.empty() && text_.front() == '"') return word();
    // Not what from_chars() takes beside numbers: "inf" and "nan".
    const std::size_t digit = text_.starts_with('-') ? 1 : 0;
    if (text_.size() <= digit || text_[digit] < '0' || text_[digit] > '9') fail();
    double value = 0.0;
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (error != std::errc()) fail();
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return value;
  }

  std::string_view whole_;
  std::string_view text_;  // what is left
};

[[noreturn]] void must_take(std::string_view name, std::string_view takes) {
  throw InvalidArgument(std::string(name) + " takes " + std::string(takes));
}

template <class T>
T enumerator_of(std::string_view name, const ConfigScalar& given) {
  const auto& values = Names<T>::values;
  const auto* word = std::get_if<std::string>(&given);
  const auto found = word ? std::find(values.begin(), values.end(), *word) : values.end();
  if (found != values.end()) return static_cast<T>(found - values.begin());
  std::string known;
  for (const std::string_view each : values) {
    known += (known.empty() ? "one of " : ", ") + std::string(each);
  }
  must_take(name, known);
}

template <class T>
void assign_field(std::string_view name, const ConfigScalar& given, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    if (!std::holds_alternative<bool>(given)) must_take(name, "true or false");
    value = std::get<bool>(given);
  } else if constexpr (std::is_enum_v<T>) {
    value = enumerator_of<T>(name, given);
  } else {
    const auto* number = std::get_if<double>(&given);
    if (!number) must_take(name, "a number");
    if constexpr (std::is_integral_v<T>) {
      // configure() checks ranges; this keeps the written number.
      if (std::trunc(*number) != *number ||
          *number > static_cast<double>(std::numeric_limits<T>::max()) ||
          *number < static_cast<double>(std::numeric_limits<T>::min())) {
        must_take(name, "a whole number");
      }
    }
    value = static_cast<T>(*number);
  }
}

template <class Config>
void assign_fields(const ConfigPart& part, Config& config) {
  for (const ConfigMember& member : part.members) {
    bool known = false;
    Fields<Config>::apply([&](const auto&... field) {
      ((field.name == member.name
            ? (assign_field(field.name, member.value, config.*field.member), known = true)
            : false),
       ...);
    });
    if (!known) throw InvalidArgument(part.name + " has no field '" + member.name + "'");
  }
}

void throw_if_unknown(const std::vector<ConfigPart>& parts) {
  for (const ConfigPart& part : parts) {
    const bool known = std::apply(
        [&](const auto&... kind) { return ((kind.name == part.name) || ...); }, kConfigKinds);
    if (!known) throw InvalidArgument("there is no configuration '" + part.name + "'");
  }
}

/// For what must go on, and throws something else already.
void try_to(const std::function<void()>& act) {
  try {
    act();
  } catch (...) {  // NOLINT(bugprone-empty-catch): the first fault is the one that is told
  }
}

}  // namespace

std::string dump_config(Knob& knob) {
  std::string text;
  std::apply(
      [&](const auto&... kind) {
        ((text += (text.empty() ? "{\n  \"" : ",\n  \"") + std::string(kind.name) + "\": {\n" +
                  fields_text((knob.*kind.get)()) + "\n  }"),
         ...);
      },
      kConfigKinds);
  return text + "\n}\n";
}

void load_config(Knob& knob, std::string_view text) {
  std::vector<std::function<void()>> changes;
  std::vector<std::function<void()>> undo;
  const std::vector<ConfigPart> parts = ConfigReader(text).read();
  throw_if_unknown(parts);
  const auto add = [&](const auto& before, const auto& after) {
    changes.emplace_back([&knob, after] { knob.configure(after); });
    undo.emplace_back([&knob, before] { knob.configure(before); });
  };
  std::function<void()> add_last = [] {};
  // In their own order, not the file's: a value that depends on others comes behind them.
  const auto prepare = [&](const auto& kind) {
    auto before = (knob.*kind.get)();
    auto after = before;
    bool named = false;
    for (const ConfigPart& part : parts) {
      if (part.name != kind.name) continue;
      named = true;
      assign_fields(part, after);
    }
    if (!named) return;
    if constexpr (std::is_same_v<decltype(after), ActuatorConfig>) {
      // It may change places with a pin of the board. So it comes later, and is unset until then.
      if (before.encoder_index_pin != after.encoder_index_pin) {
        add_last = [&add, before, after] { add(before, after); };
        before.encoder_index_pin = after.encoder_index_pin = 0;
      }
    }
    add(before, after);
  };
  std::apply([&](const auto&... kind) { (prepare(kind), ...); }, kConfigKinds);
  add_last();
  if (knob.health().owner != Owner::none) {
    throw Refused("somebody has the actuator: end it, and set it again", "not_disarmed", "command",
                  "");
  }
  try {
    for (const auto& change : changes) change();
  } catch (...) {
    // All: the knob may have taken the one that threw before the program was interrupted.
    for (const auto& step : undo) try_to(step);
    throw;
  }
  knob.save();
}

}  // namespace torsio
