// A game with OIS. For each line that it reads it plays one more effect of the first joystick.
#include <ois/OIS.h>

#include <chrono>
#include <iostream>
#include <string>
#include <thread>

namespace {

constexpr short kHalf = 5'000;  // of OIS's 10,000

std::string next_line() {
  std::string line;
  std::getline(std::cin, line);
  return line;
}

void set_half(OIS::ForceEffect* force) {
  if (auto* constant = dynamic_cast<OIS::ConstantEffect*>(force)) constant->level = kHalf;
  if (auto* ramp = dynamic_cast<OIS::RampEffect*>(force)) ramp->endLevel = kHalf;
  if (auto* wave = dynamic_cast<OIS::PeriodicEffect*>(force)) {
    wave->magnitude = kHalf;
    wave->period = 100'000;
  }
  if (auto* condition = dynamic_cast<OIS::ConditionalEffect*>(force)) {
    condition->leftCoeff = condition->rightCoeff = kHalf;
    condition->leftSaturation = condition->rightSaturation = 2 * kHalf;
  }
}

/// Reads until the second button is as it should be.
void wait_for_button(OIS::JoyStick& joystick, bool pressed) {
  while (joystick.getJoyStickState().mButtons.at(1) != pressed) {
    joystick.capture();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace

int main() {
  OIS::ParamList settings{{"WINDOW", "0"}};
  OIS::InputManager* manager = OIS::InputManager::createInputSystem(settings);
  auto* joystick = static_cast<OIS::JoyStick*>(manager->createInputObject(OIS::OISJoyStick, false));
  const OIS::JoyStickState& state = joystick->getJoyStickState();
  std::cout << joystick->vendor() << ", axes " << state.mAxes.size() << std::endl;
  wait_for_button(*joystick, true);
  std::cout << "axis " << state.mAxes.at(0).abs << std::endl;
  wait_for_button(*joystick, false);
  std::cout << "let go" << std::endl;
  auto* forces =
      dynamic_cast<OIS::ForceFeedback*>(joystick->queryInterface(OIS::Interface::ForceFeedback));
  forces->setMasterGain(1.0F);
  for (const auto& [force, type] : forces->getSupportedEffects()) {
    OIS::Effect effect(force, type);
    effect.direction = OIS::Effect::East;
    effect.replay_length = 300'000;
    set_half(effect.getForceEffect());
    next_line();
    forces->upload(&effect);
    std::cout << OIS::Effect::getEffectTypeName(type) << std::endl;
    next_line();
    forces->remove(&effect);
  }
  OIS::InputManager::destroyInputSystem(manager);
}
