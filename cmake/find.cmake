# How the libraries are found that Knead cannot do without. With KNEAD_FETCH=ON, those that the system lacks come as source, from
# the repository of their authors: always the commit that is named here.
option(KNEAD_FETCH "Get the sources of needed libraries that are not found" OFF)

# For each library: target, folder of its headers, repository, commit (of the version in the comment).
set(KNEAD_FETCH_fmt fmt::fmt include # 11.2.0
    https://github.com/fmtlib/fmt.git 40626af88bd7df9a5fb80be7b25ac85b122d6c21)
set(KNEAD_FETCH_nlohmann_json nlohmann_json::nlohmann_json include # 3.11.3
    https://github.com/nlohmann/json.git 9cca280a4d0ccf0c08f47a99aa71d1b0e52f8d03)
set(KNEAD_FETCH_xsimd xsimd include # 13.2.0
    https://github.com/xtensor-stack/xsimd.git 1f8dd9c8e162968d9b4ff0251c56d431b8777f36)
set(KNEAD_FETCH_Eigen3 Eigen3::Eigen . # 3.4.0
    https://gitlab.com/libeigen/eigen.git 3147391d946bb4b6c68edd901f2add6ac1f31f8c)
set(KNEAD_FETCH_CLI11 CLI11::CLI11 include # 2.4.2
    https://github.com/CLIUtils/CLI11.git 6c7b07a878ad834957b98d0f9ce1dbe0cb204fc9)
set(KNEAD_FETCH_GTest GTest::gtest_main "" # 1.16.0
    https://github.com/google/googletest.git 6910c9d9165801d8827d628cb72eb7ea9dd538c5)

# Only the headers are used, but for GoogleTest. Nothing of it is installed.
function(knead_fetch package)
  include(FetchContent)
  list(GET KNEAD_FETCH_${package} 0 target)
  list(GET KNEAD_FETCH_${package} 1 headers)
  list(GET KNEAD_FETCH_${package} 2 repository)
  list(GET KNEAD_FETCH_${package} 3 commit)
  string(TOLOWER knead_${package} name)
  FetchContent_Declare(${name} GIT_REPOSITORY ${repository} GIT_TAG ${commit} SOURCE_SUBDIR no_build_of_its_own)
  FetchContent_MakeAvailable(${name})
  if(package STREQUAL "GTest")
    set(BUILD_GMOCK OFF)
    set(INSTALL_GTEST OFF)
    add_subdirectory(${${name}_SOURCE_DIR} ${${name}_BINARY_DIR} EXCLUDE_FROM_ALL SYSTEM)
    return()
  endif()
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} SYSTEM INTERFACE ${${name}_SOURCE_DIR}/${headers})
  if(package STREQUAL "fmt")
    target_compile_definitions(${target} INTERFACE FMT_HEADER_ONLY)
  endif()
endfunction()

# Finds a library that is at least as new as `oldest`. The version files of some (xsimd, Eigen) refuse every later major
# number, so these are asked for again by their own number.
macro(knead_find package oldest)
  find_package(${package} ${oldest} QUIET)
  foreach(knead_version IN LISTS ${package}_CONSIDERED_VERSIONS)
    if(NOT ${package}_FOUND AND knead_version VERSION_GREATER_EQUAL ${oldest})
      find_package(${package} ${knead_version} EXACT REQUIRED)
    endif()
  endforeach()
  if(NOT ${package}_FOUND)
    if(NOT DEFINED KNEAD_FETCH_${package})
      message(FATAL_ERROR "${package} ${oldest} or later was not found; install it")
    elseif(NOT KNEAD_FETCH)
      message(FATAL_ERROR "${package} ${oldest} or later was not found; install it, or let CMake get its source: -DKNEAD_FETCH=ON")
    endif()
    knead_fetch(${package})
    set(KNEAD_FETCHED_${package} TRUE)
  endif()
endmacro()
