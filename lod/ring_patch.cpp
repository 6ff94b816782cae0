#include "lod/ring_patch.h"

#include <opensubdiv/sdc/crease.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "lod/bfr_source.h"
#include "lod/corner_limits.h"

namespace occam::lod {
namespace {

using namespace OpenSubdiv;

/// The number of sectors that are kept on either side of a quad: Bfr refines ten times, and needs one more on either side.
constexpr std::size_t kSectors = 12;
/// Nearer to a large vertex, tangents are those at this distance: at the vertex itself they have no limit of finite length.
constexpr double kNearest = 0x1p-12;

/// Returns the quads of a patch after refinement, and the corner of each that is the patch's or the face's own.
std::vector<Sector> quads_of(const DerivedPoints& points, PatchRef patch)
{
    const int face = static_cast<int>(patch.face);
    std::vector<Sector> quads;
    const auto add = [&](int corner) { quads.push_back(child_at(points.base(), points.level(), {face, corner})); };
    if (points.base().GetFaceVertices(face).size() != 4) add(static_cast<int>(patch.sub));
    else
        for (int corner = 0; corner < 4; ++corner) add(corner);
    return quads;
}

class RingBuilder {
public:
    RingBuilder(const DerivedPoints& points, BoundaryRule boundary)
        : points_(points), level_(points.level()), part_(level_, boundary)
    {
    }

    void add(const std::vector<Sector>& quads)
    {
        for (const Sector& quad : quads) part_.add(quad);
        out.quads.resize(quads.size());
        for (std::size_t q = 0; q < quads.size(); ++q)
            for (int corner = 0; corner < 4; ++corner) add_around(quads[q], corner, out.quads[q]);
        part_.add_sharpness();
        out.controls.assign(part_.vertices.begin(), part_.vertices.end());
        out.mesh = std::move(part_.mesh);
        hold_large_vertices();
        find_crease_depth();
        for (RingPatch::Quad& quad : out.quads)
            for (RingPatch::Pole& pole : quad.poles) {
                const std::uint32_t first = pole.first_move;
                pole.first_move = static_cast<std::uint32_t>(out.controls.size());
                for (std::uint32_t k = 0; k < DerivedPoints::kMoves; ++k) out.controls.push_back(first + k);
            }
        make_key();
    }

    RingPatch out;

private:
    /// Adds the quads around a corner of a quad; around a large vertex some of them, and its moves.
    void add_around(const Sector& quad, int corner, RingPatch::Quad& to)
    {
        const Sector own{quad.face, (quad.corner + corner) % 4};
        const int vertex = level_.GetFaceVertices(own.face)[own.corner];
        const bool is_large = points_.is_large(vertex);
        const std::size_t most = is_large ? kSectors : static_cast<std::size_t>(level_.GetVertexFaces(vertex).size());
        const std::vector<Sector> after = sectors_after(level_, own, true, most),
                                  before = sectors_after(level_, own, false, most);
        for (const Sector& sector : after) part_.add(sector);
        for (const Sector& sector : before) part_.add(sector);
        if (!is_large) {
            part_.add_around(vertex);  // adds what is left if the vertex is not manifold
            return;
        }
        const std::uint32_t first = points_.first_move(vertex);
        if (first == DerivedPoints::kNone) return;
        RingPatch::Pole& pole = to.poles.emplace_back();
        pole.corner = corner;
        pole.first_move = first;
        pole.own = before.size();
        const auto spoke = [&](const Sector& s, int place) {
            pole.sharpness.push_back(level_.GetEdgeSharpness(level_.GetFaceEdges(s.face)[(s.corner + place) % 4]));
        };
        for (auto s = before.rbegin(); s != before.rend(); ++s) spoke(*s, 0);
        spoke(own, 0);
        for (const Sector& s : after) spoke(s, 0);
        spoke(after.empty() ? own : after.back(), 3);
    }

    void hold_large_vertices()
    {
        std::erase_if(out.mesh.corners, [&](const Corner& c) { return is_large(c.vertex); });
        for (std::uint32_t v = 0; v < out.mesh.positions.size(); ++v)
            if (is_large(v)) out.mesh.corners.push_back({v, kInfiniteSharpness});
        std::ranges::sort(out.mesh.corners, {}, &Corner::vertex);
    }
    bool is_large(std::uint32_t vertex) const { return points_.is_large(static_cast<int>(out.controls[vertex])); }
    void find_crease_depth()
    {
        const auto deepen = [&](float sharpness) {
            if (!Sdc::Crease::IsInfinite(sharpness))
                out.crease_depth = std::max(out.crease_depth, static_cast<int>(std::ceil(sharpness)) + 1);
        };
        for (const Crease& c : out.mesh.creases) deepen(c.sharpness);
        for (const Corner& c : out.mesh.corners) deepen(c.sharpness);
    }

    void make_key()
    {
        std::vector<std::uint32_t>& key = out.key;
        // No key of a patch with control points of its own begins like this.
        key = {~0u, static_cast<std::uint32_t>(out.quads.size()), static_cast<std::uint32_t>(out.mesh.creases.size()),
               static_cast<std::uint32_t>(out.mesh.corners.size())};
        for (const Crease& c : out.mesh.creases)
            key.insert(key.end(), {c.v0, c.v1, std::bit_cast<std::uint32_t>(c.sharpness)});
        for (const Corner& c : out.mesh.corners)
            key.insert(key.end(), {c.vertex, std::bit_cast<std::uint32_t>(c.sharpness)});
        for (const RingPatch::Quad& quad : out.quads) {
            key.push_back(static_cast<std::uint32_t>(quad.poles.size()));
            for (const RingPatch::Pole& pole : quad.poles) {
                key.insert(key.end(), {static_cast<std::uint32_t>(pole.corner), static_cast<std::uint32_t>(pole.own),
                                       static_cast<std::uint32_t>(pole.sharpness.size())});
                for (const float s : pole.sharpness) key.push_back(std::bit_cast<std::uint32_t>(s));
            }
        }
        key.insert(key.end(), out.mesh.face_vertices.begin(), out.mesh.face_vertices.end());
    }

    const DerivedPoints& points_;
    const Far::TopologyLevel& level_;
    MeshPart part_;
};

class RingSource : public LimitSource {
public:
    RingSource(const DerivedPoints& points, const RingPatch& patch) : count_(patch.controls.size()), mesh_(patch.mesh)
    {
        for (std::size_t q = 0; q < patch.quads.size(); ++q) {
            Quad& quad = quads_.emplace_back();
            quad.surface = mesh_.surface(static_cast<int>(q));
            quad.vertices.resize(static_cast<std::size_t>(quad.surface.GetNumControlPoints()));
            quad.surface.GetControlPointIndices(quad.vertices.data());
            if (!quad.surface.IsRegular())
                quad.corners = std::make_unique<const CornerLimits>(mesh_.level(), Sector{static_cast<int>(q), 0},
                                                                    MeshRules{patch.mesh.boundary});
            for (const RingPatch::Pole& pole : patch.quads[q].poles) {
                Pole& made = quad.poles.emplace_back(Pole{pole.corner, pole.first_move, {}});
                for (int k = 0; k < DerivedPoints::kMoves; ++k)
                    made.fans.push_back(points.fan(pole.sharpness, pole.own, k + 1));
            }
        }
    }

    std::size_t bytes() const noexcept override
    {
        std::size_t bytes = sizeof *this + mesh_.bytes();
        for (const Quad& quad : quads_) {
            bytes += sizeof quad + 2 * bytes_of(quad.surface);  // the surface at a corner takes as much again
            for (const Pole& pole : quad.poles)
                for (const auto& fan : pole.fans) bytes += sizeof fan + (fan->is_smooth() ? 0 : fan->bytes());
        }
        return bytes;
    }

    void evaluate(double u, double v, Of of, LimitStencil& out) const override
    {
        out.p.assign(count_, 0);
        const bool right = u >= 0.5, top = v >= 0.5;
        const std::size_t q = quads_.size() == 1 ? 0 : top ? (right ? 2 : 3) : (right ? 1 : 0);
        const Place place = quads_.size() == 1 ? Place{u, v, {1, 0}, {0, 1}}
                            : q == 0           ? Place{2 * u, 2 * v, {2, 0}, {0, 2}}
                            : q == 1           ? Place{2 * v, 2 * (1 - u), {0, -2}, {2, 0}}
                            : q == 2           ? Place{2 * (1 - u), 2 * (1 - v), {-2, 0}, {0, -2}}
                                               : Place{2 * (1 - v), 2 * u, {0, 2}, {-2, 0}};
        add_points(quads_[q], place.s, place.t, out);
        if (of == Of::Point) return;
        out.du.assign(count_, 0);
        out.dv.assign(count_, 0);
        add_tangents(quads_[q], place, out);
    }

private:
    struct Pole {
        int corner;
        std::uint32_t first_move;
        std::vector<std::shared_ptr<const FanModel>> fans;
    };
    struct Quad {
        Bfr::Surface<double> surface;
        std::vector<int> vertices;                    ///< of the mesh: its control points
        std::unique_ptr<const CornerLimits> corners;  ///< null for a regular quad
        std::vector<Pole> poles;
    };
    /// Parameters in a quad, and the derivatives of both with respect to the patch's u and v.
    struct Place {
        double s, t;
        double by_u[2], by_v[2];
    };

    /// Evaluates a quad without moves, and returns the vertices of the mesh that the weights belong to.
    static std::span<const int> evaluate_at_rest(const Quad& quad, double s, double t, Of of, LimitStencil& out)
    {
        if (quad.corners && quad.corners->evaluate(s, t, of, out)) return quad.corners->controls();
        lod::evaluate(quad.surface, s, t, of, out);
        return quad.vertices;
    }
    /// Calls add(control, w, scale, corner) for each move that changes the surface at (s, t): w are the weights of the point
    /// and of its derivatives by parameters that are counted from the corner, in steps of 1 / scale.
    static void for_each_move(const Quad& quad, double s, double t, auto&& add)
    {
        for (const Pole& pole : quad.poles) {
            const auto [x, y] = from_corner(pole.corner, s, t);
            double scale = 2;
            for (std::size_t k = 0; k < pole.fans.size() && std::max(x, y) * scale < 2; ++k, scale *= 2)
                add(pole.first_move + k, pole.fans[k]->weight(x * scale, y * scale), scale, pole.corner);
        }
    }
    void add_points(const Quad& quad, double s, double t, LimitStencil& out) const
    {
        LimitStencil own;
        const std::span<const int> vertices = evaluate_at_rest(quad, s, t, Of::Point, own);
        for (std::size_t i = 0; i < vertices.size(); ++i) out.p[static_cast<std::size_t>(vertices[i])] += own.p[i];
        for_each_move(quad, s, t, [&](std::size_t control, const auto& w, double, int) { out.p[control] += w[0]; });
    }
    void add_tangents(const Quad& quad, const Place& place, LimitStencil& out) const
    {
        double s = place.s, t = place.t;
        for (const Pole& pole : quad.poles) {
            const auto [x, y] = from_corner(pole.corner, s, t);
            if (std::max(x, y) >= kNearest) continue;
            const auto beside = to_quad(pole.corner, std::max(x, kNearest), std::max(y, kNearest));
            s = beside[0];
            t = beside[1];
        }
        const auto add = [&](std::size_t control, double ds, double dt) {
            out.du[control] += ds * place.by_u[0] + dt * place.by_u[1];
            out.dv[control] += ds * place.by_v[0] + dt * place.by_v[1];
        };
        LimitStencil own;
        const std::span<const int> vertices = evaluate_at_rest(quad, s, t, Of::PointAndTangents, own);
        for (std::size_t i = 0; i < vertices.size(); ++i) add(static_cast<std::size_t>(vertices[i]), own.du[i], own.dv[i]);
        for_each_move(quad, s, t, [&](std::size_t control, const auto& w, double scale, int corner) {
            const auto d = derivatives_in_quad(corner, w[1] * scale, w[2] * scale);
            add(control, d[0], d[1]);
        });
    }

    std::size_t count_;
    SmallSurface mesh_;
    std::vector<Quad> quads_;
};

class BilinearSource : public LimitSource {
public:
    std::size_t bytes() const noexcept override { return sizeof *this; }
    void evaluate(double u, double v, Of, LimitStencil& out) const override
    {
        out.p = {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v};
        out.du = {v - 1, 1 - v, v, -v};
        out.dv = {u - 1, -u, u, 1 - u};
    }
};

}  // namespace

std::uint32_t RingPatch::move_count() const noexcept
{
    std::size_t poles = 0;
    for (const Quad& quad : quads) poles += quad.poles.size();
    return static_cast<std::uint32_t>(poles) * DerivedPoints::kMoves;
}

std::size_t RingPatch::bytes() const noexcept
{
    std::size_t bytes = sizeof *this + controls.capacity() * sizeof(controls[0]) + quads.capacity() * sizeof(quads[0]);
    bytes += mesh.positions.capacity() * sizeof(Vec3f) +
             (mesh.face_sizes.capacity() + mesh.face_vertices.capacity()) * sizeof(std::uint32_t) +
             mesh.creases.capacity() * sizeof(Crease) + mesh.corners.capacity() * sizeof(Corner);
    for (const Quad& quad : quads)
        for (const Pole& pole : quad.poles) bytes += sizeof pole + pole.sharpness.capacity() * sizeof(float);
    return bytes;
}

RingPatch ring_patch(const DerivedPoints& points, PatchRef patch, BoundaryRule boundary)
{
    RingBuilder builder(points, boundary);
    builder.add(quads_of(points, patch));
    return std::move(builder.out);
}

std::unique_ptr<const LimitSource> limit_source(const DerivedPoints& points, const RingPatch& patch)
{
    return std::make_unique<RingSource>(points, patch);
}

std::vector<std::uint32_t> corner_points(const DerivedPoints& points, PatchRef patch)
{
    const Sector quad = quads_of(points, patch).front();
    const auto vertices = points.level().GetFaceVertices(quad.face);
    std::vector<std::uint32_t> corners;
    for (int i = 0; i < 4; ++i) corners.push_back(static_cast<std::uint32_t>(vertices[(quad.corner + i) % 4]));
    return corners;
}

std::unique_ptr<const LimitSource> bilinear_source() { return std::make_unique<BilinearSource>(); }

}  // namespace occam::lod
