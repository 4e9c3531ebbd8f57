# find_package(flexopt) gives flexopt::core, flexopt::designs, flexopt::optim, flexopt::results.
include(${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/flexopt-targets.cmake)
