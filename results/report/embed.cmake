# flexopt_embed(TARGET SOURCE.cpp NAME=FILE ...): the files become bytes of the binary, read by
# embedded_file("NAME"). The assembler includes them, so the build stays fast.
function(flexopt_embed target output)
  set(assembly "// Written by CMake: the files inside the binary.\n#include \"results/report/report.hpp\"\n\n")
  set(table "")
  set(externs "")
  set(files "")
  set(n 0)
  foreach(pair IN LISTS ARGN)
    string(REGEX MATCH "^([^=]+)=(.+)$" matched "${pair}")
    set(name "${CMAKE_MATCH_1}")
    set(file "${CMAKE_MATCH_2}")
    string(APPEND assembly
      "__asm__(\".section .rodata\\n\"\n"
      "        \".hidden flexopt_file_${n}\\n.global flexopt_file_${n}\\nflexopt_file_${n}:\\n\"\n"
      "        \".incbin \\\"${file}\\\"\\n\"\n"
      "        \".hidden flexopt_file_${n}_end\\n.global flexopt_file_${n}_end\\n\"\n"
      "        \"flexopt_file_${n}_end:\\n.byte 0\\n.previous\\n\");\n")
    string(APPEND externs
      "extern \"C\" [[gnu::visibility(\"hidden\")]] const char flexopt_file_${n}[], flexopt_file_${n}_end[];\n")
    string(APPEND table
      "  if (name == \"${name}\") return {flexopt_file_${n}, flexopt_file_${n}_end};\n")
    list(APPEND files "${file}")
    math(EXPR n "${n} + 1")
  endforeach()
  file(CONFIGURE OUTPUT "${output}" @ONLY CONTENT
    "${assembly}\n${externs}\nnamespace flexopt {\n\nstd::string_view embedded_file(std::string_view name) {\n${table}  return {};\n}\n\n}  // namespace flexopt\n")
  set_source_files_properties("${output}" PROPERTIES OBJECT_DEPENDS "${files}")
  target_sources(${target} PRIVATE "${output}")
endfunction()
