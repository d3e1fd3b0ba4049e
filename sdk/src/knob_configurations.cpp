// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
// instead.
#include "torsio/knob_configurations.hpp"

#include "knob_impl.hpp"

namespace torsio {

ActuatorConfig KnobConfigurations::actuator_config() {
  return Knob::Impl::of(*this).config<ActuatorConfig>();
}
void KnobConfigurations::configure(const ActuatorConfig& config) {
  Knob::Impl::of(*this).configure(config);
}
void KnobConfigurations::update(const std::function<void(ActuatorConfig&)>& change) {
  Knob::Impl::update(*this, change);
}

ControlConfig KnobConfigurations::control_config() {
  return Knob::Impl::of(*this).config<ControlConfig>();
}
void KnobConfigurations::configure(const ControlConfig& config) {
  Knob::Impl::of(*this).configure(config);
}
void KnobConfigurations::update(const std::function<void(ControlConfig&)>& change) {
  Knob::Impl::update(*this, change);
}

BoardConfig KnobConfigurations::board_config() {
  return Knob::Impl::of(*this).config<BoardConfig>();
}
void KnobConfigurations::configure(const BoardConfig& config) {
  Knob::Impl::of(*this).configure(config);
}
void KnobConfigurations::update(const std::function<void(BoardConfig&)>& change) {
  Knob::Impl::update(*this, change);
}

GameConfig KnobConfigurations::game_config() { return Knob::Impl::of(*this).config<GameConfig>(); }
void KnobConfigurations::configure(const GameConfig& config) {
  Knob::Impl::of(*this).configure(config);
}
void KnobConfigurations::update(const std::function<void(GameConfig&)>& change) {
  Knob::Impl::update(*this, change);
}

ShaftConfig KnobConfigurations::shaft_config() {
  return Knob::Impl::of(*this).config<ShaftConfig>();
}
void KnobConfigurations::configure(const ShaftConfig& config) {
  Knob::Impl::of(*this).configure(config);
}
void KnobConfigurations::update(const std::function<void(ShaftConfig&)>& change) {
  Knob::Impl::update(*this, change);
}

CalibrationConfig KnobConfigurations::calibration_config() {
  return Knob::Impl::of(*this).config<CalibrationConfig>();
}
void KnobConfigurations::configure(const CalibrationConfig& config) {
  Knob::Impl::of(*this).configure(config);
}
void KnobConfigurations::update(const std::function<void(CalibrationConfig&)>& change) {
  Knob::Impl::update(*this, change);
}

}  // namespace torsio
