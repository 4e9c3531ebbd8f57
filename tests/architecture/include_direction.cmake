cmake_minimum_required(VERSION 3.25)
# Fails if an include is not in the table of docs/architecture.md, or a wrapped library leaks.
#   cmake -D SOURCE=<repository> -P include_direction.cmake
# What a library's header looks like, and the only files that may name it:
set(wrapped
  "nlopt\\.h" "optim/solvers/nlopt_[a-z_]*\\.cpp"
  "(coin/)?Ip[A-Z][A-Za-z]*\\.hpp" "optim/solvers/ipopt_[a-z_]*\\.cpp"
  "udunits2?\\.h" "core/spec/quantity\\.cpp"
  "(SuiteSparse[A-Za-z_]*\\.hpp|amd\\.h|klu\\.h|ldl\\.h)" "core/math/sparse_[a-z_]*\\.cpp"
  "dmumps_c\\.h" "core/math/sparse_definite\\.cpp"
  "CLI/.*" "results/cli/.*"
  "libqhull_r/.*" "results/export/convex_hull\\.cpp"
  "boost/polygon/.*" "results/export/planar_contour\\.cpp"
  "(BRep|Geom|STEPC|gp_|TopoDS|TopExp|TColgp|Interface_)[A-Za-z_]*\\.hxx" "results/export/step_writer\\.cpp"
  "httplib\\.h" "results/server/local_server\\.cpp"
  "tl/expected\\.hpp" "core/math/answer\\.hpp"
  "mpi\\.h" "results/run/mpi_workers\\.cpp"
)

# The table: one line a room, from the bottom up.
set(page docs/architecture.md)
set(rooms "")
set(wrong "")
file(STRINGS ${SOURCE}/${page} lines ENCODING UTF-8 REGEX "^\\| `")
foreach(line IN LISTS lines)
  string(REGEX MATCH "^\\| `([a-z_/]+)` \\|[^|]*\\|([^|]*)\\|$" whole "${line}")
  if(NOT whole)
    list(APPEND wrong "${page}: not a line of the table: ${line}")
    continue()
  endif()
  set(room ${CMAKE_MATCH_1})
  string(REGEX MATCHALL "[a-z_]+(/[a-z_]+)*" may "${CMAKE_MATCH_2}")
  foreach(other IN LISTS may)
    if(NOT other IN_LIST rooms)
      list(APPEND wrong "${page}: ${room} may include ${other}, which does not stand above it")
    endif()
  endforeach()
  list(APPEND rooms ${room})
  set(may_${room} ${may})
  set(unused_${room} ${may})
endforeach()

set(files 0)
foreach(folder core designs optim results)
  file(GLOB_RECURSE sources RELATIVE ${SOURCE} ${SOURCE}/${folder}/*.hpp ${SOURCE}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX node_modules)
  foreach(source IN LISTS sources)
    math(EXPR files "${files} + 1")
    get_filename_component(room ${source} DIRECTORY)
    if(NOT room IN_LIST rooms)
      list(APPEND wrong "${source}: its folder is not in ${page}")
    endif()
    file(STRINGS ${SOURCE}/${source} lines REGEX "^[ \t]*#[ \t]*include")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE ".*include[ \t]*[<\"]([^>\"]*)[>\"].*" "\\1" header "${line}")

      if(header MATCHES "^(core|designs|optim|results|tests)/")
        get_filename_component(other ${header} DIRECTORY)
        list(REMOVE_ITEM unused_${room} ${other})
        if(NOT other STREQUAL room AND NOT other IN_LIST may_${room})
          list(APPEND wrong "${source}: ${header} (${room} may include: ${may_${room}})")
        endif()
      elseif(line MATCHES "\"" AND NOT header MATCHES "^flexopt_")
        list(APPEND wrong "${source}: ${header} (write the path from the repository's root)")
      endif()

      set(pairs ${wrapped})
      while(pairs)
        list(POP_FRONT pairs pattern allowed)
        if(header MATCHES "^${pattern}$" AND NOT source MATCHES "^${allowed}$")
          list(APPEND wrong "${source}: ${header} (only ${allowed} may)")
        endif()
      endwhile()
    endforeach()
  endforeach()
endforeach()
foreach(room IN LISTS rooms)
  foreach(other IN LISTS unused_${room})
    list(APPEND wrong "${page}: ${room} does not include ${other}; take it out of its line")
  endforeach()
endforeach()

if(files LESS 20)
  message(FATAL_ERROR "only ${files} files found in ${SOURCE}: nothing was checked")
endif()
if(wrong)
  list(JOIN wrong "\n  " wrong)
  message(FATAL_ERROR "includes that point the wrong way:\n  ${wrong}")
endif()
message(STATUS "${files} files, every include points the right way")
