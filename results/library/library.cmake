# flexopt::flexopt, for other projects: one shared library of all that flexopt is, in which nothing but
# flexopt.hpp, and the command line for the installed program, can be seen from outside.
set(folder ${CMAKE_CURRENT_LIST_DIR})
add_library(flexopt_library SHARED
  library/jobs.cpp
  library/results.cpp
  cli/program.cpp
)
target_link_libraries(flexopt_library PRIVATE flexopt_results)
target_include_directories(flexopt_library PUBLIC
  $<BUILD_INTERFACE:${folder}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_compile_features(flexopt_library PUBLIC cxx_std_20)
target_compile_options(flexopt_library PRIVATE $<$<CONFIG:Release>:-O1>)
target_link_options(flexopt_library PRIVATE -Wl,--version-script=${folder}/exported.map)
set_target_properties(flexopt_library PROPERTIES
  OUTPUT_NAME flexopt
  VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  LINK_DEPENDS ${folder}/exported.map)
set_source_files_properties(library/jobs.cpp PROPERTIES COMPILE_DEFINITIONS
  "FLEXOPT_MAJOR=${PROJECT_VERSION_MAJOR};FLEXOPT_MINOR=${PROJECT_VERSION_MINOR};FLEXOPT_PATCH=${PROJECT_VERSION_PATCH}")

# The reference of flexopt.hpp as pages: cmake --build … --target doxygen. Whatever is not documented,
# or wrongly, is an error.
find_program(DOXYGEN doxygen)
if(DOXYGEN)
  set(header ${folder}/flexopt.hpp)
  set(pages ${PROJECT_BINARY_DIR}/doxygen)
  configure_file(${folder}/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
  file(MAKE_DIRECTORY ${pages})
  add_custom_target(doxygen COMMAND ${DOXYGEN} ${PROJECT_BINARY_DIR}/Doxyfile
    COMMENT "Reference of flexopt.hpp: ${pages}/html/index.html")
endif()
