#include "emulator/plant/profile.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace torsio::emulator {

Profile::Profile(std::vector<ProfileKnot> knots, std::string_view name) : knots_(std::move(knots)) {
  const std::string of = std::string(name) + ": ";
  if (knots_.empty()) throw std::invalid_argument(of + "needs at least one knot");
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    const std::string knot = of + "knot " + std::to_string(i);
    if (!std::isfinite(knots_[i].value)) {
      throw std::invalid_argument(knot + " has a value that is not finite");
    }
    if (i >= 1 && knots_[i].time_ns < knots_[i - 1].time_ns) {
      throw std::invalid_argument(knot + " is earlier than knot " + std::to_string(i - 1));
    }
    if (i >= 2 && knots_[i].time_ns == knots_[i - 2].time_ns) {
      throw std::invalid_argument(knot + " is the third at the same time; a jump needs two");
    }
  }
}

namespace {

std::vector<ProfileKnot> in_plant_time(const torsio::Profile& knots, std::int64_t start_ns,
                                       std::string_view name) {
  constexpr double kLongestS = 1e9;
  std::vector<ProfileKnot> made;
  made.reserve(knots.size());
  for (const Knot& knot : knots) {
    // False for NaN.
    if (!(std::abs(knot.time_s) <= kLongestS)) {
      std::ostringstream text;
      text << name << ": a knot's time_s is " << knot.time_s << ", allowed are -1e9 to 1e9 s";
      throw std::invalid_argument(text.str());
    }
    made.push_back({start_ns + std::llround(knot.time_s * 1e9), knot.value});
  }
  return made;
}

}  // namespace

Profile::Profile(const torsio::Profile& knots, std::int64_t start_ns, std::string_view name)
    : Profile(in_plant_time(knots, start_ns, name), name) {}

ProfileSegment Profile::segment(std::int64_t time_ns) const {
  const auto after = std::upper_bound(
      knots_.begin(), knots_.end(), time_ns,
      [](std::int64_t time, const ProfileKnot& knot) { return time < knot.time_ns; });
  if (after == knots_.begin()) return {kAlwaysNs, after->time_ns, after->value, 0.0};
  const auto before = after - 1;
  if (after == knots_.end()) return {before->time_ns, kForeverNs, before->value, 0.0};
  const double duration_s = 1e-9 * static_cast<double>(after->time_ns - before->time_ns);
  return {before->time_ns, after->time_ns, before->value,
          (after->value - before->value) / duration_s};
}

double Profile::value(std::int64_t time_ns) const { return segment(time_ns).value(time_ns); }

double Profile::slope_per_s(std::int64_t time_ns) const { return segment(time_ns).slope_per_s; }

std::int64_t Profile::next_knot_ns(std::int64_t time_ns) const { return segment(time_ns).end_ns; }

bool Profile::is_continuous() const {
  return std::adjacent_find(knots_.begin(), knots_.end(),
                            [](const ProfileKnot& a, const ProfileKnot& b) {
                              return a.time_ns == b.time_ns;
                            }) == knots_.end();
}

}  // namespace torsio::emulator
