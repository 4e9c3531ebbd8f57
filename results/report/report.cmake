# The report's page and the plotting libraries, put into the binary.
include(${CMAKE_CURRENT_LIST_DIR}/embed.cmake)
set(report_folder ${CMAKE_CURRENT_LIST_DIR})
set(modules ${report_folder}/node_modules)
set(plot_js ${modules}/@observablehq/plot/dist/plot.umd.min.js)
set(d3_js ${modules}/d3/dist/d3.min.js)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${report_folder}/package-lock.json)

# What is there must be what the lock file names: npm keeps its copy of it in node_modules.
if(NOT EXISTS ${plot_js} OR NOT EXISTS ${d3_js}
   OR ${report_folder}/package-lock.json IS_NEWER_THAN ${modules}/.package-lock.json)
  find_program(NPM npm)
  if(NPM AND NOT DEFINED ENV{FLEXOPT_NO_INSTALL})
    message(STATUS "Fetching the report's plotting libraries: npm ci in ${report_folder}")
    execute_process(COMMAND ${NPM} ci --no-audit --no-fund --loglevel=error
      WORKING_DIRECTORY ${report_folder} RESULT_VARIABLE failed)
    if(NOT failed)
      file(TOUCH ${modules}/.package-lock.json)
    endif()
  endif()
endif()
if(NOT EXISTS ${plot_js} OR NOT EXISTS ${d3_js})
  message(FATAL_ERROR
    "The report's plotting libraries are missing. Install Debian's package npm, then run\n"
    "  cd ${report_folder} && npm ci\n"
    "and configure again (FLEXOPT_NO_INSTALL keeps CMake from doing it).")
endif()

# Their licences travel with them.
file(GLOB licences ${modules}/@observablehq/plot/LICENSE ${modules}/*/LICENSE)
set(licence_file ${CMAKE_CURRENT_BINARY_DIR}/generated/report_licences.txt)
set(licence_text "")
foreach(file IN LISTS licences)
  file(RELATIVE_PATH package ${modules} ${file})
  string(REPLACE "/LICENSE" "" package ${package})
  file(READ ${file} text)
  string(APPEND licence_text "==== ${package} ====\n${text}\n")
endforeach()
file(GENERATE OUTPUT ${licence_file} CONTENT "${licence_text}")

flexopt_embed(flexopt_results ${CMAKE_CURRENT_BINARY_DIR}/generated/embedded_files.cpp
  page.html=${report_folder}/page.html
  report.css=${report_folder}/report.css
  figures.js=${report_folder}/figures.js
  shapes.js=${report_folder}/shapes.js
  comparison.js=${report_folder}/comparison.js
  stages.js=${report_folder}/stages.js
  designs.js=${report_folder}/designs.js
  report.js=${report_folder}/report.js
  d3.js=${d3_js}
  plot.js=${plot_js}
  licences.txt=${licence_file})
