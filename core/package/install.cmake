# cmake --install: the program, the library with its header, the parts with all their headers, and
# find_package(flexopt). By component: program, runtime (the shared library), library (what other
# projects need of it), internals (the parts).
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/flexopt)

set_target_properties(flexopt_library PROPERTIES EXPORT_NAME flexopt)
add_library(flexopt::flexopt ALIAS flexopt_library)
foreach(part flags core designs optim results)
  set_target_properties(flexopt_${part} PROPERTIES EXPORT_NAME ${part})
  add_library(flexopt::${part} ALIAS flexopt_${part})
endforeach()
install(TARGETS flexopt COMPONENT program)
foreach(part flexopt_mpi flexopt_step)
  if(TARGET ${part})
    install(TARGETS ${part} DESTINATION ${CMAKE_INSTALL_LIBDIR}/flexopt COMPONENT program)
  endif()
endforeach()
install(TARGETS flexopt_library EXPORT flexopt-library-targets
  LIBRARY COMPONENT runtime NAMELINK_COMPONENT library)
install(FILES ${PROJECT_SOURCE_DIR}/results/library/flexopt.hpp
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)
install(EXPORT flexopt-library-targets NAMESPACE flexopt:: DESTINATION ${package_folder}
  COMPONENT library)

install(TARGETS flexopt_flags flexopt_core flexopt_designs flexopt_optim flexopt_results
  EXPORT flexopt-targets COMPONENT internals)
install(EXPORT flexopt-targets NAMESPACE flexopt:: DESTINATION ${package_folder}
  COMPONENT internals)
foreach(part core designs optim results)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/flexopt
    COMPONENT internals FILES_MATCHING PATTERN "*.hpp"
    PATTERN node_modules EXCLUDE PATTERN report EXCLUDE PATTERN jobs EXCLUDE
    PATTERN package EXCLUDE PATTERN library EXCLUDE)
endforeach()
install(FILES ${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake
  DESTINATION ${package_folder} COMPONENT internals)

write_basic_package_version_file(${PROJECT_BINARY_DIR}/flexopt-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_LIST_DIR}/flexopt-config.cmake
  ${PROJECT_BINARY_DIR}/flexopt-config-version.cmake
  DESTINATION ${package_folder} COMPONENT library)
