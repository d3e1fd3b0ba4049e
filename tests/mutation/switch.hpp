/// @file A mutated source asks here: is this mutant switched on? Stands in front of every source of
/// the mutation build; see tests/mutation/mutate.py.
#pragma once

#include <type_traits>

extern "C" {
extern int torsio_mutant;                      // number of the one that is on; 0: none
extern unsigned char torsio_mutant_reached[];  // 1: was asked for
}

/// Code that the compiler computes is never mutated.
constexpr bool torsio_mutant_is(int number) {
  if (std::is_constant_evaluated()) return false;
  torsio_mutant_reached[number] = 1;
  return torsio_mutant == number;
}
