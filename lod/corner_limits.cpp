#include "lod/corner_limits.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/sdc/crease.h>

#include <algorithm>

#include "lod/small_surface.h"

namespace occam::lod {
namespace {

using namespace OpenSubdiv;

/// The number of steps towards a corner. Within 2^-kSteps of it, points are found there.
constexpr int kSteps = 9;

/// Where creases are sharper than this, too few of Bfr's ten divisions are left once they are smooth.
constexpr float kLeastSharp = 4;

/// The weights of a vertex: those of the vertices from which it was refined.
struct Weights {
    std::vector<double> of;
    void Clear(void* = nullptr) { std::ranges::fill(of, 0); }
    void AddWithWeight(const Weights& other, double weight)
    {
        of.resize(other.of.size());
        for (std::size_t k = 0; k < of.size(); ++k) of[k] += other.of[k] * weight;
    }
};

/// A part of a refined mesh, and the weights of its vertices.
struct WeightedPart {
    Cage mesh;
    std::vector<Weights> weights;
};

/// Returns what surrounds the quad at a corner of the first face after one step, from that corner on.
WeightedPart refined_at(const WeightedPart& coarse, int corner)
{
    const auto refiner = make_refiner(coarse.mesh);
    Far::TopologyRefiner::UniformOptions once(1);
    once.fullTopologyInLastLevel = true;
    refiner->RefineUniform(once);
    const Far::TopologyLevel &base = refiner->GetLevel(0), &level = refiner->GetLevel(1);
    std::vector<Weights> all(static_cast<std::size_t>(level.GetNumVertices()));
    Far::PrimvarRefinerReal<double>(*refiner).Interpolate(1, coarse.weights, all);

    const int vertex = base.GetVertexChildVertex(base.GetFaceVertices(0)[corner]);
    // The children of a face are in the order of its corners.
    Sector quad{base.GetFaceChildFaces(0)[corner], 0};
    while (level.GetFaceVertices(quad.face)[quad.corner] != vertex) ++quad.corner;
    MeshPart part(level, coarse.mesh.boundary);
    part.add_with_neighbours(quad);
    part.add_sharpness();
    WeightedPart fine{std::move(part.mesh), {}};
    for (const int v : part.vertices) fine.weights.push_back(std::move(all[static_cast<std::size_t>(v)]));
    return fine;
}

/// What Bfr does at a corner and beside it.
struct Approximates {
    bool at = false, beside = false;
};

Approximates approximates(const Far::TopologyLevel& level, int vertex)
{
    if (level.IsVertexNonManifold(vertex) || Sdc::Crease::IsInfinite(level.GetVertexSharpness(vertex))) return {};
    const bool is_boundary = level.IsVertexBoundary(vertex);
    const int faces = level.GetVertexFaces(vertex).size();
    if (faces < 3 && !is_boundary) return {};
    int sharp = 0, infinite = 0;
    float sharpest = level.GetVertexSharpness(vertex);  // of what is not infinitely sharp
    for (const int edge : level.GetVertexEdges(vertex)) {
        const float sharpness = level.GetEdgeSharpness(edge);
        sharp += sharpness > 0;
        infinite += Sdc::Crease::IsInfinite(sharpness);
        if (!Sdc::Crease::IsInfinite(sharpness)) sharpest = std::max(sharpest, sharpness);
    }
    const bool is_regular = sharp == (is_boundary ? 2 : 0) && !(level.GetVertexSharpness(vertex) > 0) &&
                            faces == (is_boundary ? 2 : 4);
    return {!is_boundary && (infinite == 1 || sharpest > kLeastSharp), !is_regular};
}

}  // namespace

/// The quad at a corner after all steps, as sums of the vertices around the whole quad.
class CornerLimits::Refined {
public:
    explicit Refined(const WeightedPart& part)
        : mesh_(part.mesh), surface_(mesh_.surface(0)), count_(part.weights.front().of.size())
    {
        std::vector<int> controls(static_cast<std::size_t>(surface_.GetNumControlPoints()));
        surface_.GetControlPointIndices(controls.data());
        for (const int control : controls) weights_.push_back(part.weights[static_cast<std::size_t>(control)].of);
    }

    /// Evaluates at parameters of the whole quad, counted from the corner.
    void evaluate(int corner, double x, double y, LimitSource::Of of, LimitStencil& out) const
    {
        constexpr double kScale = 1 << kSteps;
        const double uv[2] = {x * kScale, y * kScale};
        const std::size_t n = weights_.size();
        std::vector<double> rows(3 * n);
        const bool has_tangents = of == LimitSource::Of::PointAndTangents;
        if (has_tangents) surface_.EvaluateStencil(uv, rows.data(), rows.data() + n, rows.data() + 2 * n);
        else surface_.EvaluateStencil(uv, rows.data());
        out.p.assign(count_, 0);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t k = 0; k < count_; ++k) out.p[k] += rows[i] * weights_[i][k];
        if (!has_tangents) return;
        out.du.assign(count_, 0);
        out.dv.assign(count_, 0);
        for (std::size_t i = 0; i < n; ++i) {
            const auto d = derivatives_in_quad(corner, rows[n + i] * kScale, rows[2 * n + i] * kScale);
            for (std::size_t k = 0; k < count_; ++k) {
                out.du[k] += d[0] * weights_[i][k];
                out.dv[k] += d[1] * weights_[i][k];
            }
        }
    }

private:
    SmallSurface mesh_;
    Bfr::Surface<double> surface_;
    std::size_t count_;
    std::vector<std::vector<double>> weights_;
};

CornerLimits::CornerLimits(const Far::TopologyLevel& level, const Sector& quad, BoundaryRule boundary)
    : part_(level, boundary), is_whole_(level.GetFaceVertices(quad.face).size() == 4)
{
    part_.add_with_neighbours(quad);
    part_.add_sharpness();
    const auto vertices = level.GetFaceVertices(quad.face);
    const auto set = [&](int corner, const Approximates& does) {
        at_[static_cast<std::size_t>(corner)] = does.at;
        beside_[static_cast<std::size_t>(corner)] = does.beside;
    };
    set(0, approximates(level, vertices[quad.corner]));
    if (is_whole_) {
        for (int corner = 1; corner < 4; ++corner) set(corner, approximates(level, vertices[(quad.corner + corner) % 4]));
        return;
    }
    set(2, {false, true});
}

CornerLimits::~CornerLimits() = default;

std::shared_ptr<const CornerLimits::Refined> CornerLimits::refined(int corner) const
{
    const std::lock_guard lock(mutex_);
    if (last_corner_ == corner) return last_;
    WeightedPart part{part_.mesh, std::vector<Weights>(part_.vertices.size())};
    for (std::size_t v = 0; v < part.weights.size(); ++v) {
        part.weights[v].of.resize(part.weights.size());
        part.weights[v].of[v] = 1;
    }
    if (!is_whole_) part = refined_at(part, 0);
    for (int step = 0; step < kSteps; ++step) part = refined_at(part, step == 0 ? corner : 0);
    last_ = std::make_shared<const Refined>(part);
    last_corner_ = corner;
    return last_;
}

bool CornerLimits::evaluate(double u, double v, LimitSource::Of of, LimitStencil& out) const
{
    for (int corner = 0; corner < 4; ++corner) {
        const auto [x, y] = from_corner(corner, u, v);
        constexpr double kNear = 1.0 / (1 << kSteps);
        if (x >= kNear || y >= kNear) continue;
        const auto c = static_cast<std::size_t>(corner);
        if (!(x == 0 && y == 0 ? at_[c] : beside_[c])) return false;
        refined(corner)->evaluate(corner, x, y, of, out);
        return true;
    }
    return false;
}

}  // namespace occam::lod
