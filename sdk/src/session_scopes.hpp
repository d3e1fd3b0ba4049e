/// @file
/// Holds of a session's call while it runs; for session*.cpp alone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <vector>

#include "session.hpp"

namespace torsio {

/// Acknowledgements that somebody waits for; gives up on them when it goes out of scope.
class Session::Expectation {
 public:
  explicit Expectation(Session& session) : session_(session) {}
  Expectation(const Expectation&) = delete;
  Expectation& operator=(const Expectation&) = delete;
  ~Expectation() {
    const std::lock_guard lock(session_.mutex_);
    std::erase_if(session_.pending_, [&](const Pending& pending) {
      return std::ranges::find(sequences_, pending.sequence) != sequences_.end();
    });
  }

  void add(std::uint16_t sequence) {
    const std::lock_guard lock(session_.mutex_);
    sequences_.push_back(sequence);
    session_.pending_.push_back({sequence, {}});
  }

  // With the session's lock held.
  [[nodiscard]] bool met() const {
    return std::ranges::all_of(sequences_,
                               [&](auto sequence) { return find(sequence).answer.has_value(); });
  }
  [[nodiscard]] std::vector<protocol::Acknowledgement> answers() const {
    std::vector<protocol::Acknowledgement> answers;
    for (const std::uint16_t sequence : sequences_) answers.push_back(*find(sequence).answer);
    return answers;
  }

 private:
  [[nodiscard]] const Pending& find(std::uint16_t sequence) const {
    return *std::ranges::find(session_.pending_, sequence, &Pending::sequence);
  }

  Session& session_;
  std::vector<std::uint16_t> sequences_;
};

/// While it lives nobody asks the user: what ends a call must not be ended itself.
class Session::Unasked {
 public:
  explicit Unasked(Session& session) : session_(session) { ++session_.unasked_; }
  Unasked(const Unasked&) = delete;
  Unasked& operator=(const Unasked&) = delete;
  ~Unasked() { --session_.unasked_; }

 private:
  Session& session_;
};

}  // namespace torsio
