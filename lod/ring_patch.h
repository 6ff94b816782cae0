// A patch near a large face or vertex: its control points among the derived points, and its limit surface.
//
// A patch of a face of four corners is four quads of the cage refined once, and one of any other face is one quad. Such a
// quad depends on the quads around its corners, but near a large vertex only on a few spokes on either side: one more for
// each level of refinement. So the quads around a large vertex are cut off there, the vertex itself is held where it is, and
// its moves are added with the weights of a FanModel: a move at step k changes the surface as far as two steps of that
// level.
//
// This header is private to lod/.
#pragma once

#include "lod/derived_points.h"

namespace occam::lod {

/// Describes such a patch. Equal keys have equal limit stencils, control point by control point.
struct RingPatch {
    /// A large vertex at a corner of a quad.
    struct Pole {
        int corner = 0;
        std::uint32_t first_move = 0;  ///< in `controls`
        std::vector<float> sharpness;  ///< of the spokes that are left
        std::size_t own = 0;           ///< the spoke before the quad, clockwise
    };
    struct Quad {
        std::vector<Pole> poles;
    };

    std::vector<std::uint32_t> key;
    std::vector<std::uint32_t> controls;  ///< derived points
    int crease_depth = 0;                 ///< as PatchClass has it
    Cage mesh;                            ///< its first faces are `quads`, from the corner of the patch on
    std::vector<Quad> quads;

    /// Returns how many of the last controls are moves of large vertices.
    std::uint32_t move_count() const noexcept;
    /// Returns about how many bytes it takes without its key.
    std::size_t bytes() const noexcept;
};

RingPatch ring_patch(const DerivedPoints& points, PatchRef patch, BoundaryRule boundary);
std::unique_ptr<const LimitSource> limit_source(const DerivedPoints& points, const RingPatch& patch);

/// Returns the derived points at the corners of a patch of a bilinear face, (0, 0) first and counter-clockwise.
std::vector<std::uint32_t> corner_points(const DerivedPoints& points, PatchRef patch);
/// Returns a source for four control points in that order, with bilinear weights.
std::unique_ptr<const LimitSource> bilinear_source();

}  // namespace occam::lod
