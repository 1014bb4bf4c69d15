knead_test(knead_io_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/system_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/animation/animation_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bad_files_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/convert_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/damage_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../json/json_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/materials_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gltf/gltf_generate_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gltf/gltf_remeshed_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gltf/gltf_rewrite_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gltf/gltf_splats_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gltf/glb_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gltf/gltf_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/obj/obj_normals_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/obj/obj_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/off/off_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/other_kinds_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/ply/ply_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/real_files_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/remeshed_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/solver/solver_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/source_bytes_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stl/stl_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/text_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/threemf/threemf_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/wild_files_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/cloud/clouds_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/cloud/splat_files_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/cloud/xyz_test.cpp
  SLOW *OfEveryByte*)
if(NOT WIN32)  # they use processes, signals and limits of POSIX
  target_sources(knead_io_test PRIVATE ${CMAKE_CURRENT_LIST_DIR}/atomic_file_failures_test.cpp
                                       ${CMAKE_CURRENT_LIST_DIR}/atomic_file_test.cpp)
  if(KNEAD_CODECS MATCHES "draco|meshoptimizer")
    target_sources(knead_io_test PRIVATE ${CMAKE_CURRENT_LIST_DIR}/gltf/compressed_test.cpp)
  endif()
endif()
target_compile_definitions(knead_io_test PRIVATE KNEAD_FUZZ_CORPUS="${PROJECT_SOURCE_DIR}/fuzz/corpus")
# They compress what is then read.
foreach(codec IN LISTS KNEAD_CODECS)
  string(TOUPPER KNEAD_HAS_${codec} definition)
  target_link_libraries(knead_io_test PRIVATE ${codec}::${codec})
  target_compile_definitions(knead_io_test PRIVATE ${definition})
endforeach()
