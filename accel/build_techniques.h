// Switches the techniques that make building cheap.
#pragma once

namespace occam::accel {

/// Switches what makes building cheap, each part by itself, for benchmarks (Djeu et al. 2011, fig. 11). The hits of
/// rays do not depend on it.
struct BuildTechniques {
    /// Nodes are split when a ray enters them; otherwise all are split before the first ray, down to clusters of base
    /// patches.
    bool lazy = true;
    /// Scene nodes and clusters represent everything below them; otherwise the root lists every base patch.
    bool hierarchy = true;
    /// For many boxes, planes at fixed steps are tried; otherwise one plane at each end of every box.
    bool scan = true;
};

}  // namespace occam::accel
