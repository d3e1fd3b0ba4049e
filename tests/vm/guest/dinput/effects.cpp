// Plays effects through DirectInput, as a Windows game does. Each line of standard input is one:
//
//     NAME KIND LENGTH_MS GAIN DIRECTION NUMBER...
//
// GAIN of 10000, DIRECTION 1 or -1 along X; what the numbers are depends on KIND, see below. Or
//
//     NAME follow EACH_MS LEVEL...
//
// which is a constant force without end whose level is updated while it plays, and which is left
// playing. Says "played NAME" or what DirectInput has refused. Releases an effect when it is over,
// unless started with "keep". Runs under Wine in the guests; see test_game_wine.py.
#define DIRECTINPUT_VERSION 0x0800
#define INITGUID
#include <dinput.h>
#include <windows.h>

#include <cstdio>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace {

constexpr DWORD kPauseMs = 250;

IDirectInput8W* input = nullptr;
IDirectInputDevice8W* knob = nullptr;
bool keeps = false;

[[noreturn]] void fail(const char* what, HRESULT result) {
  std::printf("failed %s 0x%08lx\n", what, static_cast<unsigned long>(result));
  std::fflush(stdout);
  ExitProcess(1);
}

void require(const char* what, HRESULT result) {
  if (FAILED(result)) fail(what, result);
}

BOOL CALLBACK take(const DIDEVICEINSTANCEW* found, void*) {
  require("CreateDevice", input->CreateDevice(found->guidInstance, &knob, nullptr));
  return DIENUM_STOP;
}

struct Kind {
  const GUID* guid;
  enum class Parameters { constant, ramp, periodic, condition } parameters;
};

const std::map<std::string, Kind> kKinds{
    {"constant", {&GUID_ConstantForce, Kind::Parameters::constant}},  // magnitude
    {"ramp", {&GUID_RampForce, Kind::Parameters::ramp}},              // start, end
    {"square", {&GUID_Square, Kind::Parameters::periodic}},  // magnitude, offset, phase, period us
    {"sine", {&GUID_Sine, Kind::Parameters::periodic}},
    {"triangle", {&GUID_Triangle, Kind::Parameters::periodic}},
    {"saw_up", {&GUID_SawtoothUp, Kind::Parameters::periodic}},
    {"saw_down", {&GUID_SawtoothDown, Kind::Parameters::periodic}},
    {"spring", {&GUID_Spring, Kind::Parameters::condition}},  // offset, coefficient, saturation
    {"damper", {&GUID_Damper, Kind::Parameters::condition}},
    {"inertia", {&GUID_Inertia, Kind::Parameters::condition}},
    {"friction", {&GUID_Friction, Kind::Parameters::condition}},
};

std::vector<LONG> rest_of(std::istringstream& words) {
  std::vector<LONG> numbers;
  for (LONG one = 0; words >> one;) numbers.push_back(one);
  return numbers;
}

/// Along X; its kind comes in addition.
struct Effect : DIEFFECT {
  DWORD axis = DIJOFS_X;
  LONG direction;

  Effect(DWORD duration_us, DWORD gain, LONG along) : DIEFFECT{}, direction(along) {
    dwSize = sizeof(DIEFFECT);
    dwFlags = DIEFF_CARTESIAN | DIEFF_OBJECTOFFSETS;
    dwDuration = duration_us;
    dwGain = gain;
    dwTriggerButton = DIEB_NOTRIGGER;
    cAxes = 1;
    rgdwAxes = &axis;
    rglDirection = &direction;
  }
  Effect(const Effect&) = delete;
  Effect& operator=(const Effect&) = delete;
};

IDirectInputEffect* started(const GUID& kind, const DIEFFECT& effect) {
  IDirectInputEffect* made = nullptr;
  require("CreateEffect", knob->CreateEffect(kind, &effect, &made, nullptr));
  require("Start", made->Start(1, 0));
  return made;
}

void follow(std::istringstream& words) {
  DWORD each_ms = 0;
  words >> each_ms;
  const std::vector<LONG> levels = rest_of(words);
  DICONSTANTFORCE constant{levels.at(0)};
  Effect effect(INFINITE, DI_FFNOMINALMAX, 1);
  effect.cbTypeSpecificParams = sizeof constant;
  effect.lpvTypeSpecificParams = &constant;
  IDirectInputEffect* const made = started(GUID_ConstantForce, effect);
  for (const LONG level : levels) {
    constant.lMagnitude = level;
    require("SetParameters", made->SetParameters(&effect, DIEP_TYPESPECIFICPARAMS));
    Sleep(each_ms);
  }
}

void play(std::istringstream& words, const std::string& kind_name) {
  DWORD length_ms = 0;
  DWORD gain = 0;
  LONG direction = 0;
  words >> length_ms >> gain >> direction;
  std::vector<LONG> n = rest_of(words);
  n.resize(4);
  const Kind& kind = kKinds.at(kind_name);

  DICONSTANTFORCE constant{n[0]};
  DIRAMPFORCE ramp{n[0], n[1]};
  DIPERIODIC periodic{static_cast<DWORD>(n[0]), n[1], static_cast<DWORD>(n[2]),
                      static_cast<DWORD>(n[3])};
  DICONDITION condition{n[0], n[1], n[1], static_cast<DWORD>(n[2]), static_cast<DWORD>(n[2]), 0};
  Effect effect(length_ms * 1000, gain, direction);
  const auto give = [&](auto& parameters) {
    effect.cbTypeSpecificParams = sizeof parameters;
    effect.lpvTypeSpecificParams = &parameters;
  };
  switch (kind.parameters) {
    case Kind::Parameters::constant:
      give(constant);
      break;
    case Kind::Parameters::ramp:
      give(ramp);
      break;
    case Kind::Parameters::periodic:
      give(periodic);
      break;
    case Kind::Parameters::condition:
      give(condition);
      break;
  }
  IDirectInputEffect* const made = started(*kind.guid, effect);
  Sleep(length_ms + kPauseMs);
  if (!keeps) made->Release();
}

void obey(const std::string& line) {
  std::istringstream words(line);
  std::string name;
  std::string kind;
  words >> name >> kind;
  if (kind == "follow") {
    follow(words);
  } else {
    play(words, kind);
  }
  std::printf("played %s\n", name.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  keeps = count > 1 && std::string(words[1]) == "keep";
  const HINSTANCE program = GetModuleHandleW(nullptr);
  const HWND window = CreateWindowExW(0, L"Message", nullptr, 0, 0, 0, 0, 0, HWND_MESSAGE, nullptr,
                                      program, nullptr);
  require("DirectInput8Create", DirectInput8Create(program, DIRECTINPUT_VERSION, IID_IDirectInput8W,
                                                   reinterpret_cast<void**>(&input), nullptr));
  require("EnumDevices", input->EnumDevices(DI8DEVCLASS_GAMECTRL, take, nullptr,
                                            DIEDFL_ATTACHEDONLY | DIEDFL_FORCEFEEDBACK));
  if (knob == nullptr) fail("to find a device with forces", 0);
  require("SetDataFormat", knob->SetDataFormat(&c_dfDIJoystick2));
  require("SetCooperativeLevel",
          knob->SetCooperativeLevel(window, DISCL_EXCLUSIVE | DISCL_BACKGROUND));
  require("Acquire", knob->Acquire());
  std::printf("acquired\n");
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    if (!line.empty()) obey(line);
  }
  knob->Unacquire();
  knob->Release();
  input->Release();
  std::printf("done\n");
}
