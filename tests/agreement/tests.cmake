if(POLICY CMP0167) # its own file says where it is
  cmake_policy(SET CMP0167 NEW)
endif()
find_package(Boost 1.74 REQUIRED)
knead_test(
  knead_agreement_test
  SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/agreement_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/oracle.cpp
  LIBRARIES
  Boost::headers
  fmt::fmt
  nlohmann_json::nlohmann_json
  SLOW
  Meshes/AgreementOnScans.*)
# Boost.Odeint copies steppers whose scratch space is not yet set, which g++ takes for a mistake.
set_source_files_properties(
  ${CMAKE_CURRENT_LIST_DIR}/oracle.cpp
  PROPERTIES COMPILE_OPTIONS "$<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized;-Wno-maybe-uninitialized>")
