#include "python_values.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <variant>

#include "interpreter.hpp"
#include "torsio/error.hpp"

namespace py = pybind11;

namespace torsio::bindings {
namespace {

/// The package's data classes that stand for the alternatives of a variant.
template <class Variant>
class Classes {
 public:
  static constexpr std::size_t count = std::variant_size_v<Variant>;

  explicit Classes(const char* module_name) {
    // Kept for the process's life: at exit the interpreter may be gone before static objects are.
    const py::module_ module = py::module_::import(module_name);
    for_each([&]<std::size_t I>(std::integral_constant<std::size_t, I>) {
      const auto name = Fields<std::variant_alternative_t<I, Variant>>::name;
      classes_[I] = py::object(module.attr(name.data())).release();
    });
  }

  /// Index of the object's class; `count` if it is not among them. Subclasses count.
  [[nodiscard]] std::size_t find(const py::handle& source) const {
    const py::handle type = py::type::handle_of(source);
    for (std::size_t i = 0; i < count; ++i) {
      if (type.is(classes_[i])) return i;
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (py::isinstance(source, classes_[i])) return i;
    }
    return count;
  }

  [[nodiscard]] Variant convert(const py::handle& source, std::size_t found) const {
    Variant made;
    for_each([&]<std::size_t I>(std::integral_constant<std::size_t, I>) {
      if (found == I) made = from_python<std::variant_alternative_t<I, Variant>>(source);
    });
    return made;
  }

 private:
  template <class Visit>
  static void for_each(Visit&& visit) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      (visit(std::integral_constant<std::size_t, I>{}), ...);
    }(std::make_index_sequence<count>{});
  }

  std::array<py::handle, count> classes_;
};

const Classes<Effect>& effect_classes() {
  static const Classes<Effect> classes("torsio.printed.scenes");
  return classes;
}

const Classes<Hand>& hand_classes() {
  static const Classes<Hand> classes("torsio.printed.hands");
  return classes;
}

thread_local bool in_hand = false;

/// A function's exception in one line: the error and its place.
std::string line_of(const py::error_already_set& error) {
  std::string line;
  for (const char c : std::string(error.what())) {
    if (c != '\n' && c != ' ') {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  return line;
}

}  // namespace

Effect effect_from_python(const py::handle& source) {
  const std::size_t found = effect_classes().find(source);
  if (found < effect_classes().count) return effect_classes().convert(source, found);
  throw py::type_error("not an effect: " + shown(source) + "; give one as torsio.Wall(...)");
}

Scene scene_from_python(const py::handle& source) {
  const bool is_one = effect_classes().find(source) < effect_classes().count ||
                      py::isinstance<py::str>(source) || py::isinstance<py::bytes>(source);
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

std::shared_ptr<py::object> keep(const py::object& source) {
  return {new py::object(source), [](py::object* object) {
            const Locked locked;
            delete object;
          }};
}

bool is_in_hand() { return in_hand; }

HandFunction hand_function_from_python(const py::object& source) {
  return [function = keep(source)](double time_s, double angle_rad, double speed_rad_s) {
    const Locked locked;
    in_hand = true;
    const std::shared_ptr<void> left(nullptr, [](void*) { in_hand = false; });
    try {
      const py::object answer = (*function)(time_s, angle_rad, speed_rad_s);
      const double torque_nm = PyFloat_AsDouble(answer.ptr());
      if (torque_nm == -1.0 && PyErr_Occurred() != nullptr) throw py::error_already_set();
      return torque_nm;
    } catch (const py::error_already_set& error) {
      if (!error.matches(PyExc_Exception)) throw;  // Ctrl-C is not the function's fault
      throw std::runtime_error("the hand's function raised " + line_of(error));
    }
  };
}

Hand hand_from_python(const py::handle& source) {
  if (source.is_none()) return NoHand{};
  const std::size_t found = hand_classes().find(source);
  if (found < hand_classes().count) return hand_classes().convert(source, found);
  throw py::type_error("not a hand: " + shown(source) + "; give one as torsio.TorqueHand(...)");
}

}  // namespace torsio::bindings
