# `cmake --install` gives other projects find_package(torsio) and the target torsio::sdk.
# The internal libraries are archived beside the SDK because a static library cannot contain them;
# only the SDK's own headers are installed.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/torsio")

install(TARGETS torsio_sdk torsio_conversion torsio_emulator torsio_boards torsio_device torsio_core
  torsio_protocol
  EXPORT torsioTargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT sdk
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT sdk
  INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(DIRECTORY sdk/include/torsio emulator/include/torsio DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT sdk
  FILES_MATCHING PATTERN "*.hpp")

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
