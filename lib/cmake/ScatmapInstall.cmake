# Installs libraries, headers and a package configuration: find_package(scatmap) gives scatmap::report and the rooms below it.

include(CMakePackageConfigHelpers)
set(rooms base frame counts angles brdf model compare report)
foreach(room ${rooms})
  install(TARGETS scatmap_${room} EXPORT scatmapTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
endforeach()
install(DIRECTORY lib/scatmap DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(EXPORT scatmapTargets NAMESPACE scatmap:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scatmap)
configure_package_config_file(lib/cmake/scatmapConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/scatmapConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scatmap)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/scatmapConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scatmapConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/scatmapConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scatmap)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
