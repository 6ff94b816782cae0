#include "tests/bench/bfr_patch.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <stdexcept>

#include "lod/topology_mesh.h"

namespace occam::bench {

using namespace OpenSubdiv;

struct BfrPatch::State {
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::unique_ptr<Bfr::RefinerSurfaceFactory<>> factory;
    Bfr::Surface<float> in_float;
    Bfr::Surface<double> in_double;
    std::vector<float> float_points;
    std::vector<double> double_points;
};

BfrPatch::BfrPatch(const Cage& cage, std::span<const Vec3f> positions, int face) : state_(std::make_unique<State>())
{
    state_->refiner = lod::make_refiner(cage);
    if (!state_->refiner) throw std::runtime_error("OpenSubdiv refuses a cage of the benchmark");

    // The library's defaults (2, 6) do not give the limit surface; 10 is its largest value, from which Occam's own stencils
    // come.
    constexpr int kApproxLevel = 10;
    Bfr::SurfaceFactory::Options surface_options;
    surface_options.SetApproxLevelSmooth(kApproxLevel).SetApproxLevelSharp(kApproxLevel);
    state_->factory = std::make_unique<Bfr::RefinerSurfaceFactory<>>(*state_->refiner, surface_options);
    const auto prepare = [&]<class Real>(Bfr::Surface<Real>& surface, std::vector<Real>& points) {
        if (!state_->factory->InitVertexSurface(face, &surface)) throw std::runtime_error("a face without a limit surface");
        std::vector<Real> mesh;
        for (const Vec3f p : positions) mesh.insert(mesh.end(), {p.x, p.y, p.z});
        points.resize(static_cast<std::size_t>(surface.GetNumPatchPoints()) * 3);
        surface.PreparePatchPoints(mesh.data(), 3, points.data(), 3);
    };
    prepare(state_->in_float, state_->float_points);
    prepare(state_->in_double, state_->double_points);
}

BfrPatch::~BfrPatch() = default;

void BfrPatch::evaluate_float(std::span<const float> uv, std::span<std::array<float, 9>> out) const
{
    for (std::size_t i = 0; i < out.size(); ++i) {
        float* to = out[i].data();
        state_->in_float.Evaluate(&uv[2 * i], state_->float_points.data(), 3, to, to + 3, to + 6);
    }
}

void BfrPatch::evaluate_double(std::span<const double> uv, std::span<LimitPoint> out) const
{
    for (std::size_t i = 0; i < out.size(); ++i)
        state_->in_double.Evaluate(&uv[2 * i], state_->double_points.data(), 3, &out[i].p.x, &out[i].du.x, &out[i].dv.x);
}

}  // namespace occam::bench
