/// @file
/// Whether what plays may swing or hum; see conversion/swings.hpp.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "conversion/swings.hpp"
#include "requests.hpp"
#include "torsio/error.hpp"
#include "torsio/scene.hpp"

namespace torsio {

/// Every member may be called from any thread.
class SwingWarnings {
 public:
  using Reports = std::vector<protocol::ReportBytes>;

  SwingWarnings(Requests& requests, std::uint32_t control_period_ns)
      : requests_(requests), control_period_ns_(control_period_ns) {}

  /// What plays from here on. @returns whether the host moves it: no law bounds that
  bool keep(const Reports& scene) {
    const std::lock_guard lock(mutex_);
    const bool in_place =
        scene != scene_ && std::ranges::equal(scene, scene_, {}, &kind_of, &kind_of);
    changes_ = in_place ? changes_ + 1U : 0U;
    scene_ = scene;
    streamed_ = {};
    // A judgement takes a while, and the host may move it a thousand times a second.
    return changes_ >= kMoves && std::has_single_bit(changes_);
  }

  /// A local model plays too. @returns as of_all(); empty for one that is not more than another was
  std::string of(const LocalModel& model, const protocol::ReportBytes& report) {
    Reports reports;
    {
      const std::lock_guard lock(mutex_);
      // Sent a thousand times a second.
      double& stiffness = streamed_.stiffness_nm_per_rad;
      double& damping = streamed_.damping_nm_s_per_rad;
      if (model.stiffness_nm_per_rad <= stiffness && model.damping_nm_s_per_rad <= damping) {
        return {};
      }
      stiffness = std::max(stiffness, model.stiffness_nm_per_rad);
      damping = std::max(damping, model.damping_nm_s_per_rad);
      reports = scene_;
    }
    reports.push_back(report);
    return of_all(reports);
  }

  /// @returns the warning, empty if there is none
  std::string of_all(const Reports& reports, bool moves = false) {
    std::shared_ptr<Configs> configs;
    {
      const std::lock_guard lock(mutex_);
      configs = configs_;
    }
    if (!configs) {
      try {
        configs = std::make_shared<Configs>();
        configs->actuator = requests_.get<protocol::ActuatorConfig>();
        configs->control = requests_.get<protocol::ControlConfig>();
      } catch (const Interrupted&) {
        throw;
      } catch (const Error&) {  // the scene plays; what cannot be judged is no failure of it
        return {};
      }
      const std::lock_guard lock(mutex_);
      configs_ = configs;
    }
    return conversion::swing_warning(reports, configs->actuator, configs->control,
                                     control_period_ns_, configs->rests_nm_per_rad, moves);
  }

  void forget_configurations() {
    const std::lock_guard lock(mutex_);
    configs_.reset();
  }

 private:
  /// So many changes of the same effects in a row.
  static constexpr std::uint32_t kMoves = 4;

  static std::uint8_t kind_of(const protocol::ReportBytes& report) { return report[0]; }

  struct Configs {
    protocol::ActuatorConfig actuator;
    protocol::ControlConfig control;
    std::atomic<double> rests_nm_per_rad{-1.0};
  };

  Requests& requests_;
  const std::uint32_t control_period_ns_;
  std::mutex mutex_;  // guards all below, and is not held while the device is asked
  std::shared_ptr<Configs> configs_;
  Reports scene_;
  std::uint32_t changes_ = 0;  // of the same effects, in a row
  LocalModel streamed_;        // most stiffness and damping since the scene began
};

}  // namespace torsio
