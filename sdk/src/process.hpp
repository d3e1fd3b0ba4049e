/// @file
/// The process that made something: after fork() the child has the memory, but not the threads.
#pragma once

namespace torsio {

/// Remembers the process that it was made in. Asking costs one load.
class MakersProcess {
 public:
  MakersProcess();
  /// False in a child that was forked since: locks may be held there for ever, by threads that the
  /// child does not have, so nothing of what the parent made may be touched.
  [[nodiscard]] bool is_this() const noexcept;

 private:
  unsigned forks_;
};

}  // namespace torsio
