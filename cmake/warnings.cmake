# Flags for our own targets only; nothing is set globally.
function(knead_configure target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  if(KNEAD_UNITY)
    # Six sources at a time: about half of the time to compile. A file in the middle of one is not the main file to g++,
    # which then warns of what no header shows.
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
  # The libraries also go into Python's module, which is a shared object. The option after it keeps calls within a
  # source as cheap as in a program.
  get_target_property(type ${target} TYPE)
  if(type STREQUAL STATIC_LIBRARY AND NOT EMSCRIPTEN)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    if(NOT WIN32)
      target_compile_options(${target} PRIVATE -fno-semantic-interposition)
    endif()
  endif()
  if(WIN32)  # sizes of files have 64 bits; <cmath> has M_PI, and <windows.h> neither min() nor max()
    target_compile_definitions(${target} PRIVATE _FILE_OFFSET_BITS=64 _USE_MATH_DEFINES NOMINMAX)
  endif()
  target_compile_options(
    ${target}
    PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Wold-style-cast
            -Wimplicit-fallthrough
            # Not for users, whose compiler may be newer.
            $<$<BOOL:${KNEAD_STRICT}>:-Werror>
            # On 32 bits, sizes of 64 bits are made shorter everywhere, as 64-bit loads of them show to be harmless.
            $<$<BOOL:${EMSCRIPTEN}>:-Wno-shorten-64-to-32>
            # The same bits from every compiler: no contraction of a * b + c (architecture, decision 3).
            -ffp-contract=off
            # g++ 13 and later take a reference into a table or a document for one into the argument that finds it.
            $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,13>>:-Wno-dangling-reference>
            # g++ 12's SLP vectoriser drops the rounding of double -> float -> double on neighbouring components.
            $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)
  if(KNEAD_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${KNEAD_SANITIZE} -fno-omit-frame-pointer
                                             -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${KNEAD_SANITIZE})
    # Half the time to compile, where little time is needed to run: not in the library, nor in tests that compute.
    if(NOT target MATCHES "^knead_(core|gl|gpu|render|(field|flow|mesh|shapes|cgal|agreement)_test)$")
      target_compile_options(${target} PRIVATE -O0 -g1)
    endif()
  endif()
endfunction()
