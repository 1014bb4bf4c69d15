# Studio on a page. Dear ImGui comes as sources, which `./dev web` fetches; without them there is no page.
if(EXISTS ${KNEAD_SOURCES}/imgui)
  knead_add_imgui(imgui_impl_opengl3.cpp)
  target_compile_definitions(knead_imgui PUBLIC IMGUI_IMPL_OPENGL_ES3)
else()
  message(STATUS "knead: no sources of Dear ImGui in KNEAD_SOURCES: building without Studio's page")
endif()

# The font of the page, in FONT: less what Studio never shows (gui.cpp's ranges), where fontTools is there to leave it out.
function(knead_page_font FONT)
  set(part ${PROJECT_BINARY_DIR}/page_font.ttf)
  execute_process(
    COMMAND pyftsubset ${KNEAD_STUDIO_FONT} --unicodes=20-24F,2010-205E,2190-22FF --layout-features= --no-hinting
            --output-file=${part} RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
  if(failed)
    message(STATUS "knead: no pyftsubset (Debian: fonttools): the page keeps the whole font, 0.3 MB more")
    set(part ${KNEAD_STUDIO_FONT})
  endif()
  set(${FONT}
      ${part}
      PARENT_SCOPE)
endfunction()

# The program of the page, in bindings/web/page of the build.
function(knead_studio_page)
  if(NOT TARGET knead_imgui)
    return()
  endif()
  knead_page_font(font)
  add_executable(knead_studio_page)
  knead_configure(knead_studio_page)
  target_link_libraries(knead_studio_page PRIVATE knead_studio_panels fmt::fmt)
  target_sources(knead_studio_page PRIVATE application.cpp platform/web/window.cpp)
  target_link_options(
    knead_studio_page
    PRIVATE -fexceptions -O2 -lidbfs.js -sMODULARIZE=1 -sEXPORT_ES6=1 -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=4GB
            -sTOTAL_STACK=4MB -sMAX_WEBGL_VERSION=2 -sMIN_WEBGL_VERSION=2 -sDYNAMIC_EXECUTION=0 -sINVOKE_RUN=0
            "-sEXPORTED_RUNTIME_METHODS=['ccall','callMain','FS','IDBFS','HEAPU8']"
            --embed-file ${font}@/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf)
  set(name knead_studio)
  if(KNEAD_WEB_THREADS)
    set(name knead_studio_threads)
    # Studio's worker and what hardware_threads() says but one, all started before main().
    target_link_options(knead_studio_page PRIVATE -sENVIRONMENT=web,worker -sDEFAULT_PTHREAD_STACK_SIZE=4MB
                        "-sPTHREAD_POOL_SIZE=Math.min(8,navigator.hardwareConcurrency)")
  else()
    target_link_options(knead_studio_page PRIVATE -sENVIRONMENT=web)
  endif()
  set_target_properties(knead_studio_page PROPERTIES OUTPUT_NAME ${name} SUFFIX .mjs
                                                     RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/page)
  add_custom_command(TARGET knead_studio_page POST_BUILD
                     COMMAND node ${PROJECT_SOURCE_DIR}/bindings/web/list_fused.mjs ${PROJECT_BINARY_DIR}/page/${name}.wasm)
endfunction()
