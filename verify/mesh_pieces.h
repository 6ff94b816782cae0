// Divides the mesh of a diced cage by its grids, each in a box. Points that are tried as starts of rays, and lie too near to
// the mesh or outside of it, are rejected quickly.
#pragma once

#include <span>
#include <vector>

#include "base/box.h"
#include "verify/subject.h"

namespace occam {

class MeshPieces {
public:
    /// Borrows the corners of the pair.
    explicit MeshPieces(const Subject::Pair& pair);

    /// Returns the distance of a point to the nearest vertex, or any distance below `least` if it is smaller than that.
    double distance(Vec3d p, double least) const;
    /// Returns how many more triangles a ray from a point along +x leaves through than it enters through. For a closed mesh
    /// this is the winding number. A ray through a gap at a T-vertex may give another number.
    int crossings_along_x(Vec3d p) const;

private:
    struct Piece {
        Box3d box;
        std::span<const Vec3f> corners;  ///< three per triangle
    };
    std::vector<Piece> pieces_;
};

}  // namespace occam
