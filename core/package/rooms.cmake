# flexopt_compile_by_rooms(TARGET [ALONE sources]): with FLEXOPT_ROOMS the sources of a folder are
# compiled as one, which parses their headers and builds the templates that they share once. Sources
# that take long by themselves stay alone, so that a change of one file never takes long.
function(flexopt_compile_by_rooms target)
  cmake_parse_arguments(T "" "" "ALONE" ${ARGN})
  if(NOT FLEXOPT_ROOMS)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "^[a-z_][a-z_/]*\\.cpp$")
  list(REMOVE_ITEM sources ${T_ALONE})
  foreach(source IN LISTS sources)
    get_filename_component(room ${source} DIRECTORY)
    string(REPLACE "/" "_" room "room_${room}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

# flexopt_read_headers_once(TARGET headers…): with FLEXOPT_ROOMS, headers of other libraries that most
# sources include are read once and kept. Not beside a compiler cache, which does not see through
# them. flexopt_read_headers_of(TARGET OTHER) takes those that OTHER has kept, compiled alike.
function(flexopt_read_headers_once target)
  if(FLEXOPT_ROOMS AND NOT CCACHE)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

function(flexopt_read_headers_of target other)
  if(FLEXOPT_ROOMS AND NOT CCACHE)
    target_precompile_headers(${target} REUSE_FROM ${other})
  endif()
endfunction()

# flexopt_sanitize_rooms(TARGET): rooms of TARGET that FLEXOPT_SANITIZED_ROOMS names, once more with
# sanitizers, each a library of objects, sanitized_room_core_math say. They are linked instead of TARGET's
# own (tests/CMakeLists.txt): what is read or written there is looked at, whoever has reserved it.
# The property FLEXOPT_SANITIZED of TARGET lists them.
function(flexopt_sanitize_rooms target)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  get_target_property(sources ${target} SOURCES)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  foreach(room IN LISTS FLEXOPT_SANITIZED_ROOMS)
    set(own "")
    foreach(source IN LISTS sources)
      get_filename_component(its_room ${folder}/${source} DIRECTORY)
      if(its_room STREQUAL room)
        list(APPEND own ${source})
      endif()
    endforeach()
    if(own)
      string(REPLACE "/" "_" name "sanitized_room_${room}")
      add_library(${name} OBJECT EXCLUDE_FROM_ALL ${own})
      target_link_libraries(${name} PRIVATE ${libraries})
      target_include_directories(${name} PRIVATE $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>)
      target_compile_options(${name} PRIVATE -O1 -UEIGEN_NO_DEBUG -Wpedantic ${flexopt_sanitizers} -fno-omit-frame-pointer)
      set_target_properties(${name} PROPERTIES UNITY_BUILD ${FLEXOPT_ROOMS} UNITY_BUILD_MODE GROUP)
      add_dependencies(${name} ${target}) # what that generates
      set_property(TARGET ${target} APPEND PROPERTY FLEXOPT_SANITIZED ${name})
    endif()
  endforeach()
endfunction()
