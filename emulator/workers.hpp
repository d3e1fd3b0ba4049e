/// @file
/// Threads that last, for work that is cut into parts.
#pragma once

#include <functional>
#include <memory>

namespace torsio::emulator {

/// The caller and threads of its own do one piece of work after another. A free thread takes the
/// next part, so nobody waits for a thread that does not run yet.
///
/// The threads begin when they are first needed and end with this. A child that was forked has none
/// of its parent's: it leaves them alone and begins its own.
class Workers {
 public:
  /// May not throw.
  using Work = std::function<void(unsigned part)>;

  Workers();
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Does each of `parts` parts once, and returns when all are done. One call at a time.
  /// @param threads  so many are called to it, the caller among them; fewer if the system has no
  ///                 more
  void run(unsigned parts, unsigned threads, const Work& work);

 private:
  struct Team;

  std::unique_ptr<Team> team_;
};

}  // namespace torsio::emulator
