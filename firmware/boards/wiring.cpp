// Prints the table of pins and electrical values in docs/hardware.md, from the field list that the
// firmware is compiled with.
#include <iostream>
#include <string>
#include <string_view>
#include <tuple>

#include "protocol/configuration.hpp"

int main() {
  using namespace torsio::protocol;
  const BoardConfig defaults;
  std::cout << "| field | default | unit | what |\n|---|---|---|---|\n";
  const auto row = [&](const auto& field) {
    using Value = typename std::remove_cvref_t<decltype(field)>::Value;
    const std::string_view name = field.name;
    if (name == "sequence" || name == "axis") return;
    std::cout << "| `" << name << "` | ";
    if constexpr (Enumeration<Value>) {
      std::cout << Enumerators<Value>::names[static_cast<std::size_t>(defaults.*field.member)];
    } else if constexpr (sizeof(Value) == 1) {
      std::cout << "GP" << +(defaults.*field.member);
    } else {
      std::cout << defaults.*field.member;
    }
    std::cout << " | " << field.unit << " | " << field.doc << " |\n";
  };
  std::apply([&](const auto&... field) { (row(field), ...); }, Layout<BoardConfig>::fields);
}
