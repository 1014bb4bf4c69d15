# Studio as a process of its own, killed.
add_executable(studio_kill_driver ${CMAKE_CURRENT_LIST_DIR}/kill_driver.cpp)
target_link_libraries(studio_kill_driver PRIVATE knead_studio_core fmt::fmt)
knead_configure(studio_kill_driver)
knead_test(knead_studio_kill_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/kill_test.cpp LIBRARIES knead_studio_core fmt::fmt)
target_compile_definitions(knead_studio_kill_test PRIVATE KNEAD_KILL_DRIVER="$<TARGET_FILE:studio_kill_driver>")
add_dependencies(knead_studio_kill_test studio_kill_driver)
