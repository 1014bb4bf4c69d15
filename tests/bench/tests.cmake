# What `knead bench` compares with, and how it judges.
set(command ${PROJECT_SOURCE_DIR}/apps/knead)
knead_test(knead_bench_test
           SOURCES ${CMAKE_CURRENT_LIST_DIR}/integrators_test.cpp ${CMAKE_CURRENT_LIST_DIR}/kelvinlets_test.cpp
                   ${command}/bench_integrators.cpp ${command}/bench_measure.cpp ${command}/bench_scenes.cpp
                   ${PROJECT_SOURCE_DIR}/bench/kelvinlets.cpp
           LIBRARIES fmt::fmt nlohmann_json::nlohmann_json)
target_include_directories(knead_bench_test PRIVATE ${command} ${PROJECT_SOURCE_DIR}/bench)
