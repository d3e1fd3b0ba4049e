#include "process.hpp"

#include <pthread.h>

#include <atomic>

namespace torsio {
namespace {

std::atomic<unsigned> forks{0};  // between the first process and this one

void count_forks() {
  [[maybe_unused]] static const int watched =
      pthread_atfork(nullptr, nullptr, [] { forks.fetch_add(1, std::memory_order_relaxed); });
}

}  // namespace

MakersProcess::MakersProcess() {
  count_forks();
  forks_ = forks.load(std::memory_order_relaxed);
}

bool MakersProcess::is_this() const noexcept {
  return forks.load(std::memory_order_relaxed) == forks_;
}

}  // namespace torsio
