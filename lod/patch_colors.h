// Vertex colours over a patch: bilinear between the cage's corners.
//
// Colours lie on a face as texture coordinates do with FaceVaryingRule::All: on a quad's four corners, or on the quadrant of
// an n-gon between a corner, the middles of its two edges and the mean of all corners. They are continuous over edges whose
// corners agree, but not smoother.
#pragma once

#include "lod/posed_cage.h"

namespace occam::lod {

class PatchColors {
public:
    /// The cage must have colours and a topology.
    PatchColors(const PosedCage& cage, PatchRef patch) noexcept;

    Vec4f at(float u, float v) const noexcept
    {
        return (corner_[0] * (1 - u) + corner_[1] * u) * (1 - v) + (corner_[3] * (1 - u) + corner_[2] * u) * v;
    }

private:
    Vec4f corner_[4];  ///< at (0, 0), (1, 0), (1, 1), (0, 1)
};

}  // namespace occam::lod
