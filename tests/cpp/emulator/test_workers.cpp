// Threads that last and share work with their caller; all of it also with -fsanitize=thread.
#include <doctest/doctest.h>

#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "emulator/workers.hpp"

namespace torsio::emulator {
namespace {

using namespace std::chrono_literals;

std::atomic<int> threads_seen{0};

/// Made once in each thread that asks for it.
struct Seen {
  Seen() { ++threads_seen; }
  int pieces = 0;
};

/// How often each part was done, after so many pieces of work.
std::vector<int> counts(Workers& workers, unsigned parts, unsigned threads, int pieces) {
  std::vector<int> counts(parts, 0);  // not atomic: one piece's end comes before the next begins
  for (int piece = 0; piece < pieces; ++piece) {
    workers.run(parts, threads, [&](unsigned part) { ++counts[part]; });
  }
  return counts;
}

/// Whether so many threads are at one piece of work at the same time.
bool are_together(Workers& workers, unsigned threads) {
  std::atomic<unsigned> inside{0};
  std::atomic<unsigned> met{0};
  workers.run(threads, threads, [&](unsigned) {
    thread_local Seen seen;
    ++seen.pieces;
    ++inside;  // and nobody takes another part before all have begun
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (inside < threads && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    if (inside == threads) ++met;
  });
  return met == threads;
}

TEST_CASE("each part of each piece of work is done once, by any number of threads") {
  Workers workers;
  for (const unsigned threads : {1U, 3U, 8U, 2U}) {
    for (const unsigned parts : {1U, 2U, 7U, 40U}) {
      CHECK(counts(workers, parts, threads, 300) == std::vector<int>(parts, 300));
    }
  }
  CHECK(counts(workers, 0, 4, 1).empty());
}

TEST_CASE("the same threads do one piece of work after another, together") {
  threads_seen = 0;
  Workers workers;
  for (int piece = 0; piece < 50; ++piece) {
    CHECK(are_together(workers, 3));
    if (piece % 10 == 0) std::this_thread::sleep_for(2ms);  // so that they sleep, too
  }
  CHECK(threads_seen == 3);
}

TEST_CASE("whoever is held up keeps the others from no part") {
  Workers workers;
  std::atomic<int> done{0};
  std::atomic<bool> is_held{false};
  workers.run(20, 2, [&](unsigned) {
    if (!is_held.exchange(true)) {
      const auto end = std::chrono::steady_clock::now() + 20s;
      while (done < 19 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
      CHECK(done == 19);
    }
    ++done;
  });
  CHECK(done == 20);
}

TEST_CASE("workers end, asleep or not") {
  for (int i = 0; i < 100; ++i) {
    Workers workers;
    counts(workers, 4, 4, 2);
    if (i % 10 == 0) std::this_thread::sleep_for(1ms);
  }
}

// The thread sanitizer allows this only where the child begins no threads.
#if !defined(_WIN32) && !defined(__SANITIZE_THREAD__)
TEST_CASE("a forked child has workers of its own") {
  auto workers = std::make_unique<Workers>();
  auto other = std::make_unique<Workers>();
  // All have begun: a thread that begins holds locks of the address sanitizer's, which a forked
  // child would wait for.
  REQUIRE(are_together(*workers, 3));
  REQUIRE(are_together(*other, 3));
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    alarm(30);
    {
      const std::unique_ptr<Workers> ended = std::move(other);
    }
    _exit(are_together(*workers, 3) ? 0 : 1);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  CHECK(counts(*workers, 4, 3, 10) == std::vector<int>(4, 10));
}
#endif

}  // namespace
}  // namespace torsio::emulator
