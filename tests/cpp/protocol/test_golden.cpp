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

template <class T>
void compare(const T& value, const json& golden) {
  if constexpr (Structure<T>) {
    const auto one = [&](const auto& field) {
      const std::string name(field.name);
      CAPTURE(name);
      REQUIRE(golden.contains(name));
      compare(value.*field.member, golden[name]);
    };
    std::apply([&](const auto&... field) { (one(field), ...); }, Layout<T>::fields);
    CHECK(golden.size() == std::tuple_size_v<decltype(Layout<T>::fields)>);
  } else if constexpr (Array<T>) {
    REQUIRE(golden.size() == value.size());
    for (std::size_t i = 0; i < value.size(); ++i) compare(value[i], golden[i]);
  } else if constexpr (Enumeration<T>) {
    CHECK(Enumerators<T>::names[static_cast<std::size_t>(value)] == golden.get<std::string>());
  } else {
    CHECK(json(value) == golden);  // as numbers: a wrapped sign must not pass
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
    for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
      if (Layout<Report>::name != name) return;
      seen.insert(name);
      CHECK(Layout<Report>::id == golden["id"].get<int>());
      Report report{};
      const Verdict verdict = decode(bytes, report);
      CHECK(verdict.ok());
      compare(report, golden["values"]);
      CHECK(encode(report) == bytes);
    });
  }
  CHECK(seen.size() == std::tuple_size_v<AllReports>);
}
