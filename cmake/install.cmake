# `cmake --install` puts two components under the prefix:
#   runtime      the command, what `knead bench` starts, Studio, and what belongs to them in share/: manual, completion,
#                desktop entry, file type
#   development  the library, its headers, and the package that makes find_package(knead) work (tests/consumer)
# Only what has been built is installed; without the library, `development` fails.
include(CMakePackageConfigHelpers)

set(KNEAD_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/knead)

# --- development ------------------------------------------------------------------------------------------------------

install(TARGETS knead_core EXPORT kneadTargets ARCHIVE COMPONENT development FILE_SET HEADERS COMPONENT development)
install(EXPORT kneadTargets NAMESPACE knead:: DESTINATION ${KNEAD_PACKAGE_DIR} COMPONENT development)
# The parts that need OpenGL have an export of their own: kneadConfig.cmake leaves it out if they were not built.
set(KNEAD_GL_PARTS "")
foreach(part IN ITEMS gl gpu render)
  if(TARGET knead_${part})
    list(APPEND KNEAD_GL_PARTS ${part})
    install(TARGETS knead_${part} EXPORT kneadGlTargets
            ARCHIVE COMPONENT development OPTIONAL FILE_SET HEADERS COMPONENT development OPTIONAL)
  endif()
endforeach()
if(KNEAD_GL_PARTS)
  install(EXPORT kneadGlTargets NAMESPACE knead:: DESTINATION ${KNEAD_PACKAGE_DIR} COMPONENT development)
endif()
configure_package_config_file(cmake/kneadConfig.cmake.in ${PROJECT_BINARY_DIR}/kneadConfig.cmake
                              INSTALL_DESTINATION ${KNEAD_PACKAGE_DIR} PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kneadConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kneadConfig.cmake ${PROJECT_BINARY_DIR}/kneadConfigVersion.cmake
        DESTINATION ${KNEAD_PACKAGE_DIR} COMPONENT development)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libknead-dev RENAME copyright COMPONENT development)

# --- runtime ----------------------------------------------------------------------------------------------------------

# Building a program also writes its files for share/ into the build (share.cmake).
foreach(program IN ITEMS knead knead-bench knead-studio)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME COMPONENT runtime OPTIONAL)
  endif()
endforeach()
install(DIRECTORY ${KNEAD_SHARE_DIR}/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT runtime OPTIONAL)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/knead RENAME copyright COMPONENT runtime)
