#include "lod/corner_limits.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/sdc/crease.h>

#include <algorithm>

#include "lod/bfr_source.h"
#include "lod/derived_points.h"
#include "lod/small_surface.h"

namespace occam::lod {
namespace {

using namespace OpenSubdiv;

/// The number of steps towards a corner. Within 2^-kSteps of it, points are found there.
constexpr int kSteps = 9;

/// Where creases are sharper than this, too few of Bfr's ten divisions are left once they are smooth.
constexpr float kLeastSharp = 4;

/// The weights of a vertex, or of a value of texture coordinates: those of the ones from which it was refined.
struct Weights {
    std::vector<double> of;
    void Clear(void* = nullptr) { std::ranges::fill(of, 0); }
    void AddWithWeight(const Weights& other, double weight)
    {
        of.resize(other.of.size());
        for (std::size_t k = 0; k < of.size(); ++k) of[k] += other.of[k] * weight;
    }
};

/// A part of a refined mesh, and the weights of its vertices; if it has texture coordinates, those of their values.
struct WeightedPart {
    Cage mesh;
    std::vector<Weights> weights;

    bool has_uv() const noexcept { return !mesh.uv_sets.empty(); }
};

/// Returns what surrounds the quad at a corner of the first face after one step, from that corner on.
WeightedPart refined_at(const WeightedPart& coarse, int corner)
{
    const auto refiner = make_refiner(coarse.mesh);
    refine_once(*refiner);
    const Far::TopologyLevel& level = refiner->GetLevel(1);
    std::vector<Weights> all(static_cast<std::size_t>(coarse.has_uv() ? level.GetNumFVarValues(0) : level.GetNumVertices()));
    const Far::PrimvarRefinerReal<double> refine(*refiner);
    if (coarse.has_uv()) refine.InterpolateFaceVarying(1, coarse.weights, all);
    else refine.Interpolate(1, coarse.weights, all);

    MeshPart part(level, {coarse.mesh.boundary, coarse.mesh.face_varying}, coarse.has_uv() ? 0 : -1);
    part.add_with_neighbours(child_at(refiner->GetLevel(0), level, {0, corner}));
    part.add_sharpness();
    WeightedPart fine{std::move(part.mesh), {}};
    for (const int at : coarse.has_uv() ? part.values : part.vertices)
        fine.weights.push_back(std::move(all[static_cast<std::size_t>(at)]));
    return fine;
}

/// What Bfr does at a corner and beside it.
struct Approximates {
    bool at = false, beside = false;
};

Approximates approximates(const Far::TopologyLevel& level, const Sector& corner, int uv_set)
{
    const int vertex = level.GetFaceVertices(corner.face)[corner.corner];
    if (uv_set >= 0 && !level.DoesVertexFVarTopologyMatch(vertex, uv_set)) return {false, true};
    if (level.IsVertexNonManifold(vertex)) return {false, true};
    const bool is_boundary = level.IsVertexBoundary(vertex);
    const int faces = level.GetVertexFaces(vertex).size();
    if (Sdc::Crease::IsInfinite(level.GetVertexSharpness(vertex))) return {false, !is_boundary || faces != 1};
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
        : mesh_(part.mesh),
          surface_(part.has_uv() ? mesh_.uv_surface(0) : mesh_.surface(0)),
          count_(part.weights.front().of.size())
    {
        std::vector<int> controls(static_cast<std::size_t>(surface_.GetNumControlPoints()));
        surface_.GetControlPointIndices(controls.data());
        // Values that collapse around a vertex of two faces leave points without an index (-1), which have no weight.
        for (const int control : controls)
            weights_.push_back(part.weights[static_cast<std::size_t>(std::max(control, 0))].of);
    }

    /// Returns about how many bytes it takes.
    std::size_t bytes() const noexcept
    {
        return sizeof *this + mesh_.bytes() + bytes_of(surface_) + weights_.size() * count_ * sizeof(double);
    }

    /// Evaluates at parameters of the whole quad, counted from the corner.
    void evaluate(int corner, double x, double y, LimitSource::Of of, LimitStencil& out) const
    {
        constexpr double kScale = 1 << kSteps;
        LimitStencil own;
        lod::evaluate(surface_, x * kScale, y * kScale, of, own);
        const auto sum = [&](auto&& weight_of, std::vector<double>& to) {
            to.assign(count_, 0);
            for (std::size_t i = 0; i < weights_.size(); ++i)
                for (std::size_t k = 0; k < count_; ++k) to[k] += weight_of(i) * weights_[i][k];
        };
        sum([&](std::size_t i) { return own.p[i]; }, out.p);
        if (of == LimitSource::Of::Point) return;
        const auto derivatives = [&](std::size_t i) {
            return derivatives_in_quad(corner, own.du[i] * kScale, own.dv[i] * kScale);
        };
        sum([&](std::size_t i) { return derivatives(i)[0]; }, out.du);
        sum([&](std::size_t i) { return derivatives(i)[1]; }, out.dv);
    }

private:
    SmallSurface mesh_;
    Bfr::Surface<double> surface_;
    std::size_t count_;
    std::vector<std::vector<double>> weights_;
};

CornerLimits::CornerLimits(const Far::TopologyLevel& level, const Sector& quad, const MeshRules& rules, int uv_set,
                           ClassAccount* account)
    : part_(level, rules, uv_set), account_(account), is_whole_(level.GetFaceVertices(quad.face).size() == 4)
{
    part_.add_with_neighbours(quad);
    part_.add_sharpness();
    const auto set = [&](int corner, const Approximates& does) {
        at_[static_cast<std::size_t>(corner)] = does.at;
        beside_[static_cast<std::size_t>(corner)] = does.beside;
    };
    set(0, approximates(level, quad, uv_set));
    if (is_whole_) {
        for (int corner = 1; corner < 4; ++corner)
            set(corner, approximates(level, {quad.face, (quad.corner + corner) % 4}, uv_set));
        return;
    }
    set(2, {false, true});
}

CornerLimits::~CornerLimits()
{
    if (account_) account_->remove(counted_);
}

// The lock is held.
std::shared_ptr<const CornerLimits::Refined> CornerLimits::refined(int corner) const
{
    if (last_corner_ == corner) return last_;
    WeightedPart part{part_.mesh, std::vector<Weights>(controls().size())};
    for (std::size_t v = 0; v < part.weights.size(); ++v) {
        part.weights[v].of.resize(part.weights.size());
        part.weights[v].of[v] = 1;
    }
    if (!is_whole_) part = refined_at(part, 0);
    for (int step = 0; step < kSteps; ++step) part = refined_at(part, step == 0 ? corner : 0);
    last_ = std::make_shared<const Refined>(part);
    last_corner_ = corner;
    if (account_) {
        account_->remove(counted_);
        account_->add(counted_ = last_->bytes());
    }
    return last_;
}

void CornerLimits::evaluate_at(int corner, LimitStencil& out) const
{
    const std::lock_guard lock(mutex_);
    LimitStencil& known = corners_[static_cast<std::size_t>(corner)];
    if (known.p.empty()) {
        LimitStencil made;  // if memory fails, the next caller begins anew
        refined(corner)->evaluate(corner, 0, 0, LimitSource::Of::PointAndTangents, made);
        known = std::move(made);
    }
    out = known;
}

void CornerLimits::evaluate_beside(int corner, const std::array<double, 2>& at, LimitSource::Of of, LimitStencil& out) const
{
    std::shared_ptr<const Refined> surface;
    {
        const std::lock_guard lock(mutex_);
        surface = refined(corner);
    }
    surface->evaluate(corner, at[0], at[1], of, out);
}

bool CornerLimits::evaluate(double u, double v, LimitSource::Of of, LimitStencil& out) const
{
    constexpr double kNear = 1.0 / (1 << kSteps);
    for (int corner = 0; corner < 4; ++corner) {
        const std::array<double, 2> at = from_corner(corner, u, v);
        if (at[0] >= kNear || at[1] >= kNear) continue;
        const bool is_corner = at[0] == 0 && at[1] == 0;
        if (!(is_corner ? at_ : beside_)[static_cast<std::size_t>(corner)]) return false;
        if (is_corner) evaluate_at(corner, out);
        else evaluate_beside(corner, at, of, out);
        return true;
    }
    return false;
}

}  // namespace occam::lod
