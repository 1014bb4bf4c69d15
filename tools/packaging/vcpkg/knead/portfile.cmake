# The library of the checkout that this folder is in: vcpkg install knead --overlay-ports=tools/packaging/vcpkg
# Windows needs clang or mingw: the kernels use packs that Microsoft's compiler lacks.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../../.." ABSOLUTE)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    -DKNEAD_STD_THREADS=ON
    -DKNEAD_STRICT=OFF
    -DKNEAD_BUILD_BENCH=OFF
    -DKNEAD_BUILD_COMMAND=OFF
    -DKNEAD_BUILD_EXAMPLES=OFF
    -DKNEAD_BUILD_GPU=OFF
    -DKNEAD_BUILD_PYTHON=OFF
    -DKNEAD_BUILD_RENDER=OFF
    -DKNEAD_BUILD_STUDIO=OFF
    -DKNEAD_BUILD_TESTS=OFF
    -DCMAKE_DISABLE_FIND_PACKAGE_draco=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_Freetype=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_meshoptimizer=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON)
vcpkg_cmake_build(TARGET knead_core)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/knead)
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
