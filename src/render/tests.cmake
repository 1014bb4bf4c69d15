knead_test(knead_render_test SOURCES ${PROJECT_SOURCE_DIR}/src/render/render_test.cpp
                                     ${PROJECT_SOURCE_DIR}/src/render/gif_test.cpp
                                     ${PROJECT_SOURCE_DIR}/src/render/look_test.cpp
                                     ${PROJECT_SOURCE_DIR}/src/render/splats_test.cpp
                                     ${PROJECT_SOURCE_DIR}/src/render/tool_surface_test.cpp LIBRARIES knead::render
           SLOW *LooksLikeSplatsOfTheDeformedMesh*)
target_include_directories(knead_render_test SYSTEM PRIVATE ${KNEAD_STB_INCLUDE_DIR})
knead_test(knead_live_view_test SOURCES ${PROJECT_SOURCE_DIR}/src/render/live_compute_test.cpp
                                          ${PROJECT_SOURCE_DIR}/src/render/live_look_test.cpp
                                          ${PROJECT_SOURCE_DIR}/src/render/live_mesh_test.cpp
                                          ${PROJECT_SOURCE_DIR}/src/render/live_splats_test.cpp
                                          ${PROJECT_SOURCE_DIR}/src/render/live_tools_test.cpp
                                          ${PROJECT_SOURCE_DIR}/src/render/live_view_test.cpp LIBRARIES knead::render)
