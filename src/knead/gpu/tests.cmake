knead_test(
  knead_gpu_test SOURCES ${PROJECT_SOURCE_DIR}/src/knead/gpu/advect_gpu_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/knead/gpu/pins_gpu_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/knead/gpu/glsl_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/knead/gpu/gpu_failures_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/knead/gpu/gpu_surface_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/knead/gpu/gpu_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/knead/gpu/grid_gpu_test.cpp LIBRARIES knead::gpu)
