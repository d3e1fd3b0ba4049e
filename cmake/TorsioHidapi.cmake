# Provides the imported target hidapi::hidraw, from hidapi's own CMake package where there is one
# and from pkg-config elsewhere (Debian's and Ubuntu's packages ship only the latter). Either gives the
# folder of hidapi.h itself, so <hidapi.h> is what is included. A project around this one links to the
# target too, so it is visible everywhere.
# Also installed, and used by torsioConfig.cmake.
if(NOT TARGET hidapi::hidraw)
  find_package(hidapi CONFIG QUIET GLOBAL)
endif()
if(NOT TARGET hidapi::hidraw)
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    pkg_check_modules(TORSIO_HIDAPI QUIET IMPORTED_TARGET GLOBAL hidapi-hidraw)
  endif()
  if(NOT TARGET PkgConfig::TORSIO_HIDAPI)
    message(FATAL_ERROR
      "torsio needs hidapi (hidraw) and found neither its CMake package nor its pkg-config file.\n"
      "On Debian and Ubuntu: apt-get install libhidapi-dev pkg-config")
  endif()
  add_library(hidapi::hidraw INTERFACE IMPORTED GLOBAL)
  target_link_libraries(hidapi::hidraw INTERFACE PkgConfig::TORSIO_HIDAPI)
endif()
