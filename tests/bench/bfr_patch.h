// One face's limit surface by OpenSubdiv's Bfr, as a caller without our stencils would use it.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "scenegraph/cage.h"

namespace occam::bench {

struct LimitPoint {
    Vec3d p{0}, du{0}, dv{0};
};

class BfrPatch {
public:
    /// positions    vertices of the cage, in the frame in which points are computed
    BfrPatch(const Cage& cage, std::span<const Vec3f> positions, int face);
    ~BfrPatch();

    /// Computes points with tangents; u and v alternate in `uv`.
    void evaluate_float(std::span<const float> uv, std::span<std::array<float, 9>> out) const;
    void evaluate_double(std::span<const double> uv, std::span<LimitPoint> out) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam::bench
