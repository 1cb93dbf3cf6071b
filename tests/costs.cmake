# SPDX-License-Identifier: Apache-2.0
# The tests and suites that take longest, in seconds with nothing compiled yet. They start first, so that at the end no core waits for
# one long test. A name that is no more does no harm.
set(costs
    "Pages.host/cli/README.md 157"
    "kernels.ShapeHits 150"
    "Farm.farm 140"
    "render.LightPaths 120"
    "render.SameBits 111"
    "kernels.Traverse 109"
    "render.Opacity 93"
    "kernels.TraverseMotion 90"
    "render.ImplicitSurface 80"
    "render.Shapes 80"
    "render.Culling 79"
    "render.LightShapes 78"
    "render.Instances 70"
    "data_races 70"
    "kernels.BsdfSampling 60"
    "render.LightArea 60"
    "render.Materials 60"
    "Render.the_same_bits_from_every_width_layout_and_from_oclgrind 60"
    "render.GlossyTargets 60"
    "render.ShapeTangents 55"
    "render.NestedMedia 50"
    "Blender.blender 50"
    "render.Geometry 45"
    "render.LightPathBits 40"
    "Pages.README.md 40"
    "Tools.every_stage_compiles_offline_without_a_warning_for_each_feature_alone 37"
    "kernels.Implicit 34"
    "kernels.TraverseHard 33"
    "kernels.OpacityTraverse 31"
    "kernels.Bsdf 30"
    "kernels.CullingTraverse 30"
    "render.LightTree 30"
    "render.LightEnvironment 30"
    "render.LightPunctual 30"
    "zero_cost 30"
    "render.Faults 26"
    "kernels.EnergyCompensation 25"
    "render.HiddenBoundaries 25"
    "render.LightSamples 25"
    "render.Merging 25"
    "render.LightAimRender 25"
    "kernels.LightShapes 23"
    "kernels.MeasuredLobe 23"
    "MixedDevices.N5_three_of_two_drivers_give_the_bits_of_one 20"
    "kernels.TraverseInstances 20"
    "Farm.openjd 20"
    "kernels.BsdfPhysics 20"
    "render.LightTransport 20"
    "kernels.LightPathStarts 17"
    "render.LightPathSources 17"
    "PilotUnderWay.another_device_takes_over_from_one_that_hangs_or_is_lost 16")
# CMake sets those of the tests that it knows (CMakeLists.txt). The others are found when the binaries are built, and ctest, which knows
# no project, sets theirs.
if(NOT DEFINED PROJECT_NAME)
  foreach(entry ${costs})
    string(REPLACE " " ";" entry "${entry}")
    list(GET entry 0 test)
    list(GET entry 1 seconds)
    set_tests_properties("${test}" PROPERTIES COST "${seconds}")
  endforeach()
endif()
