#include "verify/mesh_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace occam {
namespace {

int crossings(std::span<const Vec3f> corners, Vec3d at)
{
    int sum = 0;
    for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
        const Vec3d a = Vec3d(corners[t]) - at, b = Vec3d(corners[t + 1]) - at, c = Vec3d(corners[t + 2]) - at;
        // These are twice the areas between the ray and the sides, as seen along it. Two triangles have the same area with
        // other signs at the side that they share, so a ray passes through one of them.
        const double ab = a.y * b.z - a.z * b.y, bc = b.y * c.z - b.z * c.y, ca = c.y * a.z - c.z * a.y;
        const bool leaves = ab >= 0 && bc >= 0 && ca >= 0, enters = ab <= 0 && bc <= 0 && ca <= 0;
        if (leaves == enters) continue;
        const double ahead = bc * a.x + ca * b.x + ab * c.x;  // times the whole area
        if (leaves && ahead > 0) ++sum;
        if (enters && ahead < 0) --sum;
    }
    return sum;
}

}  // namespace

MeshPieces::MeshPieces(const Subject::Pair& pair)
{
    std::span<const Vec3f> left(pair.corners);
    for (const lod::LevelGrid& grid : pair.grids) {
        const auto count = static_cast<std::size_t>(grid.tile.rows * grid.tile.columns) * 6;
        Piece piece{{}, left.first(count)};
        for (const Vec3f& v : piece.corners) piece.box.add(Vec3d(v));
        pieces_.push_back(piece);
        left = left.subspan(count);
    }
}

double MeshPieces::distance(Vec3d p, double least) const
{
    double nearest2 = std::numeric_limits<double>::infinity();
    for (const Piece& piece : pieces_) {
        const Vec3d off = glm::max(glm::max(piece.box.lo - p, p - piece.box.hi), Vec3d(0));
        if (!(glm::dot(off, off) < nearest2)) continue;
        for (const Vec3f& v : piece.corners) {
            const Vec3d to = p - Vec3d(v);
            nearest2 = std::min(nearest2, glm::dot(to, to));
        }
        if (nearest2 < least * least) break;
    }
    return std::sqrt(nearest2);
}

int MeshPieces::crossings_along_x(Vec3d p) const
{
    int sum = 0;
    for (const Piece& piece : pieces_) {
        const Box3d& box = piece.box;
        if (p.x <= box.hi.x && p.y >= box.lo.y && p.y <= box.hi.y && p.z >= box.lo.z && p.z <= box.hi.z)
            sum += crossings(piece.corners, p);
    }
    return sum;
}

}  // namespace occam
