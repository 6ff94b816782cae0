// Points that stand for what a patch cannot list: the corners of a face of thousands, the faces around such a vertex, or
// very many vertices in all.
//
// The limit surface at such a place depends on all of these vertices, so a table of weights grows with their square.
// Instead, a cage that has a large face or a large vertex gets derived points, once for each pose and in linear time: the
// vertices of the cage refined once (so that a large face becomes a large vertex among quads), and for each large vertex its
// *moves*. A move is the way from the vertex's position at one level of refinement to that at the next; it depends on the
// whole ring, and all else near the vertex depends on few spokes of it (ring_patch.h). Which faces and vertices are large is
// said in scenegraph/large_parts.h.
//
// Space    that of the vertices that are passed in.
// Threads  const calls from any thread.
// This header is private to lod/.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "lod/class_memory.h"
#include "lod/mesh_part.h"
#include "lod/small_surface.h"
#include "scenegraph/large_parts.h"

namespace occam::lod {

/// Tells how the surface in one sector of a large vertex follows a move of that vertex, with all other points at rest. The
/// sector is [0, 2] x [0, 2] in steps of the level at which the vertex moves.
class FanModel {
public:
    /// sharpness   of the spokes, counter-clockwise; the sector lies between spokes `own` and own + 1
    FanModel(std::span<const float> sharpness, std::size_t own);
    /// Returns the weight at (x, y), with x along spoke `own`, and its two derivatives. Beyond 2 it is 0.
    std::array<double, 3> weight(double x, double y) const;
    /// Returns whether no spoke is a crease: such models are few.
    bool is_smooth() const noexcept { return is_smooth_; }
    std::size_t bytes() const noexcept;

private:
    struct Quad {
        OpenSubdiv::Bfr::Surface<double> surface;
        std::size_t count = 0;           ///< control points
        std::vector<std::size_t> poles;  ///< which of them are the vertex: OpenSubdiv fills up corners of one face with it
    };
    SmallSurface mesh_;
    bool is_smooth_;
    std::array<Quad, 4> quads_;
};

class DerivedPoints {
public:
    static constexpr int kMoves = int(kMovesOfALargeVertex);
    static constexpr std::uint32_t kNone = ~0u;

    /// Returns the derived points of a cage, or null if no patch needs them. Throws Error if there is no room for them.
    /// refiner   the cage's connectivity, which must outlive the points
    static std::unique_ptr<const DerivedPoints> make(const Cage& cage, const OpenSubdiv::Far::TopologyRefiner& refiner,
                                                     ClassMemory& memory);

    std::uint32_t size() const noexcept { return size_; }
    /// Returns whether the patches of a face depend on a large face or vertex, and so take derived points.
    bool has_face(std::uint32_t face) const noexcept { return faces_[face] != 0; }
    const OpenSubdiv::Far::TopologyLevel& base() const noexcept { return refiner_->GetLevel(0); }
    /// Returns the connectivity of the first derived points: the cage, refined once.
    const OpenSubdiv::Far::TopologyLevel& level() const noexcept { return refiner_->GetLevel(1); }
    bool is_large(int vertex) const noexcept { return level().GetVertexFaces(vertex).size() >= int(kLargeFrom); }
    /// Returns the first of the moves of a large vertex of level(); kNone if it stays where it is.
    std::uint32_t first_move(int vertex) const noexcept;

    void compute(std::span<const Vec3f> vertices, std::span<Vec3f> out) const;

    /// Returns the model of a sector after `step` steps of refinement. Sectors that are alike share it. One with creases
    /// lives as long as somebody holds it.
    std::shared_ptr<const FanModel> fan(std::span<const float> sharpness, std::size_t own, int step) const;

private:
    struct Star;
    struct Pole {
        int vertex = 0;
        std::vector<int> ends, corners;  ///< of spokes and of sectors, counter-clockwise; vertices of level()
        std::vector<std::shared_ptr<const Star>> stars;  ///< one for each move
    };

    using StarKey = std::pair<std::size_t, std::vector<float>>;  ///< the number of sectors, and sharpness as in Star
    using Stars = std::map<StarKey, std::shared_ptr<const Star>>;

    DerivedPoints(bool is_smooth, const OpenSubdiv::Far::TopologyRefiner& refiner, std::vector<std::uint8_t> faces,
                  ClassMemory& memory);
    void add_pole(int vertex, Stars& stars);

    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
    std::vector<std::uint8_t> faces_;
    std::vector<Pole> poles_;
    std::map<int, std::uint32_t> first_move_;
    std::uint32_t size_ = 0;
    CountedBytes counted_;
    mutable std::mutex mutex_;  // guards the members below
    mutable std::map<std::pair<std::vector<float>, std::size_t>, std::weak_ptr<const FanModel>> fans_;
    mutable std::vector<std::shared_ptr<const FanModel>> smooth_fans_;
    mutable std::size_t most_fans_ = 1024;  ///< at this number of entries those without a model are dropped
};

/// Returns the faces that follow a sector around its vertex, at most `most` of them, up to a border or to the sector itself.
std::vector<Sector> sectors_after(const OpenSubdiv::Far::TopologyLevel& level, Sector from, bool counter_clockwise,
                                  std::size_t most);

}  // namespace occam::lod
