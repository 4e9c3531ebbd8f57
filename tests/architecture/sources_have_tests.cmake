cmake_minimum_required(VERSION 3.25)
# Fails if a source of core, designs, optim or results has no test: tests/ROOM/test_NAME.cpp for
# ROOM/NAME.cpp, or another test that the list below names, or a reason there.
#   cmake -D SOURCE=<repository> -P sources_have_tests.cmake

# Source, and the test under tests/ that is about it although it has another name.
set(tested_by
  core/elements/plate/beam_element core/elements/plate/test_beam_leaf
  core/elements/plate/beam_stress core/elements/plate/test_beam_leaf
  core/elements/plate/full_leaf_linear core/response/gradients/test_point_gradients
  core/elements/leaf/leaf_stress core/elements/plate/test_plate_stress
  core/elements/plate/strain_field core/elements/plate/test_plate_stress
  core/elements/plate/deformed_plate core/elements/plate/test_plate_stress
  core/elements/plate/full_model core/elements/leaf/test_full_model
  core/elements/solid/mesh_energy core/elements/solid/test_quartic
  core/elements/solid/solid_check core/elements/solid/test_solid_condensation
  core/elements/solid/solid_element core/elements/solid/test_solid_condensation
  core/elements/solid/solid_model_rates core/elements/solid/test_solid_condensation
  core/elements/solid/solid_products core/elements/solid/test_solid_condensation
  core/math/sparse_definite core/elements/solid/test_solid_condensation
  core/elements/plate/full_leaf core/elements/plate/test_leaf_closed_forms
  core/elements/plate/element_numbers core/elements/plate/test_transverse_shear
  core/elements/plate/mesh_numbers core/elements/plate/test_leaf_profiles
  core/elements/plate/plate_gradient core/response/gradients/test_point_gradients
  core/elements/plate/plate_leaf_dynamics core/elements/plate/test_leaf_closed_forms
  core/elements/plate/plate_leaf_tangent core/elements/plate/test_plate_leaf
  core/elements/plate/plate_mesh core/elements/plate/test_plate_leaf
  core/elements/plate/plate_mesh_rate core/response/gradients/test_point_gradients
  core/elements/plate/plate_fold_gradient core/response/gradients/test_fold_gradients
  core/elements/plate/plate_gradient_quadratic core/response/gradients/test_point_gradients
  core/elements/plate/plate_point_gradient core/response/gradients/test_material_point_gradients
  core/elements/plate/plate_series core/response/path/test_frequency_derivatives
  core/elements/plate/plate_series_edges core/response/path/test_frequency_derivatives
  core/response/actuators designs/test_actuators
  designs/describe designs/test_families
  designs/design_items designs/test_design_files
  designs/design_plan designs/test_design_files
  designs/design_reader designs/test_design_files
  designs/design_shape designs/test_design_files
  designs/elastic_mechanism designs/test_elastic_designs
  designs/elastic_reader designs/test_elastic_designs
  designs/expand designs/test_design_files
  designs/family designs/test_families
  designs/flat_mechanism designs/test_design_files
  designs/flatten designs/test_design_files
  designs/flatten_elastic designs/test_elastic_designs
  designs/flatten_items designs/test_design_files
  designs/flatten_leaves designs/test_design_files
  designs/flatten_shapes designs/test_elastic_designs
  designs/formula_words designs/test_design_files
  designs/solids/solid_faces designs/test_elastic_designs
  designs/materials designs/test_families
  core/elements/solid/held_body core/test_elastic_mechanism
  core/equilibrium/elastic_bodies core/test_elastic_mechanism
  core/equilibrium/elastic_degree core/test_elastic_mechanism
  core/equilibrium/elastic_stress core/test_elastic_stress
  core/response/gradients/elastic_gradients core/test_elastic_mechanism
  core/mechanism/elastic_body core/test_elastic_mechanism
  designs/solids/notch_mesh designs/test_solid_meshes
  designs/solids/plan_mesh designs/test_solid_meshes
  designs/solids/tensor_lines designs/test_solid_meshes
  designs/solids/tensor_mesh designs/test_solid_meshes
  designs/solids/contour_curves designs/test_contour_meshes
  designs/solids/contour_mesh designs/test_contour_meshes
  designs/solids/contour_outline designs/test_contour_meshes
  designs/solids/contour_sizes designs/test_contour_meshes
  designs/solids/triangles designs/test_contour_meshes
  designs/solids/import_inp designs/test_imported_meshes
  designs/solids/import_matrices designs/test_imports
  designs/solids/import_mesh designs/test_imported_meshes
  designs/solids/import_msh designs/test_imported_meshes
  designs/solids/matrix_checks designs/test_imports
  designs/solids/matrix_files designs/test_imports
  designs/solids/numbered_lines designs/test_imported_meshes
  core/equilibrium/free_motions core/equilibrium/test_joints
  core/equilibrium/solve_equilibrium core/equilibrium/test_stroke_path
  core/equilibrium/system core/equilibrium/test_joints
  core/math/eigenvalue_branches core/response/test_principal_stiffness
  core/mechanism/body_inertia designs/test_design_files
  core/mechanism/dependent_joints core/mechanism/test_joint
  core/mechanism/leaf_in_solid designs/test_elastic_designs
  core/mechanism/load_case core/equilibrium/test_dead_loads
  core/math/sparse_matrix core/math/test_sparse_solver
  core/math/nearest_rotation core/math/test_rotation
  core/math/chebyshev core/reduction/atlas/test_tube_atlas
  core/reduction/atlas/make_atlas core/reduction/atlas/test_tube_atlas
  core/reduction/atlas/ray_interpolation core/reduction/atlas/test_tube_atlas
  core/reduction/atlas/atlas_part core/reduction/atlas/test_coded_tables
  core/reduction/atlas/number_units core/reduction/atlas/test_shipped_atlas
  core/reduction/atlas/state_look_up core/reduction/atlas/test_dynamics_atlas
  core/reduction/atlas/expanded_leaf core/reduction/atlas/test_looked_up_mechanism
  core/elements/leaf/chord_gradient core/reduction/tube/test_tube_leaf_gradient
  core/reduction/expansion/dynamics_expansion core/reduction/tube/test_tube_dynamics
  core/reduction/expansion/load_fields core/reduction/tube/test_tube_dynamics
  core/reduction/expansion/stress_expansion core/reduction/tube/test_tube_stress
  core/reduction/expansion/tube_expansion core/reduction/tube/test_tube_leaf
  core/reduction/tube/interval_coefficients core/reduction/tube/test_tube_potential
  core/elements/leaf/chord_edges core/reduction/superelement/test_modal_derivatives
  core/reduction/tube/dynamics_entries core/reduction/tube/test_dynamics_form
  core/reduction/tube/state_table core/reduction/tube/test_tube_dynamics
  core/reduction/tube/tube_leaf_dynamics core/reduction/tube/test_tube_dynamics
  core/reduction/tube/tube_leaf_stress core/reduction/tube/test_tube_stress
  core/reduction/superelement/leaf_chain core/reduction/superelement/test_modal_leaf
  core/reduction/superelement/superelement_grid core/reduction/superelement/test_superelement_points
  core/reduction/superelement/superelement_leaf_results
    core/reduction/superelement/test_superelement_leaf
  core/reduction/superelement/superelement_rule
    core/reduction/superelement/test_superelement_points
  core/response/named_rows core/response/modes/test_point_forces
  core/response/gradients/named_point_rates core/response/modes/test_point_forces
  core/response/modes/harmonic_terms core/response/modes/test_dynamics_measures
  core/response/modes/transfers core/response/modes/test_point_forces
  core/response/modes/harmonic_answer core/response/modes/test_dynamics_measures
  core/response/modes/rigid_motion core/response/modes/test_dynamics_measures
  core/response/stability/branch_tracer core/response/stability/test_critical_load
  core/response/stability/load_branch core/response/stability/test_critical_load
  core/response/stability/load_trial core/response/stability/test_load_capacity
  core/response/stability/softening core/response/stability/test_critical_load
  core/response/gradients/design_rates core/response/gradients/test_point_gradients
  core/response/gradients/moving_places core/response/gradients/test_point_gradients
  core/response/modes/classified_modes core/response/modes/test_full_modes
  core/response/modes/constant_mass core/response/modes/test_mass_options
  core/response/modes/frequencies core/response/path/test_response
  core/response/modes/mechanism_factor core/response/modes/test_full_modes
  core/response/modes/mechanism_pencil core/response/path/test_response
  core/response/path/evaluate_stroke core/response/path/test_response
  core/response/stability/capacity_limits core/response/stability/test_load_capacity
  core/equilibrium/end_effector_compliance core/response/path/test_response
  core/response/path/stroke_ways core/response/path/test_mode_tracking
  core/response/clearance core/response/test_room_taken
  core/response/extents core/response/test_room_taken
  core/response/leaf_mass core/response/test_room_taken
  core/response/solid_rates core/response/test_solids
  core/response/undeflected_place core/response/test_solids
  core/response/named_point core/response/path/test_material_points
  core/response/quantities core/response/path/test_response
  core/response/capacity_rows core/response/path/test_response
  core/response/quantity_rows core/response/path/test_response
  core/response/request core/response/path/test_response
  core/response/gradients/link_gradients core/response/gradients/test_joint_gradients
  core/response/path/branch core/response/path/test_response
  core/response/path/estimated_numbers core/response/path/test_error_estimate
  core/response/path/full_finish core/response/gradients/test_point_gradients
  core/response/path/point_dynamics core/response/path/test_response
  core/response/path/point_outputs core/response/path/test_response
  core/response/path/mechanism_series
    core/response/path/test_frequency_derivatives
  core/spec/formula_dimensions core/spec/test_formula
  core/spec/formula_functions core/spec/test_formula
  core/spec/formula_parser core/spec/test_formula
  core/spec/formula_tokens core/spec/test_formula
  core/spec/json_schema optim/job/test_job_schema
  core/spec/spec_error core/spec/test_json_file
  optim/studies/comparison optim/studies/test_compare
  optim/job/compared_quantity optim/studies/test_compare
  optim/job/expression optim/job/test_job
  optim/job/job_assembly optim/studies/test_assembly_study
  optim/job/job_capacity optim/job/test_job_wrong
  optim/job/job_compare optim/studies/test_samples
  optim/job/job_design optim/job/test_job
  optim/job/job_goals optim/job/test_job_optimise
  optim/job/job_loads optim/job/test_job
  optim/job/job_maps optim/studies/test_response_map
  optim/job/job_numbers optim/job/test_job
  optim/job/job_points optim/job/test_job_dynamics
  optim/job/job_shape optim/job/test_job
  optim/job/job_tables optim/job/test_job
  optim/job/model_table optim/job/test_job
  optim/job/search_tables optim/job/test_job_optimise
  optim/job/job_tolerances optim/studies/test_tolerance_study
  optim/search/answer optim/search/test_optimise
  optim/problem/check_gradients results/cli/test_command_line
  optim/problem/gradient_checker results/cli/test_command_line
  optim/problem/design_problem optim/search/test_exact_gradients
  optim/problem/goal_bounds optim/search/test_optimise
  optim/problem/goal_readings optim/search/test_exact_gradients
  optim/problem/evaluation_book optim/problem/test_evaluation_log
  optim/problem/line_log optim/problem/test_evaluation_log
  optim/problem/posing optim/search/test_exact_gradients
  optim/search/pareto optim/search/test_stages
  optim/search/search optim/search/test_optimise
  optim/search/stock optim/search/test_stages
  optim/search/verification optim/search/test_stages
  optim/solvers/ipopt_optimiser optim/solvers/test_hock_schittkowski
  optim/solvers/nlopt_optimiser optim/solvers/test_hock_schittkowski
  optim/solvers/trials optim/solvers/test_optimiser
  results/cli/atlas_command results/cli/test_command_line
  results/cli/commands results/cli/test_command_line
  results/cli/run_command results/run/test_shard
  results/cli/printed results/cli/test_terminal
  results/export/parts_picture results/export/test_design_drawing
  results/export/placed_design results/export/test_measures
  results/export/view_picture results/export/test_design_drawing
  results/export/ccx_limits results/export/test_ccx_deck
  results/export/ccx_model results/export/test_ccx_deck
  results/export/convex_hull results/export/test_triangles
  results/export/leaf_surface results/export/test_stl
  results/export/parts results/export/test_stl
  results/export/step_writer results/export/test_step
  results/files/comparison_json results/files/test_comparison
  results/files/optimum_json results/run/test_run_files
  results/files/path_point_json results/files/test_result_json
  results/files/result_context results/files/test_result_json
  results/files/tolerances jobs/test_load_cases
  results/cli/program results/cli/test_command_line
  results/library/jobs results/library/test_flexopt
  results/library/results results/library/test_flexopt
  results/library/runs results/python/test_runs
  results/server/local_server results/server/test_serve
  results/run/run results/run/test_run_files
  results/files/run_record results/run/test_run_files
  results/files/scene_modes results/files/test_scene
)
# Source, and why it has no test.
set(untested
  results/export/gltf "tests/results/export/test_gltf.mjs, by the validator of glTF"
  core/elements/plate/plate_fields "tables of strain operators, used by every test of a plate"
  core/elements/leaf/leaf_gradient "sums of what leaves answer, used by every test of a gradient"
  core/elements/leaf/leaf_scale "units of a leaf, used by every test of a leaf"
  core/math/eigen_layout "one symbol, tested by the programs that must not link (architecture)"
  core/elements/leaf/leaf_element "the answer of a leaf that cannot do something"
  results/python/module "names for Python, used by every test of the module"
  results/cli/main "one call of what results/cli/program has"
  results/files/version "the version and commit of the build"
)

set(wrong "")
set(listed "")
set(files 0)
macro(take list first second)
  list(POP_FRONT ${list} ${first} ${second})
  list(APPEND listed ${${first}})
  if(NOT EXISTS ${SOURCE}/${${first}}.cpp)
    list(APPEND wrong "${${first}}.cpp is in the list, but not there")
  endif()
endmacro()
while(tested_by)
  take(tested_by source test)
  if(NOT EXISTS ${SOURCE}/tests/${test}.cpp AND NOT EXISTS ${SOURCE}/tests/${test}.py)
    list(APPEND wrong "${source}.cpp: its test tests/${test}.cpp is not there")
  endif()
endwhile()
while(untested)
  take(untested source reason)
endwhile()
foreach(folder core designs optim results)
  file(GLOB_RECURSE sources RELATIVE ${SOURCE} ${SOURCE}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX node_modules)
  foreach(source IN LISTS sources)
    math(EXPR files "${files} + 1")
    string(REGEX REPLACE "\\.cpp$" "" source ${source})
    get_filename_component(room ${source} DIRECTORY)
    get_filename_component(name ${source} NAME)
    if(EXISTS ${SOURCE}/tests/${room}/test_${name}.cpp OR
       EXISTS ${SOURCE}/tests/${room}/test_${name}.py)
      if(source IN_LIST listed)
        list(APPEND wrong "${source}.cpp has a test of its name; take it out of the list")
      endif()
    elseif(NOT source IN_LIST listed)
      list(APPEND wrong "${source}.cpp: no tests/${room}/test_${name}.cpp, and not in the list")
    endif()
  endforeach()
endforeach()
if(files LESS 20)
  message(FATAL_ERROR "only ${files} sources found in ${SOURCE}: nothing was checked")
endif()
if(wrong)
  list(JOIN wrong "\n  " wrong)
  message(FATAL_ERROR "sources without a test:\n  ${wrong}")
endif()
message(STATUS "${files} sources, each with a test or a reason")
