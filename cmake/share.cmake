# What belongs to a program besides it is written when it is built, so that only what was built is installed.
set(KNEAD_SHARE_DIR ${PROJECT_BINARY_DIR}/share)

# Writes manual pages and shell completion from the program's --help.
function(knead_share_help target)
  if(CMAKE_CROSSCOMPILING)
    return()
  endif()
  set(script ${PROJECT_SOURCE_DIR}/share/from_help.sh)
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${script})
  add_custom_command(TARGET ${target} POST_BUILD COMMAND ${script} $<TARGET_FILE:${target}> ${KNEAD_SHARE_DIR} VERBATIM)
endfunction()

# Writes a manual page of section 5 from a page of docs/.
function(knead_share_page target page name about)
  if(CMAKE_CROSSCOMPILING)
    return()
  endif()
  set(script ${PROJECT_SOURCE_DIR}/share/from_markdown.sh)
  set(source ${PROJECT_SOURCE_DIR}/docs/${page})
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${script} ${source})
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM
                     COMMAND ${script} ${source} ${name} 5 ${about} ${PROJECT_VERSION} ${KNEAD_SHARE_DIR})
endfunction()

# Copies a file of share/ into a folder of the installed share/.
function(knead_share_file target file folder)
  set(source ${PROJECT_SOURCE_DIR}/share/${file})
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${source})
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM
                     COMMAND ${CMAKE_COMMAND} -E make_directory ${KNEAD_SHARE_DIR}/${folder}
                     COMMAND ${CMAKE_COMMAND} -E copy ${source} ${KNEAD_SHARE_DIR}/${folder})
endfunction()
