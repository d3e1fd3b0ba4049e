/// @file
/// How the interrupt and the main loop talk; docs/explanation/architecture.md says what else they
/// share.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace torsio::device {

/// Single-producer single-consumer queue without locks: loads and stores only, so that it works on
/// cores without atomic exchange. Size is a power of two.
template <class T, std::uint32_t Size>
class Ring {
  static_assert(Size != 0 && (Size & (Size - 1)) == 0);

 public:
  // Producer.
  [[nodiscard]] bool push(const T& item) {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == Size) return false;
    items_[tail % Size] = item;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }
  std::uint32_t free() const {
    return Size - (tail_.load(std::memory_order_relaxed) - head_.load(std::memory_order_acquire));
  }

  // Consumer. front() points to data that is valid until pop().
  const T* front() const {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    return head == tail_.load(std::memory_order_acquire) ? nullptr : &items_[head % Size];
  }
  std::uint32_t count() const {
    return tail_.load(std::memory_order_acquire) - head_.load(std::memory_order_relaxed);
  }
  void pop() { head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  // Either.
  bool empty() const {
    return head_.load(std::memory_order_acquire) == tail_.load(std::memory_order_acquire);
  }

 private:
  std::array<T, Size> items_{};
  std::atomic<std::uint32_t> head_{0};
  std::atomic<std::uint32_t> tail_{0};
};

}  // namespace torsio::device
