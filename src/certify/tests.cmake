knead_test(knead_certify_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/certificate_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/report_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/safe_until_test.cpp
  LIBRARIES nlohmann_json::nlohmann_json)
