#include <doctest/doctest.h>

#include <cstdint>
#include <thread>

#include "device/ring.hpp"

TEST_CASE("a ring is first in, first out, and says when it is full") {
  torsio::device::Ring<int, 4> ring;
  CHECK(ring.front() == nullptr);
  for (int i = 0; i < 4; ++i) CHECK(ring.push(i));
  CHECK_FALSE(ring.push(4));
  CHECK(ring.free() == 0);
  for (int i = 0; i < 4; ++i) {
    REQUIRE(ring.front() != nullptr);
    CHECK(*ring.front() == i);
    ring.pop();
  }
  CHECK(ring.empty());
}

TEST_CASE("a ring carries everything in order from one thread to another") {
  torsio::device::Ring<std::uint32_t, 8> ring;
  constexpr std::uint32_t count = 200'000;
  std::thread producer([&] {
    for (std::uint32_t i = 0; i < count;) {
      if (ring.push(i)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  bool in_order = true;
  for (std::uint32_t i = 0; i < count;) {
    if (const std::uint32_t* item = ring.front()) {
      in_order &= *item == i++;
      ring.pop();
    } else {
      std::this_thread::yield();
    }
  }
  producer.join();
  CHECK(in_order);
}
