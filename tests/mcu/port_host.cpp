#include <cstdio>

#include "port.hpp"

namespace torsio::mcu {

void print(const char* text) { std::fputs(text, stdout); }
void print(std::uint32_t number) { std::printf("%lu", static_cast<unsigned long>(number)); }
std::uint32_t instructions() { return 0; }

}  // namespace torsio::mcu
