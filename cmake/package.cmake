# `./dev package` makes two Debian packages from the components of install.cmake: knead and libknead-dev.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME knead)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "deforms 3D shapes and keeps their volume")
set(CPACK_PACKAGE_VENDOR "The Knead authors")
# Not a real address; set another one to publish packages.
set(CPACK_PACKAGE_CONTACT "The Knead authors <authors@knead.invalid>" CACHE STRING "Maintainer of the Debian packages")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
# Files and folders of root, which nobody else may write, whatever the umask of the build.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
                                                WORLD_READ WORLD_EXECUTE)

# dpkg-shlibdeps finds the shared libraries that the programs are linked to. EGL and Mesa are loaded while they run.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME knead)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "libegl1, libgl1, libgl1-mesa-dri, fonts-dejavu-core")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "The command knead and the application Knead Studio deform meshes and point
clouds (PLY, OBJ, STL, OFF, GLB, XYZ). A deformation keeps the volume, never
folds the shape, and leaves everything outside of a tool as it is.")

# The library is static: a program that uses it links these as well.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libknead-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libfmt-dev (>= 9), libtbb-dev (>= 2021.5)")
foreach(codec IN LISTS KNEAD_CODECS)
  string(TOLOWER "lib${codec}-dev" package)
  string(REPLACE "libzlib" "zlib1g" package "${package}")
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", ${package}")
endforeach()
if(TARGET knead_gpu OR TARGET knead_render)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libepoxy-dev, libegl-dev, pkg-config")
endif()
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "The static library of Knead, its headers, and a CMake package for
find_package(knead).")

# Debian asks for a list of changes in its own form, beside ours.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(changelog ${PROJECT_BINARY_DIR}/changelog)
file(WRITE ${changelog}.Debian "knead (${PROJECT_VERSION}-1) unstable; urgency=medium\n\n"
                               "  * See changelog.gz.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
file(COPY_FILE CHANGELOG.md ${changelog})
execute_process(COMMAND gzip -9nf ${changelog} ${changelog}.Debian)
install(FILES ${changelog}.gz ${changelog}.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/knead COMPONENT runtime)
install(FILES ${changelog}.gz ${changelog}.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libknead-dev
        COMPONENT development)

include(CPack)
