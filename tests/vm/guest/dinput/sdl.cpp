// Plays effects through SDL's Windows build, which drives DirectInput:
//
//     sdl.exe LIBRARY RELEASE
//
// with its file and 2 or 3. Each line of standard input is one effect, its SDL_HapticEffect in
// hexadecimal digits:
//
//     NAME LENGTH_MS BYTES
//
// Says "played NAME" or what SDL has refused. Runs under Wine in the guests; see test_game_wine.py.
#include <windows.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>

namespace {

constexpr DWORD kPauseMs = 250;
constexpr std::uint32_t kJoystickAndHaptic = 0x200 | 0x1000;

HMODULE library = nullptr;
bool three = false;

[[noreturn]] void fail(const char* what) {
  const auto error = reinterpret_cast<const char* (*)()>(
      reinterpret_cast<void*>(GetProcAddress(library, "SDL_GetError")));
  std::printf("failed %s: %s\n", what, error == nullptr ? "no such library" : error());
  std::fflush(stdout);
  ExitProcess(1);
}

/// Calls a function by its names in SDL 2 and SDL 3.
template <class Result, class... Arguments>
Result call(const char* name_2, const char* name_3, Arguments... arguments) {
  const char* name = three ? name_3 : name_2;
  const auto function = reinterpret_cast<Result (*)(Arguments...)>(
      reinterpret_cast<void*>(GetProcAddress(library, name)));
  if (function == nullptr) fail(name);
  return function(arguments...);
}

/// SDL 2 answers 0 where all is well, SDL 3 true.
template <class... Arguments>
void require(const char* name_2, const char* name_3, Arguments... arguments) {
  const bool done = three ? call<bool>(name_2, name_3, arguments...)
                          : call<int>(name_2, name_3, arguments...) == 0;
  if (!done) fail(three ? name_3 : name_2);
}

void* open_first() {
  void* joystick = nullptr;
  if (three) {
    int count = 0;
    const auto* found = call<const std::uint32_t*>("", "SDL_GetJoysticks", &count);
    if (count > 0) joystick = call<void*>("", "SDL_OpenJoystick", found[0]);
  } else if (call<int>("SDL_NumJoysticks", "") > 0) {
    joystick = call<void*>("SDL_JoystickOpen", "", 0);
  }
  if (joystick == nullptr) fail("to open a joystick");
  void* haptic = call<void*>("SDL_HapticOpenFromJoystick", "SDL_OpenHapticFromJoystick", joystick);
  if (haptic == nullptr) fail("to open its forces");
  return haptic;
}

void play(void* haptic, const std::string& line) {
  std::istringstream words(line);
  std::string name;
  DWORD length_ms = 0;
  std::string digits;
  words >> name >> length_ms >> digits;
  std::array<std::uint8_t, 128> effect{};  // as large as the union of all kinds
  for (std::size_t n = 0; n < digits.size() / 2; ++n) {
    effect.at(n) = static_cast<std::uint8_t>(std::stoi(digits.substr(2 * n, 2), nullptr, 16));
  }
  const int number =
      call<int>("SDL_HapticNewEffect", "SDL_CreateHapticEffect", haptic, effect.data());
  if (number < 0) fail("to make an effect");
  require("SDL_HapticRunEffect", "SDL_RunHapticEffect", haptic, number, std::uint32_t{1});
  Sleep(length_ms + kPauseMs);
  call<void>("SDL_HapticDestroyEffect", "SDL_DestroyHapticEffect", haptic, number);
  std::printf("played %s\n", name.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int, char** words) {
  library = LoadLibraryA(words[1]);
  three = std::string(words[2]) == "3";
  if (library == nullptr) {
    std::printf("failed to load %s\n", words[1]);
    return 1;
  }
  require("SDL_Init", "SDL_Init", kJoystickAndHaptic);
  void* haptic = open_first();
  std::printf("acquired\n");
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    if (!line.empty()) play(haptic, line);
  }
  call<void>("SDL_HapticClose", "SDL_CloseHaptic", haptic);
  call<void>("SDL_Quit", "SDL_Quit");
  std::printf("done\n");
}
