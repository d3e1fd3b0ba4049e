/// @file
/// What happens when something is thrown: WebAssembly here has no exceptions, so the text is kept
/// and the module stops for good. All that the emulated device throws are std::exceptions.
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>

namespace {

constexpr std::size_t kLongest = 256;
std::array<char, kLongest> text{};
// A thrown object is put together here; only one can be under way.
alignas(std::max_align_t) std::array<std::uint8_t, 256> thrown_object{};

}  // namespace

extern "C" {

/// The thrown object's text, ends with 0; empty if nothing was thrown.
__attribute__((export_name("thrown_text"))) const char* thrown_text() { return text.data(); }

// NOLINTBEGIN(bugprone-reserved-identifier): the names that the compiler calls
void* __cxa_allocate_exception(std::size_t size) {
  if (size > thrown_object.size()) __builtin_trap();
  return thrown_object.data();
}

void __cxa_free_exception(void*) {}

[[noreturn]] void __cxa_throw(void* object, void*, void (*)(void*)) {
  std::strncpy(text.data(), static_cast<std::exception*>(object)->what(), kLongest - 1);
  __builtin_trap();
}
// NOLINTEND(bugprone-reserved-identifier)
}
