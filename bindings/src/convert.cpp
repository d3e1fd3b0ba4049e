#include "convert.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "attributes.hpp"
#include "plant_convert.hpp"
#include "torsio/error.hpp"

namespace py = pybind11;

namespace torsio::bindings {
namespace {

constexpr std::array<std::string_view, 2> side_names{"above", "below"};
constexpr std::array<std::string_view, 5> waveform_names{"sine", "square", "triangle",
                                                         "sawtooth_up", "sawtooth_down"};
constexpr std::array<std::string_view, 3> detent_profile_names{"sine", "linear", "click"};
constexpr std::array<std::string_view, 4> grain_names{"sine", "square", "triangle", "noise"};
constexpr std::array<std::string_view, 2> ends_names{"hold", "repeat"};
constexpr std::array<std::string_view, 4> law_names{"paper", "compensated", "parallel",
                                                    "motor_only"};

Timing timing_from_python(const Attributes& effect) {
  const py::object source = effect.get("timing");
  const Attributes timing(source);
  return {timing.number("delay_s"),  timing.number("duration_s"), timing.number("attack_level"),
          timing.number("attack_s"), timing.number("fade_level"), timing.number("fade_s")};
}

Effect wall(const Attributes& from) {
  return Wall{from.number("angle_rad"), from.number("stiffness_nm_per_rad"),
              from.number("damping_nm_s_per_rad"), from.choice<Side>("side", side_names)};
}

Effect spring(const Attributes& from) {
  return Spring{from.number("angle_rad"), from.number("stiffness_nm_per_rad"),
                from.number("deadband_rad"), from.number("torque_limit_nm")};
}

Effect damper(const Attributes& from) {
  return Damper{from.number("damping_nm_s_per_rad"), from.number("torque_limit_nm")};
}

Effect friction(const Attributes& from) {
  return Friction{from.number("torque_nm"), from.number("stiffness_nm_per_rad")};
}

Effect inertia(const Attributes& from) {
  return Inertia{from.number("inertia_kg_m2"), from.number("torque_limit_nm")};
}

Effect constant(const Attributes& from) {
  return Constant{from.number("torque_nm"), timing_from_python(from)};
}

Effect ramp(const Attributes& from) {
  return Ramp{from.number("start_torque_nm"), from.number("end_torque_nm"),
              timing_from_python(from)};
}

Effect periodic(const Attributes& from) {
  return Periodic{from.choice<Waveform>("waveform", waveform_names),
                  from.number("amplitude_nm"),
                  from.number("offset_nm"),
                  from.number("frequency_hz"),
                  from.number("phase_turns"),
                  timing_from_python(from)};
}

Effect detents(const Attributes& from) {
  return Detents{from.optional_number("per_turn"),
                 from.optional_number("pitch_rad"),
                 from.number("torque_nm"),
                 from.number("angle_rad"),
                 from.choice<DetentProfile>("profile", detent_profile_names),
                 from.number("width")};
}

Effect end_stops(const Attributes& from) {
  return EndStops{from.number("lower_rad"), from.number("upper_rad"),
                  from.number("stiffness_nm_per_rad"), from.number("damping_nm_s_per_rad")};
}

Effect texture(const Attributes& from) {
  return Texture{from.integer<int>("grains_per_turn"), from.number("torque_nm"),
                 from.choice<Grain>("grain", grain_names), from.integer<std::uint32_t>("seed")};
}

Effect curve(const Attributes& from) {
  Curve curve{
      {}, from.number("angle_rad"), from.number("span_rad"), from.choice<Ends>("ends", ends_names)};
  const py::object points = from.get("torque_nm");
  for (const py::handle point : points) {
    curve.torque_nm.push_back(from.as_number(point, "torque_nm"));
  }
  return curve;
}

struct Converter {
  const char* class_name;
  Effect (*convert)(const Attributes&);
};

constexpr std::array<Converter, 12> converters{{
    {"Wall", wall},
    {"Spring", spring},
    {"Damper", damper},
    {"Friction", friction},
    {"Inertia", inertia},
    {"Constant", constant},
    {"Ramp", ramp},
    {"Periodic", periodic},
    {"Detents", detents},
    {"EndStops", end_stops},
    {"Texture", texture},
    {"Curve", curve},
}};

/// The package's classes, in the order of `converters`.
const std::array<py::handle, converters.size()>& effect_classes() {
  // Kept for the process's life: at exit the interpreter may be gone before static objects are.
  static const auto classes = [] {
    const py::module_ scenes = py::module_::import("torsio.scenes");
    std::array<py::handle, converters.size()> found;
    for (std::size_t i = 0; i < found.size(); ++i) {
      found[i] = py::object(scenes.attr(converters[i].class_name)).release();
    }
    return found;
  }();
  return classes;
}

/// Index of the effect's class in `converters`; their number if it is none. Subclasses count.
std::size_t find_converter(const py::handle& source) {
  const auto& classes = effect_classes();
  const py::handle type = py::type::handle_of(source);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (type.is(classes[i])) return i;
  }
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (py::isinstance(source, classes[i])) return i;
  }
  return classes.size();
}

}  // namespace

Effect effect_from_python(const py::handle& source) {
  const std::size_t found = find_converter(source);
  if (found < converters.size()) return converters[found].convert(Attributes(source));
  throw py::type_error("not an effect: " + py::repr(source).cast<std::string>() +
                       " (see torsio.scenes for those that there are)");
}

Scene scene_from_python(const py::handle& source) {
  const bool is_one = find_converter(source) < converters.size();
  if (is_one || !py::isinstance<py::iterable>(source)) return {effect_from_python(source)};
  Scene scene;
  for (const py::handle effect : py::reinterpret_borrow<py::object>(source)) {
    scene.push_back(effect_from_python(effect));
  }
  return scene;
}

Profile profile_from_python(const py::handle& source) {
  Profile profile;
  for (const py::handle item : py::reinterpret_borrow<py::object>(source)) {
    const auto knot = py::reinterpret_borrow<py::object>(item).cast<py::sequence>();
    if (knot.size() != 2) throw InvalidArgument("a profile's knot must be (time_s, value)");
    profile.push_back({py::float_(knot[0]), py::float_(knot[1])});
  }
  return profile;
}

Hand hand_from_python(const py::handle& source) {
  if (source.is_none()) return NoHand{};
  const Attributes from(source);
  if (from.class_name() == "NoHand") return NoHand{};
  if (from.class_name() == "TorqueHand") {
    return TorqueHand{profile_from_python(from.get("torque_nm"))};
  }
  if (from.class_name() == "ImpedanceHand") {
    return ImpedanceHand{from.number("inertia_kg_m2"), from.number("stiffness_nm_per_rad"),
                         from.number("damping_nm_s_per_rad"),
                         profile_from_python(from.get("intended_angle_rad"))};
  }
  if (from.class_name() == "PrescribedMotion") {
    return PrescribedMotion{profile_from_python(from.get("angle_rad"))};
  }
  throw py::type_error("not a hand: " + py::repr(source).cast<std::string>() +
                       " (see torsio.hands for those that there are)");
}

PlantParams plant_from_python(const py::handle& source) {
  const Attributes from(source);
  PlantParams plant;
  read_plant(from, plant);
  plant.counts_per_rev = from.integer<std::uint32_t>("counts_per_rev");
  plant.encoder_rounding = from.choice<EncoderRounding>("encoder_rounding", rounding_names);
  plant.encoder_phase_counts = from.number("encoder_phase_counts");
  plant.encoder_noise_counts = from.number("encoder_noise_counts");
  return plant;
}

ActuatorConfig actuator_config_from_python(const py::handle& source) {
  const Attributes from(source);
  return {from.number("motor_torque_max_nm"),
          from.number("brake_torque_max_nm"),
          from.number("brake_torque_min_nm"),
          from.number("brake_drag_nm"),
          from.number("brake_time_constant_s"),
          from.number("spring_stiffness_nm_per_rad"),
          from.integer<std::uint32_t>("counts_per_rev"),
          from.integer<int>("counter_bits"),
          from.boolean("encoder_reversed"),
          from.number("knob_inertia_kg_m2"),
          from.number("knob_coulomb_nm"),
          from.number("knob_viscous_nm_s_per_rad"),
          from.number("motor_time_constant_s")};
}

BoardConfig board_config_from_python(const py::handle& source) {
  const Attributes from(source);
  return {from.number("supply_v"),
          from.number("motor_torque_constant_nm_per_a"),
          from.number("motor_current_max_a"),
          from.number("motor_resistance_ohm"),
          from.number("motor_inductance_h"),
          from.number("current_bandwidth_hz"),
          from.number("current_sense_v_per_a"),
          from.number("brake_torque_constant_nm_per_a"),
          from.number("brake_current_max_a"),
          from.number("brake_resistance_ohm"),
          from.boolean("motor_reversed"),
          from.integer<int>("encoder_pin"),
          from.integer<int>("motor_pin"),
          from.integer<int>("brake_pin"),
          from.integer<int>("enable_pin"),
          from.integer<int>("emergency_stop_pin"),
          from.integer<int>("driver_fault_pin"),
          from.integer<int>("current_sense_pin"),
          from.integer<int>("light_pin")};
}

GameConfig game_config_from_python(const py::handle& source) {
  const Attributes from(source);
  return {from.boolean("enabled"),
          from.number("range_deg"),
          from.number("torque_max_nm"),
          from.number("gain"),
          from.number("spring_gain"),
          from.number("speed_full_rad_s"),
          from.number("acceleration_full_rad_s2"),
          from.number("blend_s"),
          from.number("silence_s")};
}

ControlConfig control_config_from_python(const py::handle& source) {
  const Attributes from(source);
  return {from.choice<Law>("law", law_names), from.number("beta"),
          from.number("speed_bandwidth_hz"),  from.number("motor_torque_cap_nm"),
          from.number("brake_torque_cap_nm"), from.number("motor_slew_nm_per_s"),
          from.number("speed_limit_rad_s"),   from.number("watchdog_s"),
          from.number("passive_ramp_s"),      from.number("passive_brake_nm"),
          from.boolean("autonomous")};
}

py::dict to_python(const ActuatorConfig& config) {
  py::dict dict;
  dict["motor_torque_max_nm"] = config.motor_torque_max_nm;
  dict["brake_torque_max_nm"] = config.brake_torque_max_nm;
  dict["brake_torque_min_nm"] = config.brake_torque_min_nm;
  dict["brake_drag_nm"] = config.brake_drag_nm;
  dict["brake_time_constant_s"] = config.brake_time_constant_s;
  dict["spring_stiffness_nm_per_rad"] = config.spring_stiffness_nm_per_rad;
  dict["counts_per_rev"] = config.counts_per_rev;
  dict["counter_bits"] = config.counter_bits;
  dict["encoder_reversed"] = config.encoder_reversed;
  dict["knob_inertia_kg_m2"] = config.knob_inertia_kg_m2;
  dict["knob_coulomb_nm"] = config.knob_coulomb_nm;
  dict["knob_viscous_nm_s_per_rad"] = config.knob_viscous_nm_s_per_rad;
  dict["motor_time_constant_s"] = config.motor_time_constant_s;
  return dict;
}

py::dict to_python(const BoardConfig& config) {
  py::dict dict;
  dict["supply_v"] = config.supply_v;
  dict["motor_torque_constant_nm_per_a"] = config.motor_torque_constant_nm_per_a;
  dict["motor_current_max_a"] = config.motor_current_max_a;
  dict["motor_resistance_ohm"] = config.motor_resistance_ohm;
  dict["motor_inductance_h"] = config.motor_inductance_h;
  dict["current_bandwidth_hz"] = config.current_bandwidth_hz;
  dict["current_sense_v_per_a"] = config.current_sense_v_per_a;
  dict["brake_torque_constant_nm_per_a"] = config.brake_torque_constant_nm_per_a;
  dict["brake_current_max_a"] = config.brake_current_max_a;
  dict["brake_resistance_ohm"] = config.brake_resistance_ohm;
  dict["motor_reversed"] = config.motor_reversed;
  dict["encoder_pin"] = config.encoder_pin;
  dict["motor_pin"] = config.motor_pin;
  dict["brake_pin"] = config.brake_pin;
  dict["enable_pin"] = config.enable_pin;
  dict["emergency_stop_pin"] = config.emergency_stop_pin;
  dict["driver_fault_pin"] = config.driver_fault_pin;
  dict["current_sense_pin"] = config.current_sense_pin;
  dict["light_pin"] = config.light_pin;
  return dict;
}

py::dict to_python(const GameConfig& config) {
  py::dict dict;
  dict["enabled"] = config.enabled;
  dict["range_deg"] = config.range_deg;
  dict["torque_max_nm"] = config.torque_max_nm;
  dict["gain"] = config.gain;
  dict["spring_gain"] = config.spring_gain;
  dict["speed_full_rad_s"] = config.speed_full_rad_s;
  dict["acceleration_full_rad_s2"] = config.acceleration_full_rad_s2;
  dict["blend_s"] = config.blend_s;
  dict["silence_s"] = config.silence_s;
  return dict;
}

py::dict to_python(const ControlConfig& config) {
  py::dict dict;
  dict["law"] = std::string(law_names[static_cast<std::size_t>(config.law)]);
  dict["beta"] = config.beta;
  dict["speed_bandwidth_hz"] = config.speed_bandwidth_hz;
  dict["motor_torque_cap_nm"] = config.motor_torque_cap_nm;
  dict["brake_torque_cap_nm"] = config.brake_torque_cap_nm;
  dict["motor_slew_nm_per_s"] = config.motor_slew_nm_per_s;
  dict["speed_limit_rad_s"] = config.speed_limit_rad_s;
  dict["watchdog_s"] = config.watchdog_s;
  dict["passive_ramp_s"] = config.passive_ramp_s;
  dict["passive_brake_nm"] = config.passive_brake_nm;
  dict["autonomous"] = config.autonomous;
  return dict;
}

py::dict to_python(const ListedDevice& device) {
  py::dict dict;
  dict["path"] = device.path;
  dict["serial"] = device.serial;
  dict["product"] = device.product;
  dict["board"] = device.board;
  dict["transport"] = device.transport;
  dict["problem"] = device.problem;
  return dict;
}

}  // namespace torsio::bindings
