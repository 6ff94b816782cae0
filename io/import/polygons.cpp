#include "io/import/polygons.h"

#include <algorithm>

#include "io/import/polygon_files.h"

namespace occam::import {

namespace {

// Clipping ears costs up to the cube of the number of corners: larger polygons are cut as fans.
constexpr std::size_t kMaxEarCorners = 64;

Vec3d newell_normal(std::span<const Vec3f> p)
{
    Vec3d n(0);
    for (std::size_t i = 0; i < p.size(); ++i)
        n += glm::cross(Vec3d(p[i]) - Vec3d(p[0]), Vec3d(p[(i + 1) % p.size()]) - Vec3d(p[0]));
    return n;
}

// Twice the area of the triangle, seen along n; positive: counter-clockwise.
double turn(Vec3d n, Vec3f a, Vec3f b, Vec3f c) { return glm::dot(n, glm::cross(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(a))); }

bool is_convex(Vec3d n, std::span<const Vec3f> p)
{
    const std::size_t size = p.size();
    for (std::size_t i = 0; i < size; ++i)
        if (turn(n, p[i], p[(i + 1) % size], p[(i + 2) % size]) < 0) return false;
    return true;
}

bool is_ear(Vec3d n, std::span<const Vec3f> p, const std::vector<std::uint32_t>& ring, std::size_t i)
{
    const std::size_t size = ring.size();
    const std::uint32_t a = ring[(i + size - 1) % size], b = ring[i], c = ring[(i + 1) % size];
    if (turn(n, p[a], p[b], p[c]) <= 0) return false;
    return std::none_of(ring.begin(), ring.end(), [&](std::uint32_t q) {
        return q != a && q != b && q != c && turn(n, p[a], p[b], p[q]) >= 0 && turn(n, p[b], p[c], p[q]) >= 0 &&
               turn(n, p[c], p[a], p[q]) >= 0;
    });
}

// Vertices by (position, normal): the copies of a position form a list that starts at the position's own index.
class VertexSplitter {
public:
    VertexSplitter(std::size_t vertices) : normal_of_(vertices, kUnset), next_(vertices, kNoIndex), source_(vertices)
    {
        for (std::size_t v = 0; v < vertices; ++v) source_[v] = static_cast<std::uint32_t>(v);
    }
    std::uint32_t vertex(std::uint32_t position, std::uint32_t normal)
    {
        if (position >= normal_of_.size()) return kNoIndex;
        std::uint32_t v = position;
        while (normal_of_[v] != normal) {
            if (normal_of_[v] == kUnset) {
                normal_of_[v] = normal;
                break;
            }
            if (next_[v] == kNoIndex) {
                next_[v] = static_cast<std::uint32_t>(normal_of_.size());
                normal_of_.push_back(normal);
                next_.push_back(kNoIndex);
                source_.push_back(position);
            }
            v = next_[v];
        }
        return v;
    }
    template <class T>
    void spread(std::vector<T>& values) const
    {
        if (values.empty()) return;
        const std::size_t old_size = values.size();
        values.resize(source_.size());
        for (std::size_t v = old_size; v < source_.size(); ++v) values[v] = values[source_[v]];
    }
    const std::vector<std::uint32_t>& normal_of() const { return normal_of_; }

private:
    static constexpr std::uint32_t kUnset = 0xfffffffe;
    std::vector<std::uint32_t> normal_of_, next_, source_;
};

void split_by_normal(Polygons& polygons)
{
    Cage& cage = polygons.cage;
    VertexSplitter splitter(cage.positions.size());
    for (std::size_t c = 0; c < cage.face_vertices.size(); ++c)
        cage.face_vertices[c] = splitter.vertex(cage.face_vertices[c], polygons.normal_indices[c]);
    splitter.spread(cage.positions);
    splitter.spread(cage.colors);
    for (UvSet& set : cage.uv_sets)
        if (set.indices.empty()) splitter.spread(set.values);
    cage.normals.resize(cage.positions.size());
    for (std::size_t v = 0; v < cage.normals.size(); ++v) {
        const std::uint32_t n = splitter.normal_of()[v];
        cage.normals[v] = n < polygons.normals.size() ? polygons.normals[n] : Vec3f(0);  // sanitize() makes one
    }
}

// Corners without coordinates share one value at the end.
void fill_missing_uvs(Cage& cage)
{
    for (UvSet& set : cage.uv_sets) {
        const std::uint32_t spare = static_cast<std::uint32_t>(set.values.size());
        bool is_used = false;
        for (std::uint32_t& i : set.indices)
            if (i == kNoIndex) i = spare, is_used = true;
        if (is_used) set.values.push_back(Vec2f(0));
    }
}

}  // namespace

void cut_polygon(std::span<const Vec3f> corners, std::vector<std::uint32_t>& out)
{
    const std::uint32_t size = static_cast<std::uint32_t>(corners.size());
    const Vec3d n = newell_normal(corners);
    if (size > 3 && size <= kMaxEarCorners && !is_convex(n, corners)) {
        std::vector<std::uint32_t> ring(size);
        for (std::uint32_t i = 0; i < size; ++i) ring[i] = i;
        while (ring.size() > 3) {
            std::size_t ear = 0;
            while (ear < ring.size() && !is_ear(n, corners, ring, ear)) ++ear;
            if (ear == ring.size()) ear = 0;  // it crosses itself: no cut is right
            const std::size_t before = (ear + ring.size() - 1) % ring.size(), after = (ear + 1) % ring.size();
            out.insert(out.end(), {ring[before], ring[ear], ring[after]});
            ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
        }
        out.insert(out.end(), ring.begin(), ring.end());
        return;
    }
    for (std::uint32_t i = 1; i + 1 < size; ++i) out.insert(out.end(), {0u, i, i + 1});
}

Cage triangulate(Polygons polygons)
{
    if (!polygons.normal_indices.empty()) split_by_normal(polygons);
    Cage& in = polygons.cage;
    Cage out = std::move(in);
    const std::vector<std::uint32_t> sizes = std::move(out.face_sizes), vertices = std::move(out.face_vertices),
                                     holes = std::move(out.holes);
    const std::vector<std::uint16_t> slots = std::move(out.face_slots);
    std::vector<std::vector<std::uint32_t>> uv_indices;
    for (UvSet& set : out.uv_sets) uv_indices.push_back(std::move(set.indices));
    out.face_sizes.clear(), out.face_vertices.clear(), out.holes.clear(), out.face_slots.clear();
    for (UvSet& set : out.uv_sets) set.indices.clear();
    out.creases.clear(), out.corners.clear();
    out.scheme = Scheme::Triangles;

    std::vector<bool> is_hole(sizes.size(), false);
    for (std::uint32_t hole : holes)
        if (hole < is_hole.size()) is_hole[hole] = true;
    std::vector<Vec3f> corners;
    std::vector<std::uint32_t> cut;
    out.face_vertices.reserve(vertices.size() * 3 / 2);
    for (std::size_t f = 0, begin = 0; f < sizes.size(); begin += sizes[f++]) {
        if (is_hole[f] || sizes[f] < 3) continue;
        corners.clear(), cut.clear();
        for (std::uint32_t c = 0; c < sizes[f]; ++c) {
            const std::uint32_t v = vertices[begin + c];
            corners.push_back(v < out.positions.size() ? out.positions[v] : Vec3f(0));
        }
        cut_polygon(corners, cut);
        for (std::uint32_t c : cut) {
            out.face_vertices.push_back(vertices[begin + c]);
            for (std::size_t s = 0; s < uv_indices.size(); ++s)
                if (!uv_indices[s].empty()) out.uv_sets[s].indices.push_back(uv_indices[s][begin + c]);
        }
        if (!slots.empty()) out.face_slots.insert(out.face_slots.end(), cut.size() / 3, slots[f]);
    }
    fill_missing_uvs(out);
    return out;
}

Cage settle(Polygons polygons, Subdivide subdivide)
{
    const auto has_polygon = [&] {
        return std::any_of(polygons.cage.face_sizes.begin(), polygons.cage.face_sizes.end(),
                           [](std::uint32_t n) { return n > 3; });
    };
    if (subdivide == Subdivide::Off || (subdivide == Subdivide::Auto && !polygons.is_tagged && !has_polygon()))
        return triangulate(std::move(polygons));
    fill_missing_uvs(polygons.cage);
    return std::move(polygons.cage);
}

Scene scene_of(Polygons polygons, const LoadOptions& options, Report& report)
{
    if (polygons.cage.face_sizes.empty()) throw Error(report.name(), "there is no face in it");
    Scene scene;
    Cage cage = settle(std::move(polygons), options.subdivide);
    cage.name = report.file().stem().string();
    const std::string name = cage.name;
    const CageId id = scene.add(std::move(cage));
    scene.add_node(scene.root(), {.name = name, .cages = {id}});
    finish(scene, report);
    return scene;
}

}  // namespace occam::import
