/// @file
/// A torque that comes from outside the scene, asked for once a tick.
#pragma once

#include <cstdint>

#include "core/motion.hpp"

namespace torsio::core {

class ForceSource {
 public:
  /// Torque on the knob that is wanted at this tick, N m. It is shared between motor and brake as
  /// the scene's is.
  virtual float torque_nm(const Motion& motion, const Resolution& resolution,
                          std::uint64_t tick) = 0;

 protected:
  ~ForceSource() = default;
};

}  // namespace torsio::core
