# cmake --install: the program, the libraries with their headers, and find_package(flexopt).
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/flexopt)

foreach(part flags core designs optim results)
  set_target_properties(flexopt_${part} PROPERTIES EXPORT_NAME ${part})
  add_library(flexopt::${part} ALIAS flexopt_${part})
endforeach()
install(TARGETS flexopt)
if(TARGET flexopt_mpi)
  install(TARGETS flexopt_mpi DESTINATION ${CMAKE_INSTALL_LIBDIR}/flexopt)
endif()
install(TARGETS flexopt_flags flexopt_core flexopt_designs flexopt_optim flexopt_results
  EXPORT flexopt-targets)
install(EXPORT flexopt-targets NAMESPACE flexopt:: DESTINATION ${package_folder})

foreach(part core designs optim results)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/flexopt
    FILES_MATCHING PATTERN "*.hpp"
    PATTERN node_modules EXCLUDE PATTERN report EXCLUDE PATTERN jobs EXCLUDE
    PATTERN package EXCLUDE)
endforeach()

write_basic_package_version_file(${PROJECT_BINARY_DIR}/flexopt-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_LIST_DIR}/flexopt-config.cmake
  ${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake
  ${PROJECT_BINARY_DIR}/flexopt-config-version.cmake
  DESTINATION ${package_folder})
