# Compiler flags, set on targets and never on directories, so that a microcontroller's toolchain
# file keeps the last word over its own objects.

# torsio_target_defaults(<target>): C++20, warnings, sanitizers. Call it once for every target.
# A library named torsio_x also gets the alias torsio::x and is exported under that name.
function(torsio_target_defaults target)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "INTERFACE_LIBRARY")
    target_compile_features(${target} INTERFACE cxx_std_20)
  else()
    target_compile_features(${target} PUBLIC cxx_std_20)
    set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
    # Without contracted multiply-adds every processor and compiler computes the same bits.
    target_compile_options(${target} PRIVATE
      -Wall -Wextra -Wpedantic -Wconversion -Wshadow -ffp-contract=off
      # A list of fields is a row of bases, whose own braces say nothing.
      "$<$<CXX_COMPILER_ID:Clang>:-Wno-missing-braces>")
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
      # They take the unset half of a std::optional for a mistake, and a short string for an overlap.
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized -Wno-restrict)
    endif()
    if(TORSIO_WERROR)
      target_compile_options(${target} PRIVATE -Werror)
    endif()
    if(TORSIO_SANITIZE)
      target_compile_options(${target} PRIVATE
        -fsanitize=${TORSIO_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
      target_link_options(${target} PUBLIC -fsanitize=${TORSIO_SANITIZE})
      # The address sanitizer finds what these would, and they take half of the time to compile.
      # Alignment matters in what runs on boards: see below.
      if(TORSIO_SANITIZE MATCHES "address,undefined")
        target_compile_options(${target} PRIVATE -fno-sanitize=null,object-size,vptr,alignment)
      endif()
    endif()
  endif()

  # Tells the fuzz driver which blocks were reached; the driver itself must not be told.
  if(TORSIO_TRACE_BLOCKS AND type MATCHES "STATIC_LIBRARY|OBJECT_LIBRARY")
    target_compile_options(${target} PRIVATE
      "$<$<COMPILE_LANGUAGE:CXX>:-fsanitize-coverage=trace-pc>")
  endif()

  # They may end up inside the Python module.
  if(type STREQUAL "STATIC_LIBRARY")
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()

  if(type MATCHES "LIBRARY$" AND NOT type STREQUAL "MODULE_LIBRARY" AND target MATCHES "^torsio_(.+)$")
    set(short_name ${CMAKE_MATCH_1})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${short_name})
    if(NOT TARGET torsio::${short_name})
      add_library(torsio::${short_name} ALIAS ${target})
    endif()
  endif()
endfunction()

# torsio_precompile(<target> [<header>...]): what most of a host target's sources begin with is read
# once for all of them, with TORSIO_PRECOMPILE. A header that a source forgets to include is found by
# the builds without it.
function(torsio_precompile target)
  if(TORSIO_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE
      <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <functional> <map> <memory>
      <mutex> <optional> <random> <span> <string> <thread> <variant> <vector> ${ARGN})
  endif()
endfunction()

# torsio_embedded_defaults(<target>): on top of the above, the rules of code that also runs on the
# microcontroller.
function(torsio_embedded_defaults target)
  torsio_target_defaults(${target})
  get_target_property(type ${target} TYPE)
  if(NOT type STREQUAL "INTERFACE_LIBRARY")
    target_compile_options(${target} PRIVATE
      -fno-exceptions -fno-rtti -Wdouble-promotion)
    # The RP2040 halts where an access is not aligned.
    if(TORSIO_SANITIZE MATCHES "undefined")
      target_compile_options(${target} PRIVATE -fsanitize=alignment)
    endif()
    if(TORSIO_LINK_TIME_OPTIMIZATION)
      target_compile_options(${target} PRIVATE -flto)
    endif()
  endif()
endfunction()
