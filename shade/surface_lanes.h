// Surfaces side by side, in lanes: what shade/bsdf.h does for one, with the same bits, for those that most hits find.
//
// Threads  each worker has its own.
#pragma once

#include "shade/direct.h"
#include "shade/frame_lanes.h"
#include "shade/layer.h"

namespace occam::shade {

/// What one sample of a light sends to each surface; see LightSample.
struct LightSampleLanes {
    VecLanes direction;
    vfloat distance;
    VecLanes radiance;
    vfloat density;
};

/// Holds opaque surfaces with no more than a base under a round layer, and a coat.
class SurfaceLanes {
public:
    /// Returns whether the surface is one of these.
    static bool takes(const Surface& surface) noexcept
    {
        return !surface.is_solid && surface.tangent == Vec3f(0) && surface.sheen == Vec3f(0) &&
               surface.transmission == Vec3f(0);
    }
    /// Puts a surface into a lane. All lanes have to be set, and then complete() called, before the rest is used.
    void set(int lane, const Surface& surface) noexcept;
    void complete() noexcept;

    /// Returns peak_density() of each.
    vfloat peak_density() const noexcept;
    /// Holds scatter() and scatter_density().
    struct Scattering {
        VecLanes light;
        vfloat density;
    };
    Scattering scatter_with_density(const VecLanes& to_light) const noexcept;
    /// Returns what samples of a light contribute: their radiance is that which leaves towards the eye.
    LightSampleLanes test_of(const LightSampleLanes& sample, vfloat light_count, vfloat scatter_count) const noexcept;

    /// Holds the result of sample_scatter() for each surface.
    struct Samples {
        LaneRows directions;  ///< and densities
        LaneRows weights;
        unsigned of_layer = 0, of_coat = 0;  ///< bits of the surfaces whose sample is of that lobe
        unsigned not_black = 0;              ///< bits of the surfaces whose sample has a weight

        ScatterSample at(int lane, const Surface& surface) const noexcept;
    };
    /// choice, u, v   numbers as sample_scatter() takes them
    Samples sample_scatter(vfloat choice, vfloat u, vfloat v) const noexcept;

private:
    struct Angles;
    VecLanes multiple_at(const FrameLanes& axes, vmask of, vfloat u, vfloat v, const VecLanes& otherwise) const noexcept;
    VecLanes reflected_at(const FrameLanes& axes, vfloat alpha, const DiscPoints& at) const noexcept;
    void add_coat(const VecLanes& to_light, vfloat side, Scattering& to) const noexcept;

    LaneVectors normal_, geometric_, to_eye_, coat_normal_, diffuse_, f0_;
    LaneVectors mix_f0_, mix_metal_f0_;
    LaneFloats mix_f90_, mix_share_, mix_metal_share_;
    LaneFloats f90_, alpha_, dielectric_f0_, dielectric_f90_, coat_, coat_alpha_;
    bool has_coat_ = false;  ///< of any surface
    // These follow from them.
    AlbedoTable::RowLanes row_;
    LayerOf<vfloat> layer_;
    LayerAlbedoOf<vfloat> eye_;
    vfloat n_v_, masking_, root_, below_coat_, coat_n_v_, lost_;
    vfloat share_diffuse_, share_multiple_, share_layer_, share_coat_;
};

}  // namespace occam::shade
