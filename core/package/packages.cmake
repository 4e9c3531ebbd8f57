# cpack --preset package: Debian packages that run on every processor of the architecture.
#   libflexopt0.1     the shared library; what runs
#   flexopt           the program, with its gallery of jobs
#   libflexopt-dev    header and CMake files for other projects
#   python3-flexopt   the Python module
# What runs is compiled once for each set of instructions, each time whole: Eigen's matrices lie in
# memory as the flags say, so that objects of two sets must not meet. Further sets lie in
# glibc-hwcaps/SET beside the first, where the loader of glibc (2.33 or later) looks by itself.
include(ExternalProject)
set(libraries flexopt_library)
if(FLEXOPT_PYTHON)
  list(APPEND libraries flexopt_python_library)
endif()
set(before flexopt ${libraries})
foreach(instructions IN LISTS FLEXOPT_MORE_INSTRUCTIONS)
  set(build ${PROJECT_BINARY_DIR}/${instructions})
  ExternalProject_Add(${instructions}
    SOURCE_DIR ${PROJECT_SOURCE_DIR}
    BINARY_DIR ${build}
    PREFIX ${build}/external
    CMAKE_ARGS -D CMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE} -D FLEXOPT_NATIVE=OFF
      -D FLEXOPT_INSTRUCTIONS=${instructions} -D FLEXOPT_PACKAGE=ON -D FLEXOPT_MORE_INSTRUCTIONS=
      -D FLEXOPT_ROOMS=${FLEXOPT_ROOMS} -D FLEXOPT_TESTS=OFF -D FLEXOPT_PYTHON=${FLEXOPT_PYTHON}
    BUILD_COMMAND ${CMAKE_COMMAND} --build <BINARY_DIR> --target ${libraries}
    BUILD_ALWAYS ON
    USES_TERMINAL_BUILD ON
    INSTALL_COMMAND ""
    DEPENDS ${before})
  set(before ${instructions})  # one after the other
  set(hwcaps ${CMAKE_INSTALL_LIBDIR}/glibc-hwcaps/${instructions})
  install(DIRECTORY ${build}/results/ DESTINATION ${hwcaps} COMPONENT runtime
    FILES_MATCHING PATTERN "libflexopt.so.${PROJECT_VERSION_MAJOR}*"
    PATTERN CMakeFiles EXCLUDE PATTERN python EXCLUDE PATTERN generated EXCLUDE)
  if(FLEXOPT_PYTHON)
    install(DIRECTORY ${build}/results/python/ DESTINATION ${hwcaps} COMPONENT python
      FILES_MATCHING PATTERN "libflexopt-python*.so.${PROJECT_VERSION_MAJOR}*"
      PATTERN CMakeFiles EXCLUDE)
  endif()
endforeach()

# What the law asks for: every package says under which terms it may be handed on.
set(runtime_version ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
file(READ ${PROJECT_SOURCE_DIR}/LICENSE LICENCE)
configure_file(${CMAKE_CURRENT_LIST_DIR}/copyright.in ${PROJECT_BINARY_DIR}/copyright @ONLY)
set(documents ${CMAKE_INSTALL_DATAROOTDIR}/doc)
set(runtime_package libflexopt${runtime_version})
set(program_package flexopt)
set(library_package libflexopt-dev)
set(python_package python3-flexopt)
set(CPACK_COMPONENTS_ALL runtime program library)
if(FLEXOPT_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${${component}_package})
  install(FILES ${PROJECT_BINARY_DIR}/copyright
    DESTINATION ${documents}/${${component}_package} COMPONENT ${component})
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/results/generated/report_licences.txt
  DESTINATION ${documents}/${runtime_package} COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${documents}/flexopt COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/designs/jobs/ DESTINATION ${documents}/flexopt/examples
  COMPONENT program)
file(CONFIGURE OUTPUT completion.bash CONTENT "eval \"$(flexopt completion bash)\"\n" @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/completion.bash RENAME flexopt
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions COMPONENT program)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME flexopt)
set(CPACK_PACKAGE_VENDOR flexopt)
set(CPACK_PACKAGE_CONTACT "flexopt maintainers <flexopt@localhost>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR})
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
  ${PROJECT_BINARY_DIR}/results ${PROJECT_BINARY_DIR}/results/python)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Flexure mechanisms: shared library
Leaf-spring guides and hinges that bend far: stiffness, frequencies, stress over the stroke, and exact gradients. \
Compiled for several sets of instructions; the loader takes the one of the processor.")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "Evaluates and optimises flexure mechanisms
Leaf-spring guides and hinges that bend far. A JSON job becomes numbers, files for other programs and a report in which \
the mechanism moves.")
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "Flexure mechanisms: header of the C++ library
flexopt.hpp and the files that CMake's find_package(flexopt) reads.")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Flexure mechanisms in Python
Results as numpy arrays with exact gradients; goals for scipy and other optimisers.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "${runtime_package} (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "${runtime_package} (= ${PROJECT_VERSION})")
if(FLEXOPT_PYTHON)
  find_package(Python REQUIRED COMPONENTS Interpreter)
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3 (<< ${Python_VERSION_MAJOR}.${next}), python3-numpy")
  foreach(when IN ITEMS postinst prerm)
    configure_file(${CMAKE_CURRENT_LIST_DIR}/python_${when}.sh ${PROJECT_BINARY_DIR}/${when} COPYONLY)
  endforeach()
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    "${PROJECT_BINARY_DIR}/postinst;${PROJECT_BINARY_DIR}/prerm")
endif()
# The loader's cache must know a new shared library.
file(CONFIGURE OUTPUT triggers CONTENT "activate-noawait ldconfig\n" @ONLY)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/triggers)
include(CPack)
