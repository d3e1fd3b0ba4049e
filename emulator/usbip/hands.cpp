#include "emulator/usbip/hands.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace torsio::emulator::usbip {
namespace {

// Two fingers that hold a small knob firmly.
constexpr double kStiffnessNmPerRad = 2.0;
constexpr double kDampingNmSPerRad = 0.02;
constexpr double kInertiaKgM2 = 1e-4;

// Commands come in steps; a hand does not jump from one to the next.
constexpr double kShortestMoveS = 0.05;
constexpr double kFastestRadS = 10.0;

constexpr double kLongestS = 1e6;
constexpr double kLargestRad = 1e6;
constexpr double kLargestNm = 10.0;
constexpr std::size_t kMostBytes = std::size_t{16} << 20U;  // of a script

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// The first word, and what is behind it.
std::pair<std::string_view, std::string_view> split(std::string_view text) {
  const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
  return {text.substr(0, end), trimmed(text.substr(end))};
}

std::optional<double> number(std::string_view text, double limit) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  // The comparison is also false for NaN.
  if (error != std::errc{} || end != text.data() + text.size() || !(std::abs(value) <= limit)) {
    return std::nullopt;
  }
  return value;
}

struct Script {
  std::string kind;
  std::vector<ProfileKnot> knots;
};

/// @returns what is wrong with the first line, empty if nothing; likewise below
std::string read_kind(std::string_view line, Script& script) {
  if (line != "torque_nm" && line != "angle_rad" && line != "motion_rad") {
    return "the first line must be torque_nm, angle_rad or motion_rad";
  }
  script.kind = line;
  return {};
}

/// Checks that a hand can go there from the corners before.
std::string check_way(const std::vector<ProfileKnot>& before, const ProfileKnot& next, bool jumps) {
  if (before.empty()) return {};
  const ProfileKnot& last = before.back();
  if (next.time_ns < last.time_ns) return "is earlier than the line before it";
  if (next.time_ns == last.time_ns) {
    if (!jumps) return "has the time of the line before it; only a torque can jump";
    if (before.size() >= 2 && next.time_ns == before[before.size() - 2].time_ns) {
      return "is the third with the same time; a jump needs two";
    }
  }
  if (!jumps && std::abs(Profile({last, next}).slope_per_s(last.time_ns)) > kMostSpeedRadS) {
    return "is further from the line before it than 1e5 rad/s get in that time";
  }
  return {};
}

std::string read_corner(std::string_view line, Script& script) {
  const auto [time_text, value_text] = split(line);
  const auto time_s = number(time_text, kLongestS);
  if (!time_s) return "needs TIME_S VALUE, and the time is no number within 1e6 s";
  const bool torque = script.kind == "torque_nm";
  const auto value = number(value_text, torque ? kLargestNm : kLargestRad);
  if (!value) {
    return std::string("needs TIME_S VALUE, and the value is no number within ") +
           (torque ? "10 N m" : "1e6 rad");
  }
  const ProfileKnot next{std::llround(*time_s * 1e9), *value};
  if (std::string problem = check_way(script.knots, next, torque); !problem.empty()) return problem;
  script.knots.push_back(next);
  return {};
}

/// @throws BadScript
std::string read_text(std::istream& stream, const std::string& name) {
  std::string text(kMostBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kMostBytes) throw BadScript(name + ": has more than 16 MiB, and no script has");
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // Notepad's mark
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw BadScript(name + ":1: is in UTF-16: save it as UTF-8");
  }
  return text;
}

}  // namespace

Hand still_hand(double angle_rad) { return PrescribedMotion{Profile::constant(angle_rad)}; }

Hand firm_hand(Profile intended_angle_rad) {
  return ImpedanceHand{.inertia_kg_m2 = kInertiaKgM2,
                       .stiffness_nm_per_rad = kStiffnessNmPerRad,
                       .damping_nm_s_per_rad = kDampingNmSPerRad,
                       .intended_angle_rad = std::move(intended_angle_rad)};
}

Hand read_hand(std::istream& stream, const std::string& name, std::int64_t start_ns) {
  std::istringstream lines(read_text(stream, name));
  Script script;
  std::string text;
  std::size_t count = 0;
  const auto fail = [&](const std::string& what) {
    throw BadScript(name + ":" + std::to_string(count) + ": " + what);
  };
  while (std::getline(lines, text)) {
    ++count;
    const std::string_view line = trimmed(std::string_view(text).substr(0, text.find('#')));
    if (line.empty()) continue;
    const std::string problem =
        script.kind.empty() ? read_kind(line, script) : read_corner(line, script);
    if (!problem.empty()) fail(problem);
  }
  if (stream.bad()) fail("cannot be read to its end");
  if (script.knots.empty()) fail("the file ends before its first corner TIME_S VALUE");

  for (ProfileKnot& knot : script.knots) knot.time_ns += start_ns;
  Profile profile(std::move(script.knots));
  if (script.kind == "torque_nm") return TorqueHand{std::move(profile)};
  if (script.kind == "angle_rad") return firm_hand(std::move(profile));
  return PrescribedMotion{std::move(profile)};
}

bool HandCommands::follow(std::string_view line) {
  const auto [word, rest] = split(trimmed(line));
  if (word == "angle") {
    const auto angle_rad = number(rest, kLargestRad);
    if (angle_rad) move_to(*angle_rad);
    return angle_rad.has_value();
  }
  Hand hand = NoHand{};
  if (word == "script") {
    const std::string path(rest);
    std::ifstream script(path);
    try {
      hand = read_hand(script, path, device_.next_tick_ns());
    } catch (const BadScript&) {
      return false;
    }
  } else if (word == "torque") {
    const auto torque_nm = number(rest, kLargestNm);
    if (!torque_nm) return false;
    hand = TorqueHand{Profile::constant(*torque_nm)};
  } else if (word == "still" && rest.empty()) {
    hand = still_hand(device_.plant().state().knob_angle_rad());
  } else if (word != "free" || !rest.empty()) {
    return false;
  }
  holding_ = false;
  device_.set_hand(std::move(hand));
  return true;
}

void HandCommands::move_to(double angle_rad) {
  const std::int64_t now_ns = device_.next_tick_ns();
  const double from_rad = holding_ ? path_.value(now_ns) : device_.plant().state().knob_angle_rad();
  const double duration_s = std::max(kShortestMoveS, std::abs(angle_rad - from_rad) / kFastestRadS);
  path_ = Profile({{now_ns, from_rad}, {now_ns + std::llround(duration_s * 1e9), angle_rad}});
  holding_ = true;
  device_.set_hand(firm_hand(path_));
}

}  // namespace torsio::emulator::usbip
