#include "emulator/usbip/truth_log.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>

namespace torsio::emulator::usbip {
namespace {

constexpr std::string_view kHeader =
    "time_ns,angle_rad,motor_torque_nm,brake_torque_nm,hand_torque_nm\n";

}  // namespace

TruthLog::TruthLog(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "we")) {
  if (file_ == nullptr) throw std::system_error(errno, std::generic_category(), path_);
  (void)std::fwrite(kHeader.data(), 1, kHeader.size(), file_.get());
  flush();
}

void TruthLog::add(std::span<const TruthSample> samples) {
  for (const TruthSample& sample : samples) {
    std::array<char, 160> line;
    char* at = std::to_chars(line.begin(), line.end(), std::llround(1e9 * sample.time_s)).ptr;
    for (const double value : {sample.angle_rad, sample.motor_torque_nm, sample.brake_torque_nm,
                               sample.hand_torque_nm}) {
      *at++ = ',';
      at = std::to_chars(at, line.end(), value + 0.0).ptr;  // no minus before a zero
    }
    *at++ = '\n';
    (void)std::fwrite(line.data(), 1, static_cast<std::size_t>(at - line.begin()), file_.get());
  }
  if (std::ferror(file_.get()) != 0) {
    throw std::system_error(errno, std::generic_category(), path_);
  }
}

void TruthLog::flush() {
  if (std::fflush(file_.get()) != 0) {
    throw std::system_error(errno, std::generic_category(), path_);
  }
}

}  // namespace torsio::emulator::usbip
