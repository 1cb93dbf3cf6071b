# SPDX-License-Identifier: Apache-2.0
# The tests and suites that take longest, in seconds with nothing compiled yet. They start first, so that at the end no core waits for
# one long test. A name that is no more does no harm.
set(costs
    "Pages.host/cli/README.md 157"
    "Farm.farm 200"
    "kernels.ShapeHits 150"
    "render.LightPaths 120" "render.LightPathBits 40"
    "render.SameBits 111"
    "kernels.BsdfSampling 110"
    "kernels.Traverse 109"
    "render.Opacity 93"
    "render.ImplicitSurface 80"
    "render.Shapes 80"
    "render.Culling 79"
    "render.Instances 70"
    "kernels.TraverseMotion 60"
    "render.LightShapes 78"
    "render.LightArea 60"
    "render.Materials 60"
    "Render.the_same_bits_from_every_width_layout_and_from_oclgrind 55"
    "render.ShapeTangents 55"
    "render.NestedMedia 50"
    "kernels.Bsdf 43"
    "Pages.README.md 40"
    "render.Geometry 40"
    "kernels.EnergyCompensation 36"
    "kernels.Implicit 34"
    "kernels.TraverseHard 33"
    "kernels.OpacityTraverse 31"
    "kernels.CullingTraverse 30"
    "Tools.every_stage_compiles_offline_without_a_warning_for_each_feature_alone 30"
    "render.LightTree 30"
    "render.LightEnvironment 30"
    "render.LightPunctual 30"
    "render.Faults 26"
    "render.HiddenBoundaries 25"
    "render.LightSamples 25"
    "kernels.LightShapes 23"
    "kernels.MeasuredLobe 23"
    "MixedDevices.N5_three_of_two_drivers_give_the_bits_of_one 20"
    "kernels.TraverseInstances 20"
    "Farm.openjd 20"
    "kernels.LightPathStarts 17")
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
