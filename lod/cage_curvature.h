// How sharply the surface of a cage bends, which says how much edges of some length cut off from it.
#pragma once

#include <atomic>

#include "scenegraph/cage.h"

namespace occam::lod {

/// Returns an estimate of the least radius of curvature of a subdivision cage's limit surface, in the cage's own length,
/// from how far the normals of its control points turn along its edges, and how far they are from those of the corners of
/// faces; infinity where it is flat. Displacement does not count.
double least_radius_of_curvature(const Cage& cage);

/// Keeps what least_radius_of_curvature() gave for a cage. All callers pass the same cage.
/// Threads  any may ask; several that ask first compute the same number
class CageCurvature {
public:
    double least_radius(const Cage& cage) const
    {
        double radius = kept_.load(std::memory_order_relaxed);
        if (radius < 0) kept_.store(radius = least_radius_of_curvature(cage), std::memory_order_relaxed);
        return radius;
    }
    /// Forgets it, because the cage has changed. Nobody may ask meanwhile.
    void forget() noexcept { kept_.store(kUnknown, std::memory_order_relaxed); }

private:
    static constexpr double kUnknown = -1;
    mutable std::atomic<double> kept_{kUnknown};
};

}  // namespace occam::lod
