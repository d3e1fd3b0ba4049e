// torsio._torsio.protocol: every report as a dict and as bytes, through the same codec that the
// device and the SDK use.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "bytes.hpp"
#include "module.hpp"
#include "protocol/codec.hpp"
#include "protocol/registry.hpp"
#include "protocol/usb_ids.hpp"

namespace torsio::bindings {
namespace {

using protocol::Array;
using protocol::Enumeration;
using protocol::Layout;
using protocol::Structure;

py::str to_str(std::string_view text) { return {text.data(), text.size()}; }

template <class T>
py::object plain(const T& value) {
  if constexpr (Array<T>) {
    py::list list;
    for (const auto& element : value) list.append(plain(element));
    return list;
  } else if constexpr (Structure<T>) {
    py::dict dict;
    Layout<T>::fields.apply([&](const auto&... field) {
      ((dict[to_str(field.name)] = plain(value.*field.member)), ...);
    });
    return dict;
  } else if constexpr (Enumeration<T>) {
    const auto& names = protocol::Enumerators<T>::names;
    const auto index = static_cast<std::size_t>(value);
    // An open enumeration may have values without a name in this build.
    return index < names.size() ? py::object(to_str(names[index])) : py::object(py::int_(index));
  } else if constexpr (std::is_floating_point_v<T>) {
    return py::float_(value);
  } else {
    return py::int_(value);
  }
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw py::value_error("field '" + path + "': " + why);
}

/// A value of a report; `path` names it in errors. Arrays and structures have others in them.
template <class T>
void wire_from_python(T& value, const py::handle& source, const std::string& path) {
  if constexpr (std::is_floating_point_v<T>) {
    const double number = PyFloat_AsDouble(source.ptr());
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
    value = static_cast<T>(number);
  } else {
    const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(source.ptr()));
    if (!index) throw py::error_already_set();
    // Python integers have no size; the wire's do.
    const bool fits = py::bool_(py::int_(std::numeric_limits<T>::min()) <= index) &&
                      py::bool_(index <= py::int_(std::numeric_limits<T>::max()));
    if (!fits) refuse(path, "does not fit into " + std::string(protocol::type_name<T>()));
    value = index.cast<T>();
  }
}

template <Enumeration T>
void wire_from_python(T& value, const py::handle& source, const std::string& path) {
  const auto& names = protocol::Enumerators<T>::names;
  const std::string name = py::bytes(py::str(source).attr("encode")("utf-8", "backslashreplace"));
  std::string allowed;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) {
      value = static_cast<T>(i);
      return;
    }
    allowed += (allowed.empty() ? "'" : ", '") + std::string(names[i]) + "'";
  }
  refuse(path, "must be one of " + allowed + ", is '" + name + "'");
}

template <Structure T>
void wire_from_python(T& value, const py::handle& source, const std::string& path);

template <Array T>
void wire_from_python(T& value, const py::handle& source, const std::string& path) {
  const auto list = py::reinterpret_borrow<py::object>(source).cast<py::sequence>();
  if (list.size() != value.size()) {
    refuse(path,
           "needs " + std::to_string(value.size()) + " values, has " + std::to_string(list.size()));
  }
  for (std::size_t i = 0; i < value.size(); ++i) {
    wire_from_python(value[i], py::object(list[i]), path + "[" + std::to_string(i) + "]");
  }
}

template <Structure T>
void wire_from_python(T& value, const py::handle& source, const std::string& path) {
  if (!py::isinstance<py::dict>(source)) refuse(path, "needs a dict");
  std::size_t known = 0;
  const auto dict = py::reinterpret_borrow<py::dict>(source);
  const auto one = [&](const auto& field) {
    const py::str key = to_str(field.name);
    if (!dict.contains(key)) return;
    ++known;
    const std::string prefix = path.empty() ? "" : path + ".";
    wire_from_python(value.*field.member, dict[key], prefix + std::string(field.name));
  };
  Layout<T>::fields.apply([&](const auto&... field) { (one(field), ...); });
  if (known != dict.size()) {
    refuse(path.empty() ? "report" : path, "unknown names in " + std::string(py::repr(dict)));
  }
}

py::bytes encode(const std::string& name, const py::dict& values) {
  std::optional<py::bytes> bytes;
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    if (Layout<Report>::name != name) return;
    Report report;
    wire_from_python(report, values, "");
    bytes = to_bytes(protocol::encode(report));
  });
  if (!bytes) throw py::value_error("there is no report '" + name + "'");
  return *bytes;
}

struct Decoded {
  py::object name = py::none();
  py::dict values;
  protocol::Verdict verdict{protocol::Status::unknown_report};
};

Decoded decode_any(std::span<const std::uint8_t> bytes) {
  Decoded decoded;
  if (bytes.size() != protocol::report_size) {
    decoded.verdict = {protocol::Status::bad_length};
    return decoded;
  }
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    if (Layout<Report>::id != bytes[0]) return;
    Report report{};
    decoded.name = to_str(Layout<Report>::name);
    decoded.verdict = protocol::decode(bytes, report);
    if (decoded.verdict.ok()) {
      decoded.values = plain(report);
    }
  });
  return decoded;
}

py::tuple decode(const py::bytes& data) {
  const Decoded decoded = decode_any(bytes_of(data));
  const protocol::Verdict verdict = decoded.verdict;
  py::object field = py::none();
  if (verdict.field != protocol::kNoField) field = py::int_(verdict.field);
  return py::make_tuple(decoded.name, decoded.values, static_cast<int>(verdict.status), field);
}

template <class Owner, class T>
py::dict describe_field(const protocol::Field<Owner, T>& field) {
  using Element = typename protocol::ArrayTraits<T>::Element;
  py::dict dict;
  dict["name"] = to_str(field.name);
  dict["type"] = to_str(protocol::type_name<Element>());
  dict["unit"] = to_str(field.unit);
  dict["doc"] = to_str(field.doc);
  if constexpr (Array<T>) {
    dict["count"] = protocol::ArrayTraits<T>::size;
  } else {
    dict["count"] = 1;
  }
  if constexpr (Structure<Element>) {
    py::list fields;
    Layout<Element>::fields.apply(
        [&](const auto&... inner) { (fields.append(describe_field(inner)), ...); });
    dict["fields"] = fields;
  } else if constexpr (Enumeration<Element>) {
    py::list names;
    for (const std::string_view name : protocol::Enumerators<Element>::names) {
      names.append(to_str(name));
    }
    dict["choices"] = names;
  } else {
    dict["min"] = plain(field.min);
    dict["max"] = plain(field.max);
  }
  return dict;
}

py::list reports() {
  constexpr std::array<std::string_view, 3> directions{"input", "output", "feature"};
  py::list list;
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    py::list fields;
    Layout<Report>::fields.apply(
        [&](const auto&... field) { (fields.append(describe_field(field)), ...); });
    py::dict dict;
    dict["name"] = to_str(Layout<Report>::name);
    dict["id"] = Layout<Report>::id;
    dict["direction"] = to_str(directions[static_cast<std::size_t>(Layout<Report>::direction)]);
    dict["doc"] = to_str(Layout<Report>::doc);
    dict["wire_size"] = protocol::wire_size<Report>();
    dict["fields"] = fields;
    list.append(dict);
  });
  return list;
}

}  // namespace

void bind_protocol(py::module_& parent) {
  py::module_ module = parent.def_submodule("protocol", "Reports as dicts and as bytes.");
  module.attr("REPORT_SIZE") = protocol::report_size;
  module.attr("VERSION") = protocol::protocol_version;
  module.attr("RELEASED_FINGERPRINTS") = py::tuple(py::cast(protocol::released_fingerprints));
  module.attr("USB_VENDOR_ID") = protocol::usb_vendor_id;
  module.attr("USB_PRODUCT_ID") = protocol::usb_product_id;
  module.def(
      "fingerprint", [] { return protocol::fingerprint(); }, "Hash of every report's layout.");
  module.def("reports", &reports, "Description of every report, as data.");
  module.def("encode", &encode, py::arg("report"), py::arg("values"),
             "Bytes of a report. Fields not given keep their defaults; ranges are not checked.");
  module.def("decode", &decode, py::arg("data"),
             "Name or None, values, status code and field index or None.");
}

}  // namespace torsio::bindings
