// The ledger against energies that are worked out by hand.
#include <doctest/doctest.h>

#include "core/ledger.hpp"

using namespace torsio::core;
using doctest::Approx;

TEST_CASE("the ledger adds up torque times way, of the spring with the mean of each tick") {
  Ledger ledger;
  keep_ledger(ledger, 0.5F, 0.2F, 3);    // motor 1.5; spring (0 + 0.2) / 2 * 3 = 0.3
  keep_ledger(ledger, -0.25F, 0.6F, 2);  // motor -0.5; spring 0.4 * 2 = 0.8
  keep_ledger(ledger, 9.0F, 0.4F, 0);    // no way, no work; but the spring is another
  keep_ledger(ledger, 0.5F, 0.2F, -4);   // motor -2; spring 0.3 * -4 = -1.2
  const Energies told = energies(ledger, 0.5F, 2.0F);
  CHECK(static_cast<double>(told.motor_j) == Approx(-1.0 * 0.5));
  CHECK(static_cast<double>(told.spring_j) == Approx(-0.1 * 0.5));
  CHECK(static_cast<double>(told.stored_j) == Approx(0.5 * 0.2 * 0.2 / 2.0));
  CHECK(static_cast<double>(told.brake_j) == Approx(0.05 - 0.01));
}

TEST_CASE("without a spring nothing is stored") {
  Ledger ledger;
  keep_ledger(ledger, 0.0F, 0.2F, 2);
  const Energies told = energies(ledger, 0.5F, 0.0F);
  CHECK(told.stored_j == 0.0F);
  CHECK(static_cast<double>(told.brake_j) == Approx(-0.1));
}

TEST_CASE("a ledger of billions of counts has lost nothing") {
  Ledger ledger;
  for (int n = 0; n < 1000; ++n) keep_ledger(ledger, 0.125F, 0.0F, 1'000'000'000);
  for (int n = 0; n < 1000; ++n) keep_ledger(ledger, 0.125F, 0.0F, -1'000'000'000);
  keep_ledger(ledger, 0.125F, 0.0F, 1);
  CHECK(static_cast<double>(energies(ledger, 1.0F, 1.0F).motor_j) == 0.125);
}
