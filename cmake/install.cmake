# `cmake --install` puts the library, its headers and the command under the prefix, and the package that makes
# find_package(knead) work there (tests/consumer proves it).
include(CMakePackageConfigHelpers)

set(KNEAD_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/knead)

install(TARGETS knead_core EXPORT kneadTargets FILE_SET HEADERS)
install(EXPORT kneadTargets NAMESPACE knead:: DESTINATION ${KNEAD_PACKAGE_DIR})
if(TARGET knead_gpu)
  install(TARGETS knead_gpu EXPORT kneadGpuTargets FILE_SET HEADERS)
  install(EXPORT kneadGpuTargets NAMESPACE knead:: DESTINATION ${KNEAD_PACKAGE_DIR})
endif()
if(TARGET knead_render)
  install(TARGETS knead_render EXPORT kneadRenderTargets FILE_SET HEADERS)
  install(EXPORT kneadRenderTargets NAMESPACE knead:: DESTINATION ${KNEAD_PACKAGE_DIR})
endif()
if(TARGET knead)
  install(TARGETS knead)
endif()
if(TARGET knead-studio)
  install(TARGETS knead-studio)
  install(FILES share/knead-studio.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
  install(FILES share/knead-studio.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
endif()

configure_package_config_file(cmake/kneadConfig.cmake.in ${PROJECT_BINARY_DIR}/kneadConfig.cmake
                              INSTALL_DESTINATION ${KNEAD_PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kneadConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kneadConfig.cmake ${PROJECT_BINARY_DIR}/kneadConfigVersion.cmake
        DESTINATION ${KNEAD_PACKAGE_DIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
