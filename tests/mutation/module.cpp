// In the mutated Python module: the environment says which mutant is on.
#include <cstdlib>

extern "C" {
extern unsigned char torsio_mutant_reached[];
__attribute__((visibility("default"))) unsigned char torsio_mutant_reached[TORSIO_MUTANTS + 1];
extern int torsio_mutant;
const char* const told = std::getenv("TORSIO_MUTANT");
int torsio_mutant = told == nullptr ? 0 : std::atoi(told);
}
