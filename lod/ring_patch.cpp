#include "lod/ring_patch.h"

#include <opensubdiv/sdc/crease.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <unordered_map>

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
    const Far::TopologyLevel& base = points.base();
    const int face = static_cast<int>(patch.face);
    const auto vertices = base.GetFaceVertices(face);
    const auto children = base.GetFaceChildFaces(face);
    std::vector<Sector> quads;
    const auto add = [&](int corner) {
        const int vertex = base.GetVertexChildVertex(vertices[corner]);
        // The children of a face are in the order of its corners.
        const auto of_child = points.level().GetFaceVertices(children[corner]);
        Sector quad{children[corner], 0};
        while (of_child[quad.corner] != vertex) ++quad.corner;
        quads.push_back(quad);
    };
    if (vertices.size() != 4) add(static_cast<int>(patch.sub));
    else
        for (int corner = 0; corner < 4; ++corner) add(corner);
    return quads;
}

class RingBuilder {
public:
    RingBuilder(const DerivedPoints& points, BoundaryRule boundary) : points_(points), level_(points.level())
    {
        // Where the rule leaves out faces at borders, those that are left touch none, but cutting makes some.
        out.mesh.boundary = boundary == BoundaryRule::None ? BoundaryRule::EdgeAndCorner : boundary;
    }

    void add(const std::vector<Sector>& quads)
    {
        for (const Sector& quad : quads) add_face(quad);
        out.quads.resize(quads.size());
        for (std::size_t q = 0; q < quads.size(); ++q)
            for (int corner = 0; corner < 4; ++corner) add_around(quads[q], corner, out.quads[q]);
        add_sharpness();
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
    std::uint32_t number_of(int vertex)
    {
        const auto [at, is_new] = numbers_.emplace(vertex, static_cast<std::uint32_t>(out.controls.size()));
        if (is_new) {
            out.controls.push_back(static_cast<std::uint32_t>(vertex));
            out.mesh.positions.emplace_back(0);
        }
        return at->second;
    }

    void add_face(const Sector& sector)
    {
        if (!faces_.insert(sector.face).second) return;
        const auto vertices = level_.GetFaceVertices(sector.face);
        out.mesh.face_sizes.push_back(4);
        for (int i = 0; i < 4; ++i) out.mesh.face_vertices.push_back(number_of(vertices[(sector.corner + i) % 4]));
        for (const int edge : level_.GetFaceEdges(sector.face)) edges_.push_back(edge);
    }

    /// Adds the quads around a corner of a quad; around a large vertex some of them, and its moves.
    void add_around(const Sector& quad, int corner, RingPatch::Quad& to)
    {
        const Sector own{quad.face, (quad.corner + corner) % 4};
        const int vertex = level_.GetFaceVertices(own.face)[own.corner];
        const bool is_large = points_.is_large(vertex);
        const std::size_t most = is_large ? kSectors : static_cast<std::size_t>(level_.GetVertexFaces(vertex).size());
        const std::vector<Sector> after = sectors_after(level_, own, true, most),
                                  before = sectors_after(level_, own, false, most);
        for (const Sector& sector : after) add_face(sector);
        for (const Sector& sector : before) add_face(sector);
        if (!is_large) {
            // What is left around a vertex that is not manifold.
            const auto faces = level_.GetVertexFaces(vertex);
            const auto places = level_.GetVertexFaceLocalIndices(vertex);
            for (int f = 0; f < faces.size(); ++f) add_face({faces[f], places[f]});
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

    void add_sharpness()
    {
        const auto deepen = [&](float sharpness) {
            if (sharpness > 0 && !Sdc::Crease::IsInfinite(sharpness))
                out.crease_depth = std::max(out.crease_depth, static_cast<int>(std::ceil(sharpness)) + 1);
        };
        std::set<int> known;
        for (const int edge : edges_) {
            const float sharpness = level_.GetEdgeSharpness(edge);
            if (!(sharpness > 0) || level_.IsEdgeBoundary(edge) || !known.insert(edge).second) continue;
            const auto ends = level_.GetEdgeVertices(edge);
            out.mesh.creases.push_back({number_of(ends[0]), number_of(ends[1]), sharpness});
            if (out.mesh.creases.back().v0 > out.mesh.creases.back().v1)
                std::swap(out.mesh.creases.back().v0, out.mesh.creases.back().v1);
            deepen(sharpness);
        }
        for (std::uint32_t v = 0; v < out.mesh.positions.size(); ++v) {
            const int vertex = static_cast<int>(out.controls[v]);
            const float sharpness = points_.is_large(vertex) ? kInfiniteSharpness : level_.GetVertexSharpness(vertex);
            if (sharpness > 0) out.mesh.corners.push_back({v, sharpness});
            deepen(sharpness);
        }
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
    std::unordered_map<int, std::uint32_t> numbers_;
    std::set<int> faces_;
    std::vector<int> edges_;
};

class RingSource : public LimitSource {
public:
    RingSource(const DerivedPoints& points, const RingPatch& patch) : count_(patch.controls.size()), mesh_(patch.mesh)
    {
        for (std::size_t q = 0; q < patch.quads.size(); ++q) {
            Quad& quad = quads_.emplace_back();
            quad.surface = mesh_.surface(static_cast<int>(q));
            std::vector<int> own(static_cast<std::size_t>(quad.surface.GetNumControlPoints()));
            quad.surface.GetControlPointIndices(own.data());
            quad.number.assign(own.begin(), own.end());
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
            bytes += sizeof quad + bytes_of(quad.surface);
            for (const Pole& pole : quad.poles)
                for (const auto& fan : pole.fans) bytes += sizeof fan + (fan->is_smooth() ? 0 : fan->bytes());
        }
        return bytes;
    }

    void evaluate(double u, double v, LimitStencil& out) const override
    {
        out.p.assign(count_, 0);
        out.du.assign(count_, 0);
        out.dv.assign(count_, 0);
        if (quads_.size() == 1) return evaluate_quad(quads_.front(), {u, v, {1, 0}, {0, 1}}, out);
        const bool right = u >= 0.5, top = v >= 0.5;
        if (!right && !top) return evaluate_quad(quads_[0], {2 * u, 2 * v, {2, 0}, {0, 2}}, out);
        if (!top) return evaluate_quad(quads_[1], {2 * v, 2 * (1 - u), {0, -2}, {2, 0}}, out);
        if (right) return evaluate_quad(quads_[2], {2 * (1 - u), 2 * (1 - v), {-2, 0}, {0, -2}}, out);
        evaluate_quad(quads_[3], {2 * (1 - v), 2 * u, {0, 2}, {-2, 0}}, out);
    }

private:
    struct Pole {
        int corner;
        std::uint32_t first_move;
        std::vector<std::shared_ptr<const FanModel>> fans;
    };
    struct Quad {
        Bfr::Surface<double> surface;
        std::vector<std::size_t> number;
        std::vector<Pole> poles;
    };
    /// Parameters in a quad, and the derivatives of both with respect to the patch's u and v.
    struct Place {
        double s, t;
        double by_u[2], by_v[2];
    };

    /// Returns parameters counted from a corner: along the edge to the next corner, and along the one from the corner
    /// before.
    static std::array<double, 2> from_corner(int corner, double s, double t) noexcept
    {
        switch (corner) {
            case 0:
                return {s, t};
            case 1:
                return {t, 1 - s};
            case 2:
                return {1 - s, 1 - t};
            default:
                return {1 - t, s};
        }
    }
    /// Does the inverse of from_corner().
    static std::array<double, 2> to_quad(int corner, double x, double y) noexcept
    {
        return from_corner((4 - corner) % 4, x, y);
    }

    /// Adds the weights at (s, t) to out: those of the point, or those of both derivatives.
    void add_weights(const Quad& quad, double s, double t, bool is_point, const Place& place, LimitStencil& out) const
    {
        const auto add = [&](std::size_t control, double p, double ds, double dt) {
            if (is_point) {
                out.p[control] += p;
                return;
            }
            out.du[control] += ds * place.by_u[0] + dt * place.by_u[1];
            out.dv[control] += ds * place.by_v[0] + dt * place.by_v[1];
        };
        const std::size_t n = quad.number.size();
        std::vector<double> rows(3 * n);
        const double uv[2] = {s, t};
        quad.surface.EvaluateStencil(uv, rows.data(), rows.data() + n, rows.data() + 2 * n);
        for (std::size_t i = 0; i < n; ++i) add(quad.number[i], rows[i], rows[n + i], rows[2 * n + i]);
        for (const Pole& pole : quad.poles) {
            const auto [x, y] = from_corner(pole.corner, s, t);
            double scale = 2;
            for (std::size_t k = 0; k < pole.fans.size() && std::max(x, y) * scale < 2; ++k, scale *= 2) {
                const std::array<double, 3> w = pole.fans[k]->weight(x * scale, y * scale);
                // The derivatives turn with the corner.
                const auto d = from_corner((4 - pole.corner) % 4, w[1] * scale, w[2] * scale);
                const auto none = from_corner((4 - pole.corner) % 4, 0, 0);
                add(pole.first_move + k, w[0], d[0] - none[0], d[1] - none[1]);
            }
        }
    }

    void evaluate_quad(const Quad& quad, const Place& place, LimitStencil& out) const
    {
        add_weights(quad, place.s, place.t, true, place, out);
        double s = place.s, t = place.t;
        for (const Pole& pole : quad.poles) {
            const auto [x, y] = from_corner(pole.corner, s, t);
            if (std::max(x, y) >= kNearest) continue;
            const auto beside = to_quad(pole.corner, std::max(x, kNearest), std::max(y, kNearest));
            s = beside[0];
            t = beside[1];
        }
        add_weights(quad, s, t, false, place, out);
    }

    std::size_t count_;
    SmallSurface mesh_;
    std::vector<Quad> quads_;
};

class BilinearSource : public LimitSource {
public:
    std::size_t bytes() const noexcept override { return sizeof *this; }
    void evaluate(double u, double v, LimitStencil& out) const override
    {
        out.p = {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v};
        out.du = {v - 1, 1 - v, v, -v};
        out.dv = {u - 1, -u, u, 1 - u};
    }
};

}  // namespace

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
