# `cmake --install` gives other projects find_package(torsio) with the target torsio::sdk, and
# pkg-config's torsio. A shared SDK is one library; beside a static one lie the inner libraries, which
# it cannot contain. Only the SDK's own headers are installed.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/torsio")

# Those on the left need those on the right.
set(libraries torsio_sdk)
if(NOT TORSIO_SHARED)
  list(APPEND libraries torsio_conversion)
  if(TORSIO_WITH_EMULATOR)
    list(APPEND libraries torsio_emulator)
  endif()
  list(APPEND libraries torsio_device torsio_core torsio_boards torsio_protocol)
endif()
install(TARGETS ${libraries} EXPORT torsioTargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT sdk
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT sdk
  FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT sdk)

install(EXPORT torsioTargets NAMESPACE torsio:: DESTINATION "${config_dir}" COMPONENT sdk)
configure_package_config_file(
  "${CMAKE_CURRENT_LIST_DIR}/torsioConfig.cmake.in" "${PROJECT_BINARY_DIR}/torsioConfig.cmake"
  INSTALL_DESTINATION "${config_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/torsioConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES
  "${PROJECT_BINARY_DIR}/torsioConfig.cmake"
  "${PROJECT_BINARY_DIR}/torsioConfigVersion.cmake"
  "${CMAKE_CURRENT_LIST_DIR}/TorsioHidapi.cmake"
  DESTINATION "${config_dir}" COMPONENT sdk)

set(pc_libraries ${libraries})
set(pc_requires "")
if(NOT TORSIO_SHARED)
  list(REMOVE_ITEM pc_libraries torsio_boards torsio_protocol)  # headers alone
  list(APPEND pc_libraries pthread)
  set(pc_requires hidapi-hidraw)
endif()
list(TRANSFORM pc_libraries PREPEND "-l")
list(JOIN pc_libraries " " pc_libraries)
file(RELATIVE_PATH pc_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
configure_file("${CMAKE_CURRENT_LIST_DIR}/torsio.pc.in" "${PROJECT_BINARY_DIR}/torsio.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/torsio.pc"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT sdk)

# udev looks there below /usr and /usr/local. The libraries' folder may have another name.
install(FILES sdk/60-torsio.rules DESTINATION lib/udev/rules.d COMPONENT sdk)
install(FILES LICENSE NOTICES.md DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT sdk)
