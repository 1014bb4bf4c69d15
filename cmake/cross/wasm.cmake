# The toolchain of `./dev web`: Debian's emscripten. Of other libraries only headers are used, those of the machine that
# builds. They are linked into a folder of the build, because the compiler must not see the rest of /usr/include.
set(ENV{NODE_PATH} /usr/share/nodejs)
include(/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake)
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR} ${CMAKE_CURRENT_LIST_DIR}/wasm)
set(Eigen3_DIR /usr/share/eigen3/cmake CACHE PATH "Headers only, in a folder of their own")
set(headers ${CMAKE_BINARY_DIR}/headers)
foreach(library IN ITEMS fmt nlohmann xsimd stb)
  if(EXISTS /usr/include/${library} AND NOT EXISTS ${headers}/${library})
    file(MAKE_DIRECTORY ${headers})
    file(CREATE_LINK /usr/include/${library} ${headers}/${library} SYMBOLIC)
  endif()
endforeach()
set(CMAKE_CXX_STANDARD_INCLUDE_DIRECTORIES ${headers})
set(KNEAD_STB_INCLUDE_DIR ${headers}/stb CACHE PATH "Headers only")
# Errors are exceptions.
set(CMAKE_CXX_FLAGS_INIT -fexceptions)
