# flexopt_compile_by_rooms(TARGET [ALONE sources]): with FLEXOPT_ROOMS the sources of a folder are
# compiled as one, which parses their headers and builds the templates that they share once. Sources
# that take long by themselves stay alone, so that a change of one file never takes long.
function(flexopt_compile_by_rooms target)
  cmake_parse_arguments(T "" "" "ALONE" ${ARGN})
  if(NOT FLEXOPT_ROOMS)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "^[a-z_/]+\\.cpp$")
  list(REMOVE_ITEM sources ${T_ALONE})
  foreach(source IN LISTS sources)
    get_filename_component(room ${source} DIRECTORY)
    string(REPLACE "/" "_" room "room_${room}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
