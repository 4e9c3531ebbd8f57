# find_package(flexopt [COMPONENTS …])
#   library     flexopt::flexopt, a shared library with the header flexopt.hpp; needs nothing else
#   internals   flexopt::core, flexopt::designs, flexopt::optim, flexopt::results: static libraries with
#               all their headers, which need what flexopt was built with. Debian's packages have none.
# Without components: what is installed.
include(${CMAKE_CURRENT_LIST_DIR}/flexopt-library-targets.cmake)
set(flexopt_library_FOUND TRUE)
if(EXISTS ${CMAKE_CURRENT_LIST_DIR}/flexopt-targets.cmake AND
   (NOT flexopt_FIND_COMPONENTS OR "internals" IN_LIST flexopt_FIND_COMPONENTS))
  include(${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake)
  include(${CMAKE_CURRENT_LIST_DIR}/flexopt-targets.cmake)
  set(flexopt_internals_FOUND TRUE)
endif()
foreach(component IN LISTS flexopt_FIND_COMPONENTS)
  if(flexopt_FIND_REQUIRED_${component} AND NOT flexopt_${component}_FOUND)
    set(flexopt_FOUND FALSE)
    set(flexopt_NOT_FOUND_MESSAGE "flexopt has no component \"${component}\" here")
  endif()
endforeach()
