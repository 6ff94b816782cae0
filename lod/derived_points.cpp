#include "lod/derived_points.h"

#include <algorithm>

#include "base/cancellation.h"
#include "base/check.h"
#include "lod/refined_point.h"
#include "lod/unsafe_faces.h"

namespace occam::lod {

using namespace OpenSubdiv;

namespace {

/// Returns a sharpness after some steps of refinement.
float sharpness_after(float sharpness, int steps) noexcept
{
    return Sdc::Crease::IsInfinite(sharpness) ? sharpness : std::max(0.0f, sharpness - static_cast<float>(steps));
}

void add_quad(Cage& mesh, const std::array<std::uint32_t, 4>& vertices)
{
    mesh.face_sizes.push_back(4);
    mesh.face_vertices.insert(mesh.face_vertices.end(), vertices.begin(), vertices.end());
}

/// Makes the mesh of a FanModel: three quads along each spoke, in all sectors, around a vertex that stays where it is.
Cage fan_mesh(std::span<const float> sharpness)
{
    constexpr std::uint32_t kRings = 3;
    const auto spokes = static_cast<std::uint32_t>(sharpness.size());
    const auto at = [&](std::uint32_t sector, std::uint32_t x, std::uint32_t y) -> std::uint32_t {
        if (x == 0 && y == 0) return 0;
        if (y == 0) return sector * kRings + x;
        if (x == 0) return (sector + 1) * kRings + y;
        return spokes * kRings + sector * kRings * kRings + (y - 1) * kRings + x;
    };
    Cage mesh;
    mesh.boundary = BoundaryRule::EdgeOnly;
    mesh.positions.resize(1 + spokes * kRings + (spokes - 1) * kRings * kRings);
    for (std::uint32_t sector = 0; sector + 1 < spokes; ++sector)
        for (std::uint32_t y = 0; y < kRings; ++y)
            for (std::uint32_t x = 0; x < kRings; ++x)
                add_quad(mesh, {at(sector, x, y), at(sector, x + 1, y), at(sector, x + 1, y + 1), at(sector, x, y + 1)});
    for (std::uint32_t spoke = 1; spoke + 1 < spokes; ++spoke)
        for (std::uint32_t x = 0; x < kRings && sharpness[spoke] > 0; ++x)
            mesh.creases.push_back({at(spoke, x, 0), at(spoke, x + 1, 0), sharpness[spoke]});
    mesh.corners.push_back({0, kInfiniteSharpness});
    return mesh;
}

}  // namespace

FanModel::FanModel(std::span<const float> sharpness, std::size_t own)
    : mesh_(fan_mesh(sharpness)), is_smooth_(std::ranges::all_of(sharpness, [](float s) { return s == 0; }))
{
    for (std::size_t q = 0; q < quads_.size(); ++q) {
        Quad& quad = quads_[q];
        quad.surface = mesh_.surface(static_cast<int>(own * 9 + q / 2 * 3 + q % 2));
        quad.count = static_cast<std::size_t>(quad.surface.GetNumControlPoints());
        std::vector<int> controls(quad.count);
        quad.surface.GetControlPointIndices(controls.data());
        for (std::size_t i = 0; i < quad.count; ++i)
            if (controls[i] == 0) quad.poles.push_back(i);
    }
}

std::size_t FanModel::bytes() const noexcept
{
    std::size_t bytes = sizeof *this + mesh_.bytes();
    for (const Quad& quad : quads_) bytes += bytes_of(quad.surface);
    return bytes;
}

std::array<double, 3> FanModel::weight(double x, double y) const
{
    if (x >= 2 || y >= 2) return {};
    const std::size_t i = x >= 1, j = y >= 1;
    const Quad& quad = quads_[2 * j + i];
    if (quad.poles.empty()) return {};
    std::vector<double> rows(3 * quad.count);
    const double uv[2] = {x - double(i), y - double(j)};
    quad.surface.EvaluateStencil(uv, rows.data(), rows.data() + quad.count, rows.data() + 2 * quad.count);
    std::array<double, 3> sum{};
    for (const std::size_t pole : quad.poles)
        for (std::size_t row = 0; row < 3; ++row) sum[row] += rows[row * quad.count + pole];
    return sum;
}

/// The quads around a large vertex, refined once. Vertex 0 is the large one; spokes and then sectors follow.
struct DerivedPoints::Star {
    std::unique_ptr<Far::TopologyRefiner> refiner;
    int pole = 0;
    std::vector<int> ends, corners;  ///< their vertices after refinement
    std::vector<float> sharpness;    ///< of the spokes and of the vertex, after refinement

    Star(std::size_t spokes, std::size_t sectors, const std::vector<float>& before)
    {
        Cage mesh;
        mesh.boundary = BoundaryRule::EdgeOnly;
        mesh.positions.resize(1 + spokes + sectors);
        const auto end = [&](std::size_t j) { return static_cast<std::uint32_t>(1 + j % spokes); };
        for (std::size_t j = 0; j < sectors; ++j)
            add_quad(mesh, {0, end(j), static_cast<std::uint32_t>(1 + spokes + j), end(j + 1)});
        for (std::size_t j = 0; j < spokes; ++j)
            if (before[j] > 0) mesh.creases.push_back({0, end(j), before[j]});
        if (before[spokes] > 0) mesh.corners.push_back({0, before[spokes]});
        refiner = make_refiner(mesh);
        refine_once(*refiner);
        const Far::TopologyLevel &coarse = refiner->GetLevel(0), &fine = refiner->GetLevel(1);
        pole = coarse.GetVertexChildVertex(0);
        for (std::size_t j = 0; j < spokes; ++j) {
            const int edge = coarse.FindEdge(0, static_cast<int>(end(j)));
            ends.push_back(coarse.GetEdgeChildVertex(edge));
            sharpness.push_back(fine.GetEdgeSharpness(fine.FindEdge(pole, ends.back())));
        }
        for (std::size_t j = 0; j < sectors; ++j) corners.push_back(coarse.GetFaceChildVertex(static_cast<int>(j)));
        sharpness.push_back(fine.GetVertexSharpness(pole));
    }

    std::size_t bytes() const noexcept
    {
        // What is kept of the refinement itself takes about as much as the finer level.
        const std::size_t lists = (ends.capacity() + corners.capacity() + sharpness.capacity()) * sizeof(int);
        return sizeof *this + lists + bytes_of(refiner->GetLevel(0)) + 2 * bytes_of(refiner->GetLevel(1));
    }
};

std::vector<Sector> sectors_after(const Far::TopologyLevel& level, Sector from, bool counter_clockwise, std::size_t most)
{
    std::vector<Sector> out;
    Sector at = from;
    while (out.size() < most) {
        const auto edges = level.GetFaceEdges(at.face);
        const int vertex = level.GetFaceVertices(at.face)[at.corner];
        // The edge to the next corner is the sector's clockwise spoke, and the edge from the corner before is the other one.
        const int spoke = edges[counter_clockwise ? (at.corner + edges.size() - 1) % edges.size() : at.corner];
        const auto faces = level.GetEdgeFaces(spoke);
        if (faces.size() != 2 || level.IsEdgeNonManifold(spoke)) break;
        at.face = faces[0] == at.face ? faces[1] : faces[0];
        if (at.face == from.face) break;
        const auto vertices = level.GetFaceVertices(at.face);
        at.corner = 0;
        while (vertices[at.corner] != vertex) ++at.corner;
        out.push_back(at);
    }
    return out;
}

namespace {

/// Returns at most how many vertices each corner of a face sees around it, without those of the face.
std::vector<std::size_t> vertices_around(const Far::TopologyLevel& level)
{
    std::vector<std::size_t> around(static_cast<std::size_t>(level.GetNumVertices()));
    for (int v = 0; v < level.GetNumVertices(); ++v)
        for (const int f : level.GetVertexFaces(v))
            around[static_cast<std::size_t>(v)] += static_cast<std::size_t>(level.GetFaceVertices(f).size() - 2);
    return around;
}

/// Returns for each face whether its patches take derived points.
std::vector<std::uint8_t> faces_to_derive(const Cage& cage, const Far::TopologyLevel& level)
{
    const bool is_smooth = cage.scheme == Scheme::CatmullClark;
    std::vector<std::uint8_t> takes(static_cast<std::size_t>(level.GetNumFaces()));
    std::vector<std::uint8_t> is_large(static_cast<std::size_t>(level.GetNumVertices()));
    for (int v = 0; v < level.GetNumVertices() && is_smooth; ++v)
        is_large[static_cast<std::size_t>(v)] = level.GetVertexFaces(v).size() >= int(kLargeFrom);
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        const auto vertices = level.GetFaceVertices(f);
        if (vertices.size() < int(kLargeFrom)) continue;
        takes[static_cast<std::size_t>(f)] = 1;
        for (int i = 0; i < vertices.size() && is_smooth; ++i) is_large[static_cast<std::size_t>(vertices[i])] = 1;
    }
    if (!is_smooth) return takes;
    const std::vector<std::size_t> around = vertices_around(level);
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        std::size_t controls = 0;
        for (const int v : level.GetFaceVertices(f)) {
            controls += around[static_cast<std::size_t>(v)];
            takes[static_cast<std::size_t>(f)] |= is_large[static_cast<std::size_t>(v)];
        }
        if (controls > kMostControls || is_unsafe(level, f, !cage.creases.empty())) takes[static_cast<std::size_t>(f)] = 1;
    }
    return takes;
}

}  // namespace

std::unique_ptr<const DerivedPoints> DerivedPoints::make(const Cage& cage, const Far::TopologyRefiner& refiner,
                                                         ClassMemory& memory)
{
    std::vector<std::uint8_t> faces = faces_to_derive(cage, refiner.GetLevel(0));
    if (std::ranges::none_of(faces, [](std::uint8_t takes) { return takes != 0; })) return nullptr;
    return std::unique_ptr<const DerivedPoints>(
        new DerivedPoints(cage.scheme == Scheme::CatmullClark, refiner, std::move(faces), memory));
}

DerivedPoints::DerivedPoints(bool is_smooth, const Far::TopologyRefiner& refiner, std::vector<std::uint8_t> faces,
                             ClassMemory& memory)
    : refiner_(Far::TopologyRefinerFactory<Far::TopologyDescriptor>::Create(refiner)),
      faces_(std::move(faces)),
      counted_(memory)
{
    refine_once(*refiner_);
    size_ = static_cast<std::uint32_t>(level().GetNumVertices());
    if (!is_smooth) return;
    Stars stars;
    for (int v = 0; v < level().GetNumVertices(); ++v) {
        if (!is_large(v) || level().IsVertexInfSharp(v)) continue;
        throw_if_cancelled();
        add_pole(v, stars);
    }
}

void DerivedPoints::add_pole(int vertex, Stars& stars)
{
    const Far::TopologyLevel& fine = level();
    const int face = fine.GetVertexFaces(vertex)[0];
    Sector first{face, 0};
    while (fine.GetFaceVertices(face)[first.corner] != vertex) ++first.corner;
    // At a border, the first sector is the last one clockwise. A vertex of several fans moves along the edges at their ends,
    // so any of them will do.
    const auto count = static_cast<std::size_t>(fine.GetVertexFaces(vertex).size());
    const std::vector<Sector> before = sectors_after(fine, first, false, count);
    const bool is_closed = !fine.IsVertexBoundary(vertex) && !fine.IsVertexNonManifold(vertex);
    if (!is_closed && !before.empty()) first = before.back();
    std::vector<Sector> sectors = sectors_after(fine, first, true, count);
    sectors.insert(sectors.begin(), first);

    Pole pole;
    pole.vertex = vertex;
    std::vector<float> sharpness;
    const auto add_spoke = [&](const Sector& s, int along) {
        pole.ends.push_back(fine.GetFaceVertices(s.face)[(s.corner + along) % 4]);
        sharpness.push_back(fine.GetEdgeSharpness(fine.GetFaceEdges(s.face)[along == 1 ? s.corner : (s.corner + 3) % 4]));
    };
    for (const Sector& s : sectors) {
        add_spoke(s, 1);
        pole.corners.push_back(fine.GetFaceVertices(s.face)[(s.corner + 2) % 4]);
    }
    if (!is_closed) add_spoke(sectors.back(), 3);
    sharpness.push_back(fine.GetVertexSharpness(vertex));
    if (fine.IsVertexNonManifold(vertex))  // creases of other fans keep it sharp as long as they are
        for (const int edge : fine.GetVertexEdges(vertex))
            if (const float s = fine.GetEdgeSharpness(edge); !Sdc::Crease::IsInfinite(s))
                sharpness.back() = std::max(sharpness.back(), s);
    for (int k = 0; k < kMoves; ++k) {
        throw_if_cancelled();
        std::shared_ptr<const Star>& star = stars[{pole.corners.size(), sharpness}];
        if (!star) {
            counted_.check_room();
            star = std::make_shared<const Star>(pole.ends.size(), pole.corners.size(), sharpness);
            counted_.add(star->bytes());
        }
        pole.stars.push_back(star);
        sharpness = star->sharpness;
    }
    first_move_[vertex] = size_;
    size_ += kMoves;
    poles_.push_back(std::move(pole));
}

std::uint32_t DerivedPoints::first_move(int vertex) const noexcept
{
    const auto found = first_move_.find(vertex);
    return found == first_move_.end() ? kNone : found->second;
}

void DerivedPoints::compute(std::span<const Vec3f> vertices, std::span<Vec3f> out) const
{
    std::vector<RefinedPoint> coarse(vertices.size()), fine(static_cast<std::size_t>(level().GetNumVertices()));
    for (std::size_t v = 0; v < vertices.size(); ++v) coarse[v].p = Vec3d(vertices[v]);
    Far::PrimvarRefiner(*refiner_).Interpolate(1, coarse, fine);
    for (std::size_t v = 0; v < fine.size(); ++v) out[v] = Vec3f(fine[v].p);
    std::vector<RefinedPoint> ring, finer;
    for (const Pole& pole : poles_) {
        throw_if_cancelled();
        ring.assign(1, fine[static_cast<std::size_t>(pole.vertex)]);
        for (const int v : pole.ends) ring.push_back(fine[static_cast<std::size_t>(v)]);
        for (const int v : pole.corners) ring.push_back(fine[static_cast<std::size_t>(v)]);
        const std::uint32_t first = first_move(pole.vertex);
        for (std::size_t k = 0; k < pole.stars.size(); ++k) {
            const Star& star = *pole.stars[k];
            finer.assign(static_cast<std::size_t>(star.refiner->GetLevel(1).GetNumVertices()), RefinedPoint());
            Far::PrimvarRefiner(*star.refiner).Interpolate(1, ring, finer);
            const RefinedPoint moved = finer[static_cast<std::size_t>(star.pole)];
            out[first + k] = Vec3f(moved.p - ring[0].p);
            std::size_t n = 0;
            ring[n++] = moved;
            for (const int v : star.ends) ring[n++] = finer[static_cast<std::size_t>(v)];
            for (const int v : star.corners) ring[n++] = finer[static_cast<std::size_t>(v)];
        }
    }
}

std::shared_ptr<const FanModel> DerivedPoints::fan(std::span<const float> sharpness, std::size_t own, int step) const
{
    std::vector<float> at_step;
    for (const float s : sharpness) at_step.push_back(sharpness_after(s, step));
    const std::lock_guard lock(mutex_);
    std::weak_ptr<const FanModel>& known = fans_[{at_step, own}];
    if (std::shared_ptr<const FanModel> model = known.lock()) return model;
    const auto model = std::make_shared<const FanModel>(at_step, own);
    known = model;
    if (model->is_smooth()) smooth_fans_.push_back(model);
    if (fans_.size() >= most_fans_) {
        std::erase_if(fans_, [](const auto& entry) { return entry.second.expired(); });
        most_fans_ = std::max(most_fans_, 2 * fans_.size());
    }
    return model;
}

}  // namespace occam::lod
