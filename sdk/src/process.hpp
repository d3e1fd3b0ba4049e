/// @file
/// The process that made something: after fork() the child has the memory, but not the threads.
#pragma once

namespace torsio {

/// Remembers the process that it was made in. Asking costs one load.
class MakersProcess {
 public:
  MakersProcess();
  /// False in a child that was forked since. Threads that the child does not have may hold locks
  /// there for ever. So the child must not touch anything of the parent's.
  [[nodiscard]] bool is_this() const noexcept;

 private:
  unsigned forks_;
};

}  // namespace torsio
