# The design files of families/ become texts of the program, in this order.
set(families
  leaf_spring parallel_guide cross_hinge three_flexure_cross_hinge clamped_plate
  folded_leaf wire_flexure tapered_leaf curved_leaf notch_hinge
  reinforced_guide double_parallelogram roberts_guide overconstrained_guide five_strut_guide
  cartwheel_hinge butterfly_hinge infinity_hinge trivot_hinge curved_hinge
  folded_leaf_stage xy_stage tip_tilt_stage spherical_joint diaphragm bridge_amplifier notch_guide lever_cell hexapod
)
set(names "")
set(texts "")
foreach(family IN LISTS families)
  set(file ${CMAKE_CURRENT_LIST_DIR}/families/${family}.json)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} text)
  string(APPEND names "      \"${family}\",\n")
  string(APPEND texts "  if (name == \"${family}\") return R\"design(${text})design\";\n")
endforeach()
set(FLEXOPT_LIBRARY_NAMES "${names}")
set(FLEXOPT_LIBRARY_TEXTS "${texts}")
set(library_source ${CMAKE_CURRENT_BINARY_DIR}/generated/library.cpp)
configure_file(${CMAKE_CURRENT_LIST_DIR}/library.cpp.in ${library_source} @ONLY)
