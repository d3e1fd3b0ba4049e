// tests/golden/reports.json was made without this code: values by name, and the bytes they must
// give.
#include <doctest/doctest.h>

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

using namespace torsio::protocol;
using nlohmann::json;

namespace {

ReportBytes from_hex(const std::string& text) {
  REQUIRE(text.size() == 2 * report_size);
  ReportBytes bytes{};
  for (std::size_t i = 0; i < report_size; ++i) {
    bytes[i] = static_cast<std::uint8_t>(std::stoul(text.substr(2 * i, 2), nullptr, 16));
  }
  return bytes;
}

// Values by name. It is instantiated for hundreds of fields, so the assertions are elsewhere: they
// would take a minute to compile.
template <class T>
json by_name(const T& value) {
  if constexpr (Structure<T>) {
    json fields = json::object();
    const auto one = [&](const auto& field) {
      fields[std::string(field.name)] = by_name(value.*field.member);
    };
    Layout<T>::fields.apply([&](const auto&... field) { (one(field), ...); });
    return fields;
  } else if constexpr (Array<T>) {
    json elements = json::array();
    for (const auto& element : value) elements.push_back(by_name(element));
    return elements;
  } else if constexpr (Enumeration<T>) {
    return Enumerators<T>::names[static_cast<std::size_t>(value)];
  } else {
    return value;
  }
}

}  // namespace

TEST_CASE("every report's golden bytes decode to the golden values and encode back") {
  std::ifstream file(TORSIO_TEST_DATA_DIR "/reports.json");
  REQUIRE(file.good());
  const json cases = json::parse(file);
  std::set<std::string> seen;
  for (const json& golden : cases) {
    const auto name = golden["report"].get<std::string>();
    CAPTURE(name);
    const ReportBytes bytes = from_hex(golden["hex"].get<std::string>());
    int id = -1;
    Verdict verdict;
    json values;
    ReportBytes encoded_again{};
    for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
      if (Layout<Report>::name != name) return;
      Report report{};
      id = Layout<Report>::id;
      verdict = decode(bytes, report);
      values = by_name(report);
      encoded_again = encode(report);
    });
    seen.insert(name);
    CHECK(id == golden["id"].get<int>());
    CHECK(verdict.ok());
    // Field by field, so that a failure names the field.
    CHECK(values.size() == golden["values"].size());
    for (const auto& [field, value] : golden["values"].items()) {
      CAPTURE(field);
      REQUIRE(values.contains(field));
      CHECK(values[field] == value);
    }
    CHECK(encoded_again == bytes);
  }
  CHECK(seen.size() == std::tuple_size_v<AllReports>);
}
