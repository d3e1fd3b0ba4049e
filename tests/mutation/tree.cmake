# The project in build/mutation/tree: the mutated copy of the sources, and the C++ tests with the
# runner instead of doctest's main program. tests/mutation/mutate.py puts it there.
#   TORSIO_MUTANTS       how many there are
#   TORSIO_TINYUSB_PATH  as in emulator/usbip
#   TORSIO_MUTATE_ALL    with the plant's physics and the Python module, for random mutants
cmake_minimum_required(VERSION 3.25)
project(torsio VERSION 0.0.0 LANGUAGES C CXX)

list(APPEND CMAKE_MODULE_PATH "${CMAKE_CURRENT_SOURCE_DIR}/cmake")
include(TorsioTargetDefaults)
include(TorsioHeaders)
include(TorsioHidapi)
find_package(doctest 2.4 CONFIG REQUIRED)
find_package(Threads REQUIRED GLOBAL)

# Mutated lines compare a number with a number, leave parameters unused, and leave arrays.
add_compile_options(-w -g0 -D_GLIBCXX_ASSERTIONS "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-include ${CMAKE_CURRENT_SOURCE_DIR}/switch.hpp>")

# Several files at once compile in a part of the time, as in the preset with sanitizers.
set(CMAKE_UNITY_BUILD ON)
add_subdirectory(firmware/protocol)
add_subdirectory(firmware/core)
add_subdirectory(firmware/device)
include(firmware/boards/list.cmake)
add_subdirectory(emulator)
set(TORSIO_WITH_EMULATOR ON)
add_subdirectory(sdk)

set(tests)
foreach(layer core protocol device emulator usbip sdk)
  if(TARGET torsio_${layer})
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/tests/cpp/${layer}/*.cpp")
    if(NOT TORSIO_MUTATE_ALL)  # it limits nobody
      list(FILTER sources EXCLUDE REGEX "emulator/test_(batch|closed|no_buzz|plant|portable)")
    endif()
    add_library(tests_${layer} OBJECT ${sources})
    list(APPEND tests tests_${layer})
  endif()
endforeach()
set_target_properties(tests_protocol PROPERTIES UNITY_BUILD OFF)
if(TORSIO_MUTATE_ALL)
  add_subdirectory(bindings)
  target_compile_options(_torsio PRIVATE -O0)
  target_sources(_torsio PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/module.cpp")
  set_source_files_properties(module.cpp TARGET_DIRECTORY _torsio PROPERTIES
    COMPILE_DEFINITIONS TORSIO_MUTANTS=${TORSIO_MUTANTS})
endif()

add_executable(torsio_mutants runner.cpp)
foreach(target torsio_mutants ${tests})
  target_compile_features(${target} PRIVATE cxx_std_20)
  # Compiled in half of the time; what takes long to run is in the libraries.
  target_compile_options(${target} PRIVATE -O0)
  target_compile_definitions(${target} PRIVATE
    TORSIO_TEST_DATA_DIR="${CMAKE_CURRENT_SOURCE_DIR}/tests/golden")
  target_include_directories(${target} PRIVATE tests/cpp)
  target_link_libraries(${target} PRIVATE torsio_sdk_internals doctest::doctest Threads::Threads)
  if(TARGET torsio_usbip)
    target_link_libraries(${target} PRIVATE torsio_usbip)
  endif()
endforeach()
target_link_libraries(torsio_mutants PRIVATE ${tests})
# Only there, or one mutant more would compile everything anew.
set_source_files_properties(runner.cpp PROPERTIES
  COMPILE_DEFINITIONS TORSIO_MUTANTS=${TORSIO_MUTANTS})
if(TARGET torsio_usbip)
  # Takes the stack's types. Not by torsio_stack_headers(), which all sources would be compiled with.
  set_source_files_properties(tests/cpp/usbip/test_hid_driver.cpp PROPERTIES
    SKIP_UNITY_BUILD_INCLUSION ON
    INCLUDE_DIRECTORIES "$<TARGET_PROPERTY:torsio_usb_stack,INTERFACE_INCLUDE_DIRECTORIES>"
    COMPILE_DEFINITIONS "$<TARGET_PROPERTY:torsio_usb_stack,INTERFACE_COMPILE_DEFINITIONS>")
endif()
if(TORSIO_MUTATE_ALL)
  add_custom_target(torsio_random DEPENDS torsio_mutants _torsio)
endif()
