// The ledger against energies that are worked out by hand.
#include <doctest/doctest.h>

#include <cstdint>

#include "core/ledger.hpp"

using namespace torsio::core;

namespace {

constexpr std::int64_t kOneNm = 1 << 23;

}  // namespace

TEST_CASE("the ledger adds up torque times way, of the spring with the mean of each tick") {
  Ledger ledger;
  keep_ledger(ledger, 0.5F, 0.25F, 3);    // motor 1.5; spring (0 + 0.25) / 2 * 3
  keep_ledger(ledger, -0.25F, 0.75F, 2);  // motor -0.5; spring (0.25 + 0.75) / 2 * 2
  keep_ledger(ledger, 9.0F, 0.5F, 0);     // no way, no work; but the spring is another
  keep_ledger(ledger, 0.5F, 0.25F, -4);   // motor -2; spring (0.5 + 0.25) / 2 * -4
  CHECK(ledger.motor == -1 * kOneNm);
  CHECK(4 * ledger.spring_twice == (3 + 8 - 12) * kOneNm);
  CHECK(4 * ledger.spring == kOneNm);
}

TEST_CASE("a spring that is wound and let go again has given nothing, whatever its torques are") {
  // The oracle is a sum in closed form: the work on a spring depends on its ends alone.
  Ledger ledger;
  const auto torque_nm = [](int counts) { return -0.00217F * static_cast<float>(counts); };
  for (int at = 0; at < 1000; ++at) keep_ledger(ledger, 0.0F, torque_nm(at + 1), 1);
  CHECK(ledger.spring_twice < 0);
  for (int at = 1000; at > 0; --at) keep_ledger(ledger, 0.0F, torque_nm(at - 1), -1);
  CHECK(ledger.spring_twice == 0);
}

TEST_CASE("a ledger of billions of counts has lost nothing") {
  Ledger ledger;
  for (int n = 0; n < 1000; ++n) keep_ledger(ledger, 0.125F, 0.0F, 1'000'000'000);
  for (int n = 0; n < 1000; ++n) keep_ledger(ledger, 0.125F, 0.0F, -1'000'000'000);
  keep_ledger(ledger, 0.125F, 0.0F, 1);
  CHECK(8 * ledger.motor == kOneNm);
}
