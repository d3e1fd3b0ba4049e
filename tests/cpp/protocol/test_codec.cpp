#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

using namespace torsio::protocol;

namespace {

std::string hex(const ReportBytes& bytes, std::size_t length) {
  constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < length; ++i) {
    text += digits[bytes[i] >> 4];
    text += digits[bytes[i] & 15];
  }
  return text;
}

// Not in the templates that are instantiated for every report: assertions take long to compile.
void check_round_trip(std::string_view report, bool accepted, const ReportBytes& bytes,
                      const ReportBytes& encoded_again) {
  CAPTURE(report);
  CHECK(accepted);
  REQUIRE(encoded_again == bytes);
}

void check_some_accepted(std::string_view report, int accepted) {
  CAPTURE(report);
  CHECK(accepted > 0);
}

/// A report whose fields are all within their ranges.
template <class Report>
Report good() {
  Report report{};
  // Its bounds must be given.
  if constexpr (std::is_same_v<Report, Excitation>) {
    report.duration_s = 1.0F;
    report.travel_rad = 1.0F;
    report.speed_limit_rad_s = 10.0F;
  }
  return report;
}

}  // namespace

TEST_CASE("a wall's bytes are these") {
  Wall wall;
  wall.target = {0x1234, 0, 5};
  wall.angle_turns_q32 = -2;
  wall.side = Side::below;
  wall.stiffness_nm_per_rad = 1.5F;     // 3fc00000
  wall.damping_nm_s_per_rad = 0.0625F;  // 3d800000
  const ReportBytes bytes = encode(wall);
  CHECK(hex(bytes, 22) ==
        "20"
        "3412"
        "00"
        "05"
        "feffffffffffffff"
        "01"
        "0000c03f"
        "0000803d");
  for (std::size_t i = 22; i < report_size; ++i) CHECK(bytes[i] == 0);
}

TEST_CASE("decoding gives back what was encoded, for a good report of each kind") {
  for_each_report<AllReports>([]<class Report>(std::type_identity<Report>) {
    const ReportBytes bytes = encode(good<Report>());
    Report back{};
    const bool accepted = decode(bytes, back).ok();
    check_round_trip(Layout<Report>::name, accepted, bytes, encode(back));
  });
}

TEST_CASE("whatever decodes encodes to the same bytes, for random bytes") {
  std::mt19937_64 random(5);
  for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
    int accepted = 0;
    for (int i = 0; i < 3000; ++i) {
      ReportBytes bytes = encode(good<Report>());
      const std::size_t changes = random() % 4;
      for (std::size_t k = 0; k < changes; ++k) {
        bytes[1 + random() % wire_size<Report>()] = static_cast<std::uint8_t>(random());
      }
      Report report{};
      if (!decode(bytes, report).ok()) continue;
      ++accepted;
      check_round_trip(Layout<Report>::name, true, bytes, encode(report));
    }
    check_some_accepted(Layout<Report>::name, accepted);
  });
}

TEST_CASE("wrong lengths, ids and padding are refused") {
  const ReportBytes bytes = encode(Wall{});
  Wall wall;
  const std::span all(bytes);
  CHECK(decode(all.first(63), wall).status == Status::bad_length);
  CHECK(decode(all.first(0), wall).status == Status::bad_length);
  CHECK(decode(std::vector<std::uint8_t>(65), wall).status == Status::bad_length);
  Spring spring;
  CHECK(decode(all, spring).status == Status::unknown_report);
  ReportBytes padded = bytes;
  padded[63] = 1;
  CHECK(decode(padded, wall).status == Status::bad_padding);
}

TEST_CASE("a bad field is refused and named") {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Wall wall;
  for (const float bad : {inf, -inf, nan}) {
    wall.stiffness_nm_per_rad = bad;
    const Verdict verdict = check(wall);
    CHECK(verdict.status == Status::not_finite);
    CHECK(field_name<Wall>(verdict.field) == "stiffness_nm_per_rad");
  }
  wall.stiffness_nm_per_rad = -1.0F;
  CHECK(check(wall) == Verdict{Status::out_of_range, field_index<Wall>("stiffness_nm_per_rad")});

  Constant constant;
  constant.timing.fade_level = 1.5F;
  CHECK(check(constant) == Verdict{Status::out_of_range, field_index<Constant>("fade_level")});

  Wall slot;
  slot.target.slot = 16;
  CHECK(check(slot) == Verdict{Status::out_of_range, field_index<Wall>("slot")});

  CurvePoints points;
  points.torque_nm[12] = nan;
  CHECK(check(points) == Verdict{Status::not_finite, field_index<CurvePoints>("torque_nm")});
}

TEST_CASE("of several bad fields the first is named") {
  Wall wall;
  wall.target.slot = 16;
  wall.stiffness_nm_per_rad = std::numeric_limits<float>::quiet_NaN();
  wall.damping_nm_s_per_rad = -1.0F;
  CHECK(check(wall) == Verdict{Status::out_of_range, field_index<Wall>("slot")});
  wall.target.slot = 0;
  CHECK(check(wall) == Verdict{Status::not_finite, field_index<Wall>("stiffness_nm_per_rad")});
}

TEST_CASE("a number beyond an enumeration is refused and never becomes an enumerator") {
  ReportBytes bytes = encode(Wall{});
  bytes[13] = 2;  // side
  Wall wall;
  CHECK(decode(bytes, wall) == Verdict{Status::out_of_range, field_index<Wall>("side")});
  CHECK(wall.side == Side::above);
}

TEST_CASE("ids are unique and every report fits a packet") {
  std::set<int> ids;
  std::size_t largest = 0;
  for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
    ids.insert(Layout<Report>::id);
    largest = std::max(largest, 1 + wire_size<Report>());
  });
  CHECK(ids.size() == std::tuple_size_v<AllReports>);
  CHECK(largest <= 64);
}

TEST_CASE("the identity's first fields stand where every version looks for them") {
  Identity identity;
  identity.fingerprint = 0x04030201;
  identity.version = 0x0605;
  CHECK(hex(encode(identity), 7) == "01010203040506");
}
