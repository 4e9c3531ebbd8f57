# The report's page and its libraries, bundled by esbuild and put into the binary.
set(report_folder ${CMAKE_CURRENT_LIST_DIR})
set(modules ${report_folder}/node_modules)
set(esbuild ${modules}/esbuild/bin/esbuild)
set(libraries @observablehq/plot d3 fflate three)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${report_folder}/package-lock.json)

# What is there must be what the lock file names: npm keeps its copy of it in node_modules.
function(flexopt_report_libraries_missing out)
  set(missing FALSE)
  foreach(package IN LISTS libraries ITEMS esbuild)
    if(NOT EXISTS ${modules}/${package}/package.json)
      set(missing TRUE)
    endif()
  endforeach()
  set(${out} ${missing} PARENT_SCOPE)
endfunction()
flexopt_report_libraries_missing(missing)
if(missing OR ${report_folder}/package-lock.json IS_NEWER_THAN ${modules}/.package-lock.json)
  find_program(NPM npm)
  if(NPM AND NOT DEFINED ENV{FLEXOPT_NO_INSTALL})
    message(STATUS "Fetching the report's libraries: npm ci in ${report_folder}")
    execute_process(COMMAND ${NPM} ci --no-audit --no-fund --loglevel=error
      WORKING_DIRECTORY ${report_folder} RESULT_VARIABLE failed)
    if(NOT failed)
      file(TOUCH ${modules}/.package-lock.json)
    endif()
  endif()
endif()
flexopt_report_libraries_missing(missing)
if(missing)
  message(FATAL_ERROR
    "The report's libraries are missing. Install Debian's package npm, then run\n"
    "  cd ${report_folder} && npm ci\n"
    "and configure again (FLEXOPT_NO_INSTALL keeps CMake from doing it).")
endif()

# One script of all modules and of what they use of the libraries.
file(GLOB page_modules CONFIGURE_DEPENDS ${report_folder}/page/*.js)
set(generated ${CMAKE_CURRENT_BINARY_DIR}/generated)
set(bundle ${generated}/report_bundle.js)
add_custom_command(OUTPUT ${bundle}
  COMMAND ${esbuild} ${report_folder}/page/main.js --bundle --minify --format=iife --target=es2021
    --charset=utf8 --legal-comments=none --log-level=warning --outfile=${bundle}
  DEPENDS ${page_modules} ${report_folder}/package-lock.json
  COMMENT "Bundling the report's page" VERBATIM)

# What pages that a server gives out have besides: `explore` and `watch`.
set(served ${CMAKE_CURRENT_LIST_DIR}/../server/page)
file(GLOB served_modules CONFIGURE_DEPENDS ${served}/*.js)
set(served_bundle ${generated}/served_bundle.js)
add_custom_command(OUTPUT ${served_bundle}
  COMMAND ${esbuild} ${served}/served.js --bundle --minify --format=iife --target=es2021
    --charset=utf8 --legal-comments=none --log-level=warning --outfile=${served_bundle}
  DEPENDS ${served_modules} ${report_folder}/page/text.js ${report_folder}/package-lock.json
  COMMENT "Bundling the served page" VERBATIM)

# The licences of what is inside travel with it.
file(GLOB licences ${modules}/@observablehq/plot/LICENSE ${modules}/d3/LICENSE ${modules}/d3-*/LICENSE
  ${modules}/fflate/LICENSE ${modules}/three/LICENSE ${modules}/internmap/LICENSE
  ${modules}/isoformat/LICENSE ${modules}/interval-tree-1d/LICENSE
  ${modules}/binary-search-bounds/LICENSE ${modules}/delaunator/LICENSE
  ${modules}/robust-predicates/LICENSE)
set(licence_file ${generated}/report_licences.txt)
set(licence_text "")
foreach(file IN LISTS licences)
  file(RELATIVE_PATH package ${modules} ${file})
  string(REPLACE "/LICENSE" "" package ${package})
  file(READ ${file} text)
  string(APPEND licence_text "==== ${package} ====\n${text}\n")
endforeach()
file(GENERATE OUTPUT ${licence_file} CONTENT "${licence_text}")

flexopt_embed(flexopt_results ${generated}/embedded_files.cpp embedded_file
  page.html=${report_folder}/page.html
  report.css=${report_folder}/report.css
  bundle.js=${bundle}
  licences.txt=${licence_file}
  compare_ccx.py=${CMAKE_CURRENT_SOURCE_DIR}/export/compare_ccx.py
  served.html=${served}/served.html
  served.css=${served}/served.css
  served.js=${served_bundle})
