// Switches the techniques by which trees are built.
#pragma once

namespace occam::accel {

/// Switches what makes building cheap (Djeu et al. 2011, fig. 11) or trees better, each part by itself, for benchmarks. The
/// hits of rays do not depend on it.
struct BuildTechniques {
    /// Nodes are split when a ray enters them; otherwise all are split before the first ray, down to clusters of base
    /// patches.
    bool lazy = true;
    /// Scene nodes and clusters represent everything below them; otherwise the root lists every base patch.
    bool hierarchy = true;
    /// For many boxes, planes at fixed steps are tried; otherwise one plane at each end of every box.
    bool scan = true;
    /// Triangles of meshes may be cut where their boxes overlap much; this costs building and saves rays.
    bool spatial = true;
};

}  // namespace occam::accel
