# SPDX-License-Identifier: Apache-2.0
# Read by ctest: the tests that take longest, in seconds of a slow core with nothing compiled yet. They start first, so that at the end
# no core waits for one long test. A name that is no more does no harm.
foreach(entry
    "EnergyCompensation.M4_clear_glass_cannot_be_seen_in_the_white_furnace_from_either_side 100"
    "Tools.every_stage_compiles_offline_without_a_warning_for_each_feature_alone 35"
    "Opacity.M22_any_lane_width_order_of_paths_tree_and_device_give_the_same_bits 75"
    "Shapes.every_way_to_trace_gives_the_same_film 75"
    "Bsdf.M5_no_more_light_leaves_than_arrives 70"
    "Render.the_same_bits_from_every_width_layout_and_from_oclgrind 70"
    "SameBits.any_lane_width_order_of_paths_and_tree 70"
    "ImplicitSurface.which_rays_give_up_hangs_on_rays_alone 65"
    "ShapeHits.rays_pass_shapes_in_the_same_places_everywhere 65"
    "SameBits.all_stages_in_one_launch_as_shipped_or_each_in_its_own_and_out_of_line_with_every_feature 60"
    "LightShapes.L6_inside_and_on_an_emissive_surface_all_is_finite_and_right 50"
    "ImageVersion.is_raised_when_the_bits_of_images_change 45"
    "MeasuredPictures.are_those_of_the_measured_materials_within_the_tables_resolution 45"
    "ShapeHits.every_structure_gives_the_hits_of_brute_force 45"
    "BsdfSampling.M1_samples_of_smooth_surfaces_have_the_density_that_pdf_states 40"
    "BsdfSampling.M1_samples_of_roughness_05_have_the_density_that_pdf_states 40"
    "BsdfSampling.M1_samples_of_roughness_3_have_the_density_that_pdf_states 40"
    "BsdfSampling.M1_samples_of_the_roughest_surfaces_have_the_density_that_pdf_states 40"
    "BsdfSampling.M1_samples_of_roughness_3_with_energy_compensation_have_the_density_that_pdf_states 40"
    "BsdfSampling.M1_samples_of_the_roughest_surfaces_with_energy_compensation_have_the_density_that_pdf_states 40"
    "LightShapes.each_shape_gives_the_same_light_by_each_way_of_finding_it 40"
    "LightTransport.every_way_of_finding_light_has_the_same_mean 35"
    "LightShapes.every_way_to_trace_and_every_scale_give_the_same_film 35"
    "Instances.G19_G17_stored_once_or_for_each_place_the_picture_has_the_same_bits 30"
    "OpacityTraverse.M22_of_coincident_triangles_the_first_that_is_there_wins 30"
    "OpacityTraverse.M22_hits_are_the_same_bits_in_every_layout 30")
  string(REPLACE " " ";" entry "${entry}")
  list(GET entry 0 test)
  list(GET entry 1 seconds)
  set_tests_properties("${test}" PROPERTIES COST "${seconds}")
endforeach()
