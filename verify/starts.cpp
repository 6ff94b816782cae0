#include "verify/starts.h"

#include <algorithm>
#include <cmath>

#include "lod/footprint.h"
#include "verify/closed.h"

namespace occam {
namespace {

// Returns the length of the longest edge of the pair's fine mesh. It may be far shorter than the edges of its level are
// allowed to be, where a patch needs many pieces whatever the level, or its rate follows from a few fast ones.
double longest_edge(const Subject::Pair& pair)
{
    float squared = 0;
    for (std::size_t i = 0; i < pair.corners.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f edge = pair.corners[i + k] - pair.corners[i + (k + 1) % 3];
            squared = std::max(squared, glm::dot(edge, edge));
        }
    return std::min(std::sqrt(double(squared)), double(lod::edge_length(pair.level)));
}

}  // namespace

StartSearch::StartSearch(Instant& instant, const Subject& subject, std::size_t instants, Random& random)
    : instant_(instant),
      random_(random),
      pieces_(instant.pairs.front()),
      instants_(instants),
      triangles_(instant.pairs.front().corners.size() / 3),
      is_displaced_(subject.posed().is_displaced()),
      turn_(subject.is_mirrored_at(instant.time) ? -1 : 1),
      edge_(longest_edge(instant.pairs.front()))
{
    for (const Vec3f v : instant.pairs.front().corners) box_.add(Vec3d(v));
}

bool StartSearch::is_inside_at(Vec3d p, double reach, bool needs_room) const
{
    for (const Subject::Pair& pair : instant_.pairs) {
        if (pair.level > instant_.pairs.front().level + 1 && lod::edge_length(pair.level) > 2 * reach) break;
        for (int k = 0; k < (needs_room ? 7 : 1); ++k) {
            Vec3d step(0);
            if (k > 0) step[(k - 1) / 2] = (k & 1 ? 0.25 : -0.25) * reach;
            if (!(turn_ * winding_number(pair.corners, p + step) > 0.9)) return false;
        }
    }
    return true;
}

bool StartSearch::try_at(Vec3d p, double least, bool needs_room, std::uint32_t face)
{
    const double distance = pieces_.distance(p, least);
    if (distance < least || turn_ * pieces_.crossings_along_x(p) < 1) return false;
    const double reach = std::min(distance, box_.radius()) * 0.5;
    if (!is_inside_at(p, reach, needs_room)) return false;
    instant_.starts.push_back({p, reach, face});
    instant_.has_inside = true;
    return true;
}

void StartSearch::anywhere(bool is_last)
{
    const std::vector<Vec3f>& corners = instant_.pairs.front().corners;
    const std::vector<Start>& starts = instant_.starts;
    // A large mesh and several moments leave few points for each moment, but at least two are looked for.
    const auto share = static_cast<std::size_t>(std::clamp<double>(4e6 / double(triangles_), 8, 256)) / instants_;
    const std::size_t most = std::max<std::size_t>(share, 8);
    // A point needs so much room that coarser meshes do not pass by it.
    const double least = 2 * edge_;
    const std::size_t tries = is_last ? 64 : 4;
    for (std::size_t attempt = 0; attempt < (starts.empty() ? tries : 4) * most && starts.size() < most / 4; ++attempt) {
        // Half of the points lie anywhere, half near the surface.
        Vec3d p = box_.lo + box_.extent() * Vec3d(uniform(random_), uniform(random_), uniform(random_));
        if (attempt & 1) p = Vec3d(pick(corners, random_)) + any_direction(random_) * (edge_ * uniform(random_, 2, 6));
        try_at(p, least, true);
    }
    // Few such points are inside of wires and of long poles. So points are tried behind triangles, too.
    // Each takes time in proportion to the mesh.
    constexpr double kTriesBehind = 4096;
    const double tries_behind = starts.empty() ? std::clamp<double>(4e8 / double(triangles_), 256, kTriesBehind) : 0;
    const std::size_t behind = static_cast<std::size_t>(tries_behind) / instants_;
    for (std::size_t attempt = 0; attempt < behind && starts.size() < most / 4; ++attempt) {
        const Vec3f* const corner = &corners[random_() % triangles_ * 3];
        const Vec3d normal = glm::cross(Vec3d(corner[1] - corner[0]), Vec3d(corner[2] - corner[0]));
        const double length = glm::length(normal);
        if (length > 0) try_at(Vec3d(corner[0]) - normal * (turn_ / length * edge_ * uniform(random_, 2, 6)), least, true);
    }
}

std::size_t StartSearch::behind(std::span<const std::uint32_t> faces)
{
    const double share = std::clamp(1e7 / double(triangles_), 4.0, 64.0) / double(instants_);
    const std::size_t most = std::max<std::size_t>(static_cast<std::size_t>(share), 1);
    std::size_t found = 0;
    for (std::size_t attempt = 0; attempt < 8 * most && found < most; ++attempt) found += try_behind(pick(faces, random_));
    return found;
}

bool StartSearch::try_behind(std::uint32_t face)
{
    const std::span<const lod::LevelGrid> grids = Subject::Pair::of_face(instant_.pairs.front().grids, face);
    if (grids.empty()) return false;
    const lod::LevelGrid& grid = pick(grids, random_);
    const int i = static_cast<int>(random_() % grid.tile.columns), j = static_cast<int>(random_() % grid.tile.rows);
    const Vec3d a(grid.vertex(i, j)), b(grid.vertex(i + 1, j)), c(grid.vertex(i + 1, j + 1)), d(grid.vertex(i, j + 1));
    const Vec3d normal = glm::cross(c - a, d - b), middle = (a + b + c + d) * 0.25;
    const double length = glm::length(normal), edge = std::max(glm::distance(a, c), glm::distance(b, d));
    if (!(length > 0)) return false;
    const double depth = is_displaced_ ? edge_ * uniform(random_, 2, 6) : edge * std::exp2(uniform(random_, -2, 3));
    return try_at(middle - normal * (turn_ / length * depth), is_displaced_ ? 2 * edge_ : 0.25 * edge, is_displaced_, face);
}

}  // namespace occam
