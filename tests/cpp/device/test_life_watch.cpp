// When the chip's watchdog is fed, and how late a tick is, on a chip that is made of numbers.
#include <doctest/doctest.h>

#include <cstdint>

#include "boards/rp2/life_watch.hpp"

using namespace torsio::boards;

TEST_CASE("the watchdog bites after 8 ms, or 10 without floating point, and after 2 s in flash") {
  for (const bool predicts : {true, false}) {
    const std::uint32_t time_ms = predicts ? 8 : 10;
    fake::watchdog = {};
    const LifeWatch watch(predicts);
    watch.start();
    CHECK(fake::watchdog.time_ms == time_ms);
    for (const bool intact : {true, false}) {
      std::uint32_t meanwhile_ms = 0;
      CHECK(watch.stand_by([&] {
        meanwhile_ms = fake::watchdog.time_ms;
        return intact;
      }) == intact);
      CHECK(meanwhile_ms == 2000);
      CHECK(fake::watchdog.time_ms == time_ms);
    }
  }
}

TEST_CASE("a main loop that goes round without a tick does not feed the watchdog") {
  fake::watchdog = {};
  LifeWatch watch(true);
  watch.see(1);
  CHECK(fake::watchdog.updates == 1);
  for (int i = 0; i < 100; ++i) watch.see(1);
  CHECK(fake::watchdog.updates == 1);
  watch.see(2);
  watch.see(4);
  CHECK(fake::watchdog.updates == 3);
  watch.see(0);  // the count has come round
  CHECK(fake::watchdog.updates == 4);
}

TEST_CASE(
    "a tick that comes whole periods late says how many are missing, and the next is on time") {
  // The timer wraps meanwhile, as every 72 minutes.
  for (const std::uint32_t begin_us : {0U, 5'000U, 0U - 120U}) {
    CAPTURE(begin_us);
    TickClock clock(begin_us, 50);
    CHECK(clock.count_missed(begin_us + 50) == 0);
    CHECK(clock.count_missed(begin_us + 99) == 0);   // early, by the interrupt's jitter
    CHECK(clock.count_missed(begin_us + 199) == 0);  // late, but within its period
    CHECK(clock.count_missed(begin_us + 200) == 0);
    CHECK(clock.count_missed(begin_us + 401) == 3);  // due at 250, 300, 350 and 400
    CHECK(clock.count_missed(begin_us + 450) == 0);
    CHECK(clock.count_missed(begin_us + 550) == 1);
    CHECK(clock.count_missed(begin_us + 600) == 0);
  }
}
