# The boards: every folder here that has a board.cmake. Sets TORSIO_BOARDS to their names, and makes
# "boards/all.hpp" with what their headers say for torsio_boards, so that a folder is all that a new
# board takes.
file(GLOB board_files CONFIGURE_DEPENDS "${CMAKE_CURRENT_LIST_DIR}/*/board.cmake")
set(TORSIO_BOARDS "")
set(includes "")
set(checks "")
foreach(file IN LISTS board_files)
  cmake_path(GET file PARENT_PATH folder)
  cmake_path(GET folder FILENAME board)
  list(APPEND TORSIO_BOARDS ${board})
  string(APPEND includes "#include \"boards/${board}/board.hpp\"\n")
  string(APPEND checks "static_assert(${board}::kBoard.name == \"${board}\");\n")
endforeach()
list(TRANSFORM TORSIO_BOARDS APPEND "::kBoard" OUTPUT_VARIABLE all)
list(JOIN all ", " all)

set(boards_folder "${CMAKE_CURRENT_BINARY_DIR}/boards-include")
file(CONFIGURE OUTPUT "${boards_folder}/boards/all.hpp" @ONLY CONTENT [[
// Made by firmware/boards/list.cmake.
#pragma once

#include <array>

@includes@
namespace torsio::boards {

inline constexpr std::array kAll{@all@};
@checks@
}  // namespace torsio::boards
]])
add_library(torsio_boards INTERFACE)
target_include_directories(torsio_boards INTERFACE "$<BUILD_INTERFACE:${boards_folder}>")
torsio_target_defaults(torsio_boards)
target_link_libraries(torsio_boards INTERFACE torsio_device)
