# Each header must compile on its own. With CMAKE_VERIFY_INTERFACE_HEADER_SETS on, as in the preset
# `headers`, the target all_verify_interface_header_sets shows it; the SDK's public headers are the
# SDK's own header set.

# torsio_verify_headers(<folder> <target>...): all headers below a folder of the tree, on the include
# path of the targets.
function(torsio_verify_headers folder)
  if(NOT CMAKE_VERIFY_INTERFACE_HEADER_SETS)
    return()
  endif()
  string(MAKE_C_IDENTIFIER "torsio_headers_${folder}" target)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${folder}/*.hpp")
  add_library(${target} INTERFACE)
  target_sources(${target} INTERFACE
    FILE_SET HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}" FILES ${headers})
  target_link_libraries(${target} INTERFACE ${ARGN})
endfunction()
