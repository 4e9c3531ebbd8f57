# What flexopt is made with: found here by its own build and by every project that links it.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(TBB REQUIRED)
find_package(ZLIB REQUIRED)
find_library(FLEXOPT_QHULL qhull_r REQUIRED)
find_package(Boost 1.74 REQUIRED)  # headers: Boost.Random
find_library(FLEXOPT_SPQR spqr REQUIRED)
find_library(FLEXOPT_CHOLMOD cholmod REQUIRED)
find_library(FLEXOPT_UMFPACK umfpack REQUIRED)
find_path(FLEXOPT_SUITESPARSE SuiteSparseQR.hpp PATH_SUFFIXES suitesparse REQUIRED)
if(NOT TARGET SuiteSparse::SPQR)
  add_library(SuiteSparse::SPQR INTERFACE IMPORTED)
  set_target_properties(SuiteSparse::SPQR PROPERTIES
    INTERFACE_LINK_LIBRARIES "${FLEXOPT_SPQR};${FLEXOPT_CHOLMOD}"
    INTERFACE_INCLUDE_DIRECTORIES "${FLEXOPT_SUITESPARSE}")
endif()
if(NOT TARGET SuiteSparse::UMFPACK)
  add_library(SuiteSparse::UMFPACK INTERFACE IMPORTED)
  set_target_properties(SuiteSparse::UMFPACK PROPERTIES
    INTERFACE_LINK_LIBRARIES "${FLEXOPT_UMFPACK};${FLEXOPT_CHOLMOD}"
    INTERFACE_INCLUDE_DIRECTORIES "${FLEXOPT_SUITESPARSE}")
endif()
pkg_check_modules(udunits REQUIRED IMPORTED_TARGET udunits)
pkg_check_modules(nlopt REQUIRED IMPORTED_TARGET nlopt)
pkg_check_modules(ipopt REQUIRED IMPORTED_TARGET ipopt)
pkg_check_modules(httplib REQUIRED cpp-httplib)
