/// @file
/// Why the chip started, and a mark at the stack's end that tells when the program went past it.
#pragma once

#include "protocol/reports.hpp"

namespace torsio::boards {

/// Once, at start-up.
protocol::ResetCause take_reset_cause();

/// For the program that comes after the next reset.
void leave_reset_cause(protocol::ResetCause why);

/// Marks the end of the stack, once, at start-up.
void guard_stack();

/// The mark is untouched.
bool stack_is_whole();

}  // namespace torsio::boards
