/// @file
/// The fields of a user's structure as a list whose entries are constants.
#pragma once

#include "protocol/field_list.hpp"
#include "torsio/fields.hpp"

namespace torsio::conversion {

template <class Host>
inline constexpr auto host_fields =
    Fields<Host>::apply([](const auto&... field) { return protocol::FieldList{field...}; });

}  // namespace torsio::conversion
