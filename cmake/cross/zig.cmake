# The toolchain of `./dev cross` and `./dev wheels`: zig, a C++ compiler for every target, of pip's package ziglang. ZIG names its program,
# ZIG_TARGET the target, such as x86_64-linux-gnu.2.17. Of other libraries only headers are used, those of the machine
# that builds. They are linked into a folder of the build, because the compiler must not see the rest of /usr/include.
set(ZIG_TARGET "$ENV{ZIG_TARGET}" CACHE STRING "Zig's name of the target")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ZIG_TARGET)
if(ZIG_TARGET MATCHES "windows")
  set(CMAKE_SYSTEM_NAME Windows)
elseif(ZIG_TARGET MATCHES "macos")
  set(CMAKE_SYSTEM_NAME Darwin)
  set(CMAKE_OSX_SYSROOT "")
else()
  set(CMAKE_SYSTEM_NAME Linux)
endif()
string(REGEX REPLACE "-.*" "" CMAKE_SYSTEM_PROCESSOR ${ZIG_TARGET})
set(CMAKE_C_COMPILER ${CMAKE_CURRENT_LIST_DIR}/zig/cc)  # googletest asks for one
set(CMAKE_CXX_COMPILER ${CMAKE_CURRENT_LIST_DIR}/zig/cxx)
set(CMAKE_AR ${CMAKE_CURRENT_LIST_DIR}/zig/ar)
set(CMAKE_RANLIB ${CMAKE_CURRENT_LIST_DIR}/zig/ranlib)
set(CMAKE_RC_COMPILER ${CMAKE_CURRENT_LIST_DIR}/zig/rc)
set(CMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE PRE_TEST)  # nothing that is built need run here
set(zig_target ${ZIG_TARGET})
if(ZIG_TARGET MATCHES "macos$")  # the oldest that is supported
  string(APPEND zig_target .11.0)
endif()
# Without these, zig adds what debuggers need: 136 MB instead of 9 MB.
set(CMAKE_C_FLAGS_INIT "-target ${zig_target} -g0")
set(CMAKE_CXX_FLAGS_INIT "-target ${zig_target} -g0")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-s")
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR} ${CMAKE_CURRENT_LIST_DIR}/wasm)
set(Eigen3_DIR /usr/share/eigen3/cmake CACHE PATH "Headers only, in a folder of their own")
set(headers ${CMAKE_BINARY_DIR}/headers)
foreach(library IN ITEMS fmt nlohmann xsimd CLI)
  if(EXISTS /usr/include/${library} AND NOT EXISTS ${headers}/${library})
    file(MAKE_DIRECTORY ${headers})
    file(CREATE_LINK /usr/include/${library} ${headers}/${library} SYMBOLIC)
  endif()
endforeach()
set(CMAKE_CXX_STANDARD_INCLUDE_DIRECTORIES ${headers})
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY NEVER)
