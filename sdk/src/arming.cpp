#include "arming.hpp"

#include <chrono>

#include "torsio/error.hpp"

namespace torsio {
namespace {

constexpr int kWaitsForArming = 1000;
constexpr auto kWaitForArming = std::chrono::milliseconds(1);

}  // namespace

/// Nobody takes the actuator from the SDK before it rests: a report that says so is nonsense.
Arming::Phase Arming::after(Phase phase, Event event) {
  const bool drives = phase == Phase::drives;
  switch (event) {
    case Event::order:
      return drives ? phase : Phase::ordered;
    case Event::settled:
      return drives ? phase : Phase::off;
    case Event::ours:
      return Phase::drives;
    case Event::others:
      if (phase == Phase::fell) return Phase::another;
      return drives ? Phase::ordered : phase;
    case Event::early_rest:
      if (drives || phase == Phase::ordered) return Phase::ordered;
      [[fallthrough]];
    case Event::rest:
      return phase == Phase::off ? phase : Phase::fell;
  }
  return phase;
}

/// @returns the word as it is then
template <class Change>
Arming::Word Arming::change(Change&& change) {
  Word now;
  for (Word was = word_;;) {
    now = was;
    change(now);
    if (word_.compare_exchange_weak(was, now)) return now;
  }
}

void Arming::hear(bool is_armed, bool is_ours) {
  change([&](Word& word) {
    const Event rest = word.under_way == 0 ? Event::rest : Event::early_rest;
    const Event armed = is_ours ? Event::ours : Event::others;
    word.phase = after(word.phase, is_armed ? armed : rest);
  });
}

void Arming::forbid() noexcept {
  change([](Word& word) { word.is_forbidden = true; });
}

bool Arming::is_under_way() const noexcept {
  return word_.load().under_way > (armer_.load() == std::this_thread::get_id() ? 1 : 0);
}

void Arming::outlast() const noexcept {
  for (int i = 0; is_under_way() && i < kWaitsForArming; ++i) {
    std::this_thread::sleep_for(kWaitForArming);
  }
}

Arming::Order::Order(Arming& arming, protocol::Op op)
    : arming_(arming),
      arms_(op == protocol::Op::arm),
      disarms_(op == protocol::Op::disarm || op == protocol::Op::stop) {
  begin_ = arming_.change([&](Word& word) {
    if (!arms_) return;
    if (word.is_forbidden) throw Closed("the knob is being closed; open it again to arm it");
    ++word.under_way;
    ++word.begun;
    word.phase = after(word.phase, Event::order);
  });
  if (arms_) arming_.armer_ = std::this_thread::get_id();
  if (disarms_) ++arming_.disarming_;
}

Arming::Order::~Order() {
  if (disarms_) --arming_.disarming_;
  if (!arms_) return;
  std::thread::id here = std::this_thread::get_id();
  arming_.armer_.compare_exchange_strong(here, {});
  arming_.change([](Word& word) { --word.under_way; });
}

void Arming::Order::taken() {
  if (disarms_) settle();
}

void Arming::Order::refused() {
  if (arms_) settle();
}

/// An order to arm that was under way at its begin, or has begun since, may have come later.
void Arming::Order::settle() {
  arming_.change([&](Word& word) {
    const bool was_alone = begin_.under_way == (arms_ ? 1 : 0);
    if (was_alone && word.begun == begin_.begun) word.phase = after(word.phase, Event::settled);
  });
}

}  // namespace torsio
