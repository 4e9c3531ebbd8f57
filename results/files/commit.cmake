# Writes OUTPUT with the commit of SOURCE, and only if it changed, so that nothing else rebuilds.
set(commit "unknown")
find_program(GIT git)
if(GIT AND EXISTS "${SOURCE}/.git")
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
    RESULT_VARIABLE failed OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT failed AND described)
    set(commit "${described}")
    if(commit MATCHES "-dirty$")  # which changes: results of other code must not pass for the same
      execute_process(COMMAND ${GIT} -C ${SOURCE} diff HEAD
        COMMAND ${GIT} hash-object --stdin
        OUTPUT_VARIABLE changes OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
      string(SUBSTRING "${changes}" 0 8 changes)
      string(APPEND commit "-${changes}")
    endif()
  endif()
endif()
set(text "#pragma once\n#define FLEXOPT_COMMIT \"${commit}\"\n")
set(old "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" old)
endif()
if(NOT old STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
