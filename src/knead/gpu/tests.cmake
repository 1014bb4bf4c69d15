knead_test(knead_gpu_test SOURCES ${PROJECT_SOURCE_DIR}/src/knead/gpu/advect_gpu_test.cpp LIBRARIES knead::gpu)
