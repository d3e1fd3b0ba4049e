/// @file
/// A knob's configurations, one by one.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <functional>

#include "torsio/config.hpp"
#include "torsio/export.hpp"

namespace torsio {

/// The members of a Knob that are about one configuration each.
class TORSIO_EXPORT KnobConfigurations {
 public:
  /// The device's present values.
  [[nodiscard]] ActuatorConfig actuator_config();
  [[nodiscard]] ControlConfig control_config();          ///< as above
  [[nodiscard]] BoardConfig board_config();              ///< as above
  [[nodiscard]] GameConfig game_config();                ///< as above
  [[nodiscard]] ShaftConfig shaft_config();              ///< as above
  [[nodiscard]] CalibrationConfig calibration_config();  ///< as above
  /// Sets a whole configuration: fields that were left at their defaults take these, whatever the
  /// device had. To change some and keep the rest there is update(). Another counts_per_rev also
  /// empties the scene; a board's wiring takes effect when the device starts the next time, if it
  /// was saved. A calibration is of the values of actuator and shaft that the device has now.
  /// @throws InvalidArgument that names the field, also for a pin with two jobs; Refused
  /// (not_disarmed)
  void configure(const ActuatorConfig& config);
  void configure(const ControlConfig& config);      ///< as above
  void configure(const BoardConfig& config);        ///< as above
  void configure(const GameConfig& config);         ///< as above
  void configure(const ShaftConfig& config);        ///< as above
  void configure(const CalibrationConfig& config);  ///< as above
  /// Changes fields of a configuration and keeps the rest: `knob.update([](ControlConfig& control)
  /// { control.law = Law::compensated; })`. The type that `change` takes says which one.
  /// @throws as configure(), and what `change` throws
  void update(const std::function<void(ActuatorConfig&)>& change);
  void update(const std::function<void(ControlConfig&)>& change);      ///< as above
  void update(const std::function<void(BoardConfig&)>& change);        ///< as above
  void update(const std::function<void(GameConfig&)>& change);         ///< as above
  void update(const std::function<void(ShaftConfig&)>& change);        ///< as above
  void update(const std::function<void(CalibrationConfig&)>& change);  ///< as above

 protected:
  KnobConfigurations() = default;
};

}  // namespace torsio
