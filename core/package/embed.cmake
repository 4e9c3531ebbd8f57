# flexopt_embed(TARGET SOURCE.cpp FUNCTION NAME=FILE ...): the files become bytes of the binary, which
# std::string_view flexopt::FUNCTION(std::string_view name) returns. The assembler includes them, so the
# build stays fast.
function(flexopt_embed target output function)
  set(assembly "// Written by CMake: files inside the binary.\n#include <string_view>\n\n")
  set(table "")
  set(externs "")
  set(files "")
  set(n 0)
  foreach(pair IN LISTS ARGN)
    string(REGEX MATCH "^([^=]+)=(.+)$" matched "${pair}")
    set(name "${CMAKE_MATCH_1}")
    set(file "${CMAKE_MATCH_2}")
    set(symbol "flexopt_${function}_${n}")
    string(APPEND assembly
      "__asm__(\".section .rodata\\n.balign 64\\n\"\n"
      "        \".hidden ${symbol}\\n.global ${symbol}\\n${symbol}:\\n\"\n"
      "        \".incbin \\\"${file}\\\"\\n\"\n"
      "        \".hidden ${symbol}_end\\n.global ${symbol}_end\\n\"\n"
      "        \"${symbol}_end:\\n.byte 0\\n.previous\\n\");\n")
    string(APPEND externs
      "extern \"C\" [[gnu::visibility(\"hidden\")]] const char ${symbol}[], ${symbol}_end[];\n")
    string(APPEND table
      "  if (name == \"${name}\") return {${symbol}, ${symbol}_end};\n")
    list(APPEND files "${file}")
    math(EXPR n "${n} + 1")
  endforeach()
  file(CONFIGURE OUTPUT "${output}" @ONLY CONTENT
    "${assembly}\n${externs}\nnamespace flexopt {\n\nstd::string_view ${function}(std::string_view name);\nstd::string_view ${function}(std::string_view name) {\n${table}  return {};\n}\n\n}  // namespace flexopt\n")
  set_source_files_properties("${output}" PROPERTIES OBJECT_DEPENDS "${files}")
  target_sources(${target} PRIVATE "${output}")
endfunction()
