#include "io/import/same_triangles.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "io/import/bits_key.h"
#include "io/import/key_numbers.h"
#include "io/import/vertices.h"
#include "scenegraph/contents.h"

namespace occam::import {

namespace {

// Meshes of fewer triangles, and those in which a ray passes fewer boxes of triangles, are quick to trace as they are.
constexpr std::size_t kFewTriangles = 4096;
constexpr double kFewBoxes = 256;

bool has_all_corners(const Cage& cage)
{
    return std::ranges::all_of(cage.face_vertices, [&](std::uint32_t v) { return v < cage.positions.size(); });
}

// Returns about how many boxes of triangles a ray passes that meets the mesh, by the surface area heuristic.
double boxes_on_a_ray(const Cage& cage)
{
    Box3d whole;
    double sum = 0;
    for (std::size_t c = 0; c + 2 < cage.face_vertices.size(); c += 3) {
        Box3d box;
        for (std::size_t k = c; k < c + 3; ++k) box.add(Vec3d(cage.positions[cage.face_vertices[k]]));
        whole.add(box);
        const double size = Contents::size_of(box);
        if (std::isfinite(size)) sum += size;
    }
    return sum / Contents::size_of(whole);
}

template <class T>
void keep(std::vector<T>& values, const std::vector<bool>& is_kept, std::size_t of_a_triangle)
{
    if (values.empty()) return;
    std::size_t to = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (is_kept[i / of_a_triangle]) values[to++] = values[i];
    values.resize(to);
}

}  // namespace

void drop_same_triangles(Cage& cage, Report& report)
{
    const std::size_t triangles = cage.face_vertices.size() / 3;
    if (triangles < kFewTriangles || !has_all_corners(cage) || !(boxes_on_a_ray(cage) > kFewBoxes)) return;
    const std::vector<std::uint32_t> place = places_of(cage).of;
    KeyNumbers<3> known;
    std::vector<bool> is_kept(triangles);
    std::size_t kept = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
        BitsKey<3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = place[cage.face_vertices[3 * t + k]];
        std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
        const std::size_t before = known.size();
        is_kept[t] = known.number_of(corners) == before;
        kept += is_kept[t];
    }
    if (kept == triangles) return;
    keep(cage.face_vertices, is_kept, 3);
    for (UvSet& set : cage.uv_sets) keep(set.indices, is_kept, 3);
    keep(cage.color_indices, is_kept, 3);
    keep(cage.face_slots, is_kept, 1);
    report.warn(std::to_string(triangles - kept) + " triangles dropped: another one lies in the same place", cage.name);
}

void check_boxes(const Cage& cage, const Report& report)
{
    if (double(cage.face_vertices.size()) / 3 < kMostBoxes || !has_all_corners(cage)) return;
    const double boxes = boxes_on_a_ray(cage);
    if (!(boxes > kMostBoxes)) return;
    char number[32];
    std::snprintf(number, sizeof number, "%.3g", boxes);
    throw Error(report.name(),
                "too many large triangles overlap: a ray would pass the boxes of about " + std::string(number) +
                    " of them, and " + std::to_string(static_cast<int>(kMostBoxes)) + " is the limit",
                cage.name);
}

}  // namespace occam::import
