#include "game/knob.hpp"

#include <stdexcept>
#include <string_view>
#include <utility>

namespace game {
namespace {

constexpr std::pair<Uint32, const char*> kEffectNames[] = {
    {SDL_HAPTIC_CONSTANT, "constant"},
    {SDL_HAPTIC_RAMP, "ramp"},
    {SDL_HAPTIC_SINE, "sine"},
    {SDL_HAPTIC_TRIANGLE, "triangle"},
    {SDL_HAPTIC_SAWTOOTHUP, "sawtooth up"},
    {SDL_HAPTIC_SAWTOOTHDOWN, "sawtooth down"},
    {SDL_HAPTIC_SPRING, "spring"},
    {SDL_HAPTIC_DAMPER, "damper"},
    {SDL_HAPTIC_INERTIA, "inertia"},
    {SDL_HAPTIC_FRICTION, "friction"},
    {SDL_HAPTIC_GAIN, "gain"},
    {SDL_HAPTIC_AUTOCENTER, "autocenter"},
};

std::string name_of(int index) {
  const char* name = SDL_JoystickNameForIndex(index);
  return name == nullptr ? "(no name)" : name;
}

std::string quoted(std::string_view text) {
  std::string json = "\"";
  for (const char character : text) {
    if (character == '"' || character == '\\') json += '\\';
    json += static_cast<unsigned char>(character) < 0x20 ? ' ' : character;
  }
  return json + '"';
}

}  // namespace

std::unique_ptr<Knob> Knob::open(std::optional<int> index, AxisScale scale, bool haptic) {
  const int count = SDL_NumJoysticks();
  if (index && *index >= count) {
    throw std::runtime_error("there is no joystick " + std::to_string(*index) +
                             "; --list shows those that there are");
  }
  for (int i = 0; i < count && !index; ++i) {
    if (name_of(i).find("Torsio") != std::string::npos) index = i;
  }
  if (!index) return nullptr;
  SDL_Joystick* joystick = SDL_JoystickOpen(*index);
  if (joystick == nullptr) {
    throw std::runtime_error("cannot open joystick " + std::to_string(*index) + ": " +
                             SDL_GetError());
  }
  return std::unique_ptr<Knob>(new Knob(joystick, scale, haptic));
}

Knob::Knob(SDL_Joystick* joystick, AxisScale scale, bool haptic)
    : joystick_(joystick), scale_(scale), haptics_(haptic ? joystick : nullptr, scale) {
  const char* name = SDL_JoystickName(joystick);
  if (name != nullptr) name_ = name;
}

std::string Knob::missing() const {
  std::string names;
  for (const Haptics::Effect& effect : haptics_.effects()) {
    if (effect.id < 0) names += (names.empty() ? "" : ", ") + std::string(effect.name);
  }
  return names;
}

void Knob::report(std::ostream& to) const {
  to << "{\"name\": " << quoted(name_) << ", \"axes\": " << SDL_JoystickNumAxes(joystick_.get())
     << ", \"buttons\": " << SDL_JoystickNumButtons(joystick_.get())
     << ", \"haptic\": " << (haptics_.works() ? "true" : "false") << ", \"effects\": {";
  const char* separator = "";
  for (const Haptics::Effect& effect : haptics_.effects()) {
    to << separator << quoted(effect.name)
       << ": {\"uploaded\": " << (effect.id >= 0 ? "true" : "false")
       << ", \"updates\": " << effect.updates << ", \"starts\": " << effect.starts << '}';
    separator = ", ";
  }
  to << "}, \"errors\": [";
  separator = "";
  for (const std::string& error : haptics_.errors()) {
    to << separator << quoted(error);
    separator = ", ";
  }
  to << "]}";
}

void list_joysticks(std::ostream& to) {
  const int count = SDL_NumJoysticks();
  if (count == 0) to << "no joystick\n";
  for (int i = 0; i < count; ++i) {
    to << i << ": " << name_of(i) << '\n';
    SDL_Joystick* joystick = SDL_JoystickOpen(i);
    SDL_Haptic* haptic = joystick == nullptr ? nullptr : SDL_HapticOpenFromJoystick(joystick);
    if (haptic == nullptr) {
      to << "   no force feedback (" << SDL_GetError() << ")\n";
    } else {
      to << "   " << SDL_HapticNumEffects(haptic) << " effects of the kinds:";
      for (const auto& [bit, name] : kEffectNames) {
        if ((SDL_HapticQuery(haptic) & bit) != 0) to << ' ' << name << ',';
      }
      to << " axes: " << SDL_HapticNumAxes(haptic) << '\n';
      SDL_HapticClose(haptic);
    }
    if (joystick != nullptr) SDL_JoystickClose(joystick);
  }
}

}  // namespace game
