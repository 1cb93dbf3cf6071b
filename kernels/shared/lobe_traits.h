// SPDX-License-Identifier: Apache-2.0
// Traits of lobes, for host and kernels: what code outside of a lobe has to know of it. A row
// EK_LOBE of features.def lists those of its lobe.
#ifndef EK_SHARED_LOBE_TRAITS_H
#define EK_SHARED_LOBE_TRAITS_H

// The lobe is exactly Lambert's. It has no highlight, and path guiding steers it.
#define EK_TRAIT_LAMBERT 1u
// It scatters in several ways, and its function `sample` needs a random number to choose one.
#define EK_TRAIT_CHOICE 2u
// Light may go through the surface, so that lights behind it are sampled, too.
#define EK_TRAIT_TRANSMITS 4u
// It has microfacets of glTF's roughness, which may be anisotropic and lie under a thin film.
#define EK_TRAIT_MICROFACETS 8u
// It is a mixture of metal and dielectric, of which glTF's factor `metallic` is metal.
#define EK_TRAIT_METALLIC 16u
// It is metal throughout: nothing enters the surface, and a smooth one is a mirror.
#define EK_TRAIT_METAL 32u
// It has a diffuse base, which MaterialLanes.guide steers where the surface is not too metallic,
// and also its highlight where that is not too sharp (stages/shade/guide.h).
#define EK_TRAIT_GUIDED 64u

#endif
