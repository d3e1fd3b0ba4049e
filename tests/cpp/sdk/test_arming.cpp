// Whether the SDK may drive, from its orders and what the device says.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <future>
#include <utility>
#include <vector>

#include "arming.hpp"
#include "torsio/error.hpp"

using namespace torsio;
using Phase = Arming::Phase;
using protocol::Op;

TEST_CASE("every phase of arming does with every event what this table says") {
  using enum Arming::Phase;
  using enum Arming::Event;
  constexpr std::array kPhases{off, ordered, drives, fell, another};
  const std::vector<std::pair<Arming::Event, std::array<Phase, kPhases.size()>>> table{
      {order, {ordered, ordered, drives, ordered, ordered}},
      {settled, {off, off, drives, off, off}},
      {ours, {drives, drives, drives, drives, drives}},
      {others, {off, ordered, ordered, another, another}},
      {rest, {off, fell, fell, fell, fell}},
      {early_rest, {off, ordered, ordered, fell, fell}}};
  for (const auto& [event, next] : table) {
    CAPTURE(static_cast<int>(event));
    for (std::size_t i = 0; i < kPhases.size(); ++i) {
      CAPTURE(i);
      CHECK(Arming::after(kPhases[i], event) == next[i]);
    }
  }
}

TEST_CASE("what nobody has ordered, or another has, is not driven") {
  Arming arming;
  CHECK_FALSE(arming.may_drive());
  arming.hear(true, true);
  CHECK(arming.may_drive());
  arming.hear(false, true);
  CHECK(arming.may_drive());
  arming.hear(true, false);
  CHECK_FALSE(arming.may_drive());
  const Arming::Order arm(arming, Op::arm);
  CHECK(arming.may_drive());
}

TEST_CASE("an answer settles nothing if an order to arm may have come later") {
  Arming arming;
  Arming::Order earlier(arming, Op::stop);
  CHECK(arming.is_disarming());
  Arming::Order arm(arming, Op::arm);
  earlier.taken();
  for (const Op op : {Op::arm, Op::disarm, Op::relax}) {
    Arming::Order later(arming, op);
    later.taken();
    later.refused();
  }
  arm.refused();
  CHECK(arming.phase() == Phase::ordered);
  arming.forbid();
  CHECK_THROWS_AS(Arming::Order(arming, Op::arm), Closed);
}

TEST_CASE("an order to arm that is alone settles, and is under way for other threads") {
  Arming arming;
  const auto others_wait = [&] {
    return std::async(std::launch::async, [&] { return arming.is_under_way(); }).get();
  };
  {
    Arming::Order arm(arming, Op::arm);
    arm.taken();
    arming.hear(false, false);
    CHECK(arming.phase() == Phase::ordered);
    CHECK_FALSE(arming.is_under_way());
    CHECK(others_wait());
    arm.refused();
  }
  CHECK(arming.phase() == Phase::off);
  CHECK_FALSE(others_wait());
}
