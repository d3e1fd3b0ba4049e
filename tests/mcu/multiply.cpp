// Products of floats that are likely to be rounded wrongly: prints checksums, which must be the
// same on every processor. The host multiplies in hardware.
#include <bit>
#include <cstdint>

#include "port.hpp"

namespace {

using torsio::mcu::print;

constexpr std::uint32_t kFraction = (1U << 23) - 1;
constexpr std::uint32_t kSign = 1U << 31;
constexpr std::uint32_t kInfinity = 255U << 23;

/// xorshift32 (Marsaglia 2003).
std::uint32_t next() {
  static std::uint32_t state = 2463534242U;
  state ^= state << 13;
  state ^= state >> 17;
  state ^= state << 5;
  return state;
}

std::uint32_t product(std::uint32_t a, std::uint32_t b) {
  // The compiler must not multiply.
  volatile float factor = std::bit_cast<float>(a);
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(factor * std::bit_cast<float>(b));
  // What a number that is none looks like is the processor's affair.
  return (bits & ~kSign) > kInfinity ? kInfinity + 1 : bits;
}

/// So that the product's exponent is near `exponent`.
std::uint32_t partner(std::uint32_t a, std::uint32_t b, std::uint32_t exponent) {
  const std::uint32_t own = (a >> 23) & 255;
  return (b & (kSign | kFraction)) | (((127 + exponent + (b & 3) - own) & 255) << 23);
}

}  // namespace

int main() {
  std::uint32_t sums[6];
  for (std::uint32_t& sum : sums) sum = 2166136261U;
  for (int n = 0; n < 10'000; ++n) {
    const std::uint32_t a = next();
    const std::uint32_t b = next();
    const std::uint32_t few_bits = ~(0xFFFFFFFFU >> (9 + (a & 15)));
    const std::uint32_t pairs[6][2] = {
        {a, b},
        {a, partner(a, b, 127)},
        {a & 0xFFFFF000, partner(a, b & 0xFFFFF800, 127)},        // half way between two floats
        {a | 0x7FF000, partner(a, b | 0x7FFE00, 127)},            // carries
        {a, partner(a, b, (n & 1) == 0 ? 0 : 253)},               // subnormal or infinite
        {a & few_bits, n % 4 == 0 ? b & kSign : b | kInfinity}};  // 0, infinite, no number
    for (int kind = 0; kind < 6; ++kind)
      sums[kind] = (sums[kind] ^ product(pairs[kind][0], pairs[kind][1])) * 16777619U;
  }
  for (const std::uint32_t sum : sums) {
    print(sum);
    print("\n");
  }
}
