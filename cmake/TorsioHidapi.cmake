# Provides the target hidapi::hidraw, which stands for each system's own backend, from hidapi's own
# CMake package where there is one and from pkg-config elsewhere (Debian's and Ubuntu's packages
# ship only the latter). Either gives the folder of hidapi.h itself, so sources include <hidapi.h>.
# A project around this one links to the target too, so it is visible everywhere.
# TORSIO_HIDAPI_SOURCE, a folder of hidapi's own sources, has them compiled in instead: for what is
# handed out as one file. Also installed, and used by torsioConfig.cmake.
if(TORSIO_HIDAPI_SOURCE AND NOT TARGET hidapi::hidraw)
  if(TORSIO_INSTALL AND NOT TORSIO_SHARED)
    message(FATAL_ERROR "TORSIO_HIDAPI_SOURCE is for one library that has all inside: "
      "set TORSIO_SHARED=ON, or TORSIO_INSTALL=OFF")
  endif()
  enable_language(C)
  if(WIN32)
    set(hidapi_file windows/hid.c)
    set(hidapi_needs "")
  elseif(APPLE)
    set(hidapi_file mac/hid.c)
    set(hidapi_needs "-framework IOKit" "-framework CoreFoundation")
  else()
    set(hidapi_file linux/hid.c)
    set(hidapi_needs udev)
  endif()
  add_library(torsio_hidapi STATIC "${TORSIO_HIDAPI_SOURCE}/${hidapi_file}")
  set_target_properties(torsio_hidapi PROPERTIES
    C_VISIBILITY_PRESET hidden POSITION_INDEPENDENT_CODE ON)
  # Not as a system's folder: there hidapi.h may be another version's.
  target_include_directories(torsio_hidapi PUBLIC "${TORSIO_HIDAPI_SOURCE}/hidapi")
  target_link_libraries(torsio_hidapi PUBLIC ${hidapi_needs})
  add_library(hidapi::hidraw ALIAS torsio_hidapi)
endif()
if(NOT TARGET hidapi::hidraw)
  find_package(hidapi CONFIG QUIET GLOBAL)
endif()
foreach(backend winapi darwin)  # hidapi's names for Windows and macOS
  if(TARGET hidapi::${backend} AND NOT TARGET hidapi::hidraw)
    add_library(hidapi::hidraw ALIAS hidapi::${backend})
  endif()
endforeach()
if(NOT TARGET hidapi::hidraw)
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    pkg_check_modules(TORSIO_HIDAPI QUIET IMPORTED_TARGET GLOBAL hidapi-hidraw)
  endif()
  if(NOT TARGET PkgConfig::TORSIO_HIDAPI)
    message(FATAL_ERROR
      "torsio needs hidapi (hidraw) and found neither its CMake package nor its pkg-config file.\n"
      "On Debian and Ubuntu: apt-get install libhidapi-dev pkg-config. Elsewhere name the folder that "
      "it was installed to, in CMAKE_PREFIX_PATH, or that of its sources, in TORSIO_HIDAPI_SOURCE")
  endif()
  add_library(hidapi::hidraw INTERFACE IMPORTED GLOBAL)
  target_link_libraries(hidapi::hidraw INTERFACE PkgConfig::TORSIO_HIDAPI)
endif()
