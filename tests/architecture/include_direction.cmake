# Fails if an include points the wrong way, or a wrapped library leaks.
#   cmake -D SOURCE=<repository> -P include_direction.cmake
# A folder includes only itself and the folders before it:
set(folders core designs optim results)
set(core_folders math spec mechanism elements reduction equilibrium response)
# What a library's header looks like, and the only files that may name it:
set(wrapped
  "nlopt\\.h" "optim/nlopt_[a-z_]*\\.cpp"
  "(coin/)?Ip[A-Z][A-Za-z]*\\.hpp" "optim/ipopt_[a-z_]*\\.cpp"
  "muParser[A-Za-z]*\\.h" "optim/expression[a-z_]*\\.[ch]pp"
  "udunits2?\\.h" "core/spec/quantity\\.cpp"
  "CLI/.*" "results/.*"
)

set(wrong "")
set(files 0)
foreach(folder IN LISTS folders)
  file(GLOB_RECURSE sources RELATIVE ${SOURCE} ${SOURCE}/${folder}/*.hpp ${SOURCE}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX node_modules)
  foreach(source IN LISTS sources)
    math(EXPR files "${files} + 1")
    file(STRINGS ${SOURCE}/${source} lines REGEX "^[ \t]*#[ \t]*include")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE ".*include[ \t]*[<\"]([^>\"]*)[>\"].*" "\\1" header "${line}")

      string(REGEX MATCH "^(core|designs|optim|results|tests)/" top "${header}")
      if(top)
        set(top ${CMAKE_MATCH_1})
        list(FIND folders ${folder} here)
        list(FIND folders ${top} there)
        if(there EQUAL -1 OR there GREATER here)
          list(APPEND wrong "${source}: ${header}")
        endif()
        if(folder STREQUAL core AND top STREQUAL core)
          string(REGEX REPLACE "^core/([^/]*)/.*" "\\1" from ${source})
          string(REGEX REPLACE "^core/([^/]*)/.*" "\\1" to ${header})
          list(FIND core_folders ${from} here)
          list(FIND core_folders ${to} there)
          if(here EQUAL -1 OR there EQUAL -1 OR there GREATER here)
            list(APPEND wrong "${source}: ${header}")
          endif()
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

if(files LESS 20)
  message(FATAL_ERROR "only ${files} files found in ${SOURCE}: nothing was checked")
endif()
if(wrong)
  list(JOIN wrong "\n  " wrong)
  message(FATAL_ERROR "includes that point the wrong way:\n  ${wrong}")
endif()
message(STATUS "${files} files, every include points the right way")
