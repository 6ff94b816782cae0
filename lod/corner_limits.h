// The limit surface close to the corners of a quad, where OpenSubdiv approximates it.
//
// Bfr divides a patch at most ten times towards a corner that is not regular. Beside such a corner it approximates what is
// left: a ring of a thousandth of the quad's side. At the end of an infinitely sharp crease inside of a surface, and where
// semi-sharp creases use up most of the divisions, it does so at the corner, too, and normals converge slowly there. So
// points this close are found in the quad of the corner after nine steps of subdivision (Catmull and Clark 1978; Stam 1998),
// whose vertices are sums of those around the whole quad, and which Bfr may divide ten times more.
//
// Memory   the weights of each corner that was asked for, and the surface beside the last one.
// Threads  const calls from any thread.
// This header is private to lod/.
#pragma once

#include <memory>
#include <mutex>

#include "lod/mesh_part.h"
#include "lod/patch_class.h"

namespace occam::lod {

class CornerLimits {
public:
    /// level   connectivity, which must outlive this
    /// quad    a quad of it, from the corner at (0, 0) on; or a corner of another face, whose part there is the quad
    /// uv_set    the texture coordinates that are meant; -1: the positions
    /// account   if not null, it is told what the surface beside a corner takes, and outlives this
    CornerLimits(const OpenSubdiv::Far::TopologyLevel& level, const Sector& quad, const MeshRules& rules, int uv_set = -1,
                 ClassAccount* account = nullptr);
    ~CornerLimits();

    /// The vertices of the level, or the values of its texture coordinates, on which the quad depends.
    const std::vector<int>& controls() const noexcept { return part_.mesh.uv_sets.empty() ? part_.vertices : part_.values; }
    /// Evaluates the weights of controls() at (u, v) in [0, 1] of the quad. Returns false where Bfr itself is exact.
    bool evaluate(double u, double v, LimitSource::Of of, LimitStencil& out) const;

private:
    class Refined;

    std::shared_ptr<const Refined> refined(int corner) const;
    void evaluate_at(int corner, LimitStencil& out) const;
    void evaluate_beside(int corner, const std::array<double, 2>& at, LimitSource::Of of, LimitStencil& out) const;

    MeshPart part_;
    ClassAccount* account_;
    bool is_whole_;  ///< whether the quad is a face, and not a part of one
    /// Whether Bfr approximates at each corner, and beside it.
    std::array<bool, 4> at_{}, beside_{};
    mutable std::mutex mutex_;  // guards the members below
    mutable std::shared_ptr<const Refined> last_;
    mutable int last_corner_ = -1;
    mutable std::size_t counted_ = 0;              ///< bytes of `last_` that the account was told
    mutable std::array<LimitStencil, 4> corners_;  ///< at the corners themselves, once they were asked for
};

}  // namespace occam::lod
