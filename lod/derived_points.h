// Points that stand for what a patch cannot list: the corners of a face of thousands, or the faces around such a vertex.
//
// The limit surface at such a place depends on all of these vertices, so a table of weights grows with their square.
// Instead, a cage that has a large face or a large vertex gets derived points, once for each pose and in linear time: the
// vertices of the cage refined once (so that a large face becomes a large vertex among quads), and for each large vertex its
// *moves*. A move is the way from the vertex's position at one level of refinement to that at the next; it depends on the
// whole ring, and all else near the vertex depends on few spokes of it (ring_patch.h).
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

#include "lod/topology_mesh.h"

namespace occam::lod {

/// Faces of more corners, and vertices of more faces, are large.
inline constexpr int kLargeFrom = 65;

/// The limit surface of a small mesh, by OpenSubdiv's Bfr.
class SmallSurface {
public:
    explicit SmallSurface(const Cage& mesh);
    OpenSubdiv::Bfr::Surface<double> surface(int face) const;

private:
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
    std::unique_ptr<const SurfaceFactory> factory_;
};

/// Tells how the surface in one sector of a large vertex follows a move of that vertex, with all other points at rest. The
/// sector is [0, 2] x [0, 2] in steps of the level at which the vertex moves.
class FanModel {
public:
    /// sharpness   of the spokes, counter-clockwise; the sector lies between spokes `own` and own + 1
    FanModel(std::span<const float> sharpness, std::size_t own);
    /// Returns the weight at (x, y), with x along spoke `own`, and its two derivatives. Beyond 2 it is 0.
    std::array<double, 3> weight(double x, double y) const;

private:
    struct Quad {
        OpenSubdiv::Bfr::Surface<double> surface;
        std::size_t count = 0, pole = 0;  ///< control points, and which of them is the vertex; `count` if none is
    };
    SmallSurface mesh_;
    std::array<Quad, 4> quads_;
};

class DerivedPoints {
public:
    /// The number of moves of a vertex. Each is at most 0.66 times as long as the one before, so the rest is below rounding.
    static constexpr int kMoves = 24;
    static constexpr std::uint32_t kNone = ~0u;

    /// Returns the derived points of a cage, or null if it has no large face or vertex.
    static std::unique_ptr<const DerivedPoints> make(const Cage& cage, const OpenSubdiv::Far::TopologyLevel& level);

    std::uint32_t size() const noexcept { return size_; }
    /// Returns whether the patches of a face depend on a large face or vertex, and so take derived points.
    bool has_face(std::uint32_t face) const noexcept { return faces_[face] != 0; }
    const OpenSubdiv::Far::TopologyLevel& base() const noexcept { return refiner_->GetLevel(0); }
    /// Returns the connectivity of the first derived points: the cage, refined once.
    const OpenSubdiv::Far::TopologyLevel& level() const noexcept { return refiner_->GetLevel(1); }
    bool is_large(int vertex) const noexcept { return level().GetVertexFaces(vertex).size() >= kLargeFrom; }
    /// Returns the first of the moves of a large vertex of level(); kNone if it stays where it is.
    std::uint32_t first_move(int vertex) const noexcept;

    void compute(std::span<const Vec3f> vertices, std::span<Vec3f> out) const;

    /// Returns the model of a sector after `step` steps of refinement. Sectors that are alike share it.
    std::shared_ptr<const FanModel> fan(std::span<const float> sharpness, std::size_t own, int step) const;

private:
    struct Star;
    struct Pole {
        int vertex = 0;
        std::vector<int> ends, corners;  ///< of spokes and of sectors, counter-clockwise; vertices of level()
        std::vector<std::shared_ptr<const Star>> stars;  ///< one for each move
    };

    DerivedPoints(const Cage& cage, std::vector<std::uint8_t> faces);
    void add_pole(int vertex);

    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
    std::vector<std::uint8_t> faces_;
    std::vector<Pole> poles_;
    std::map<int, std::uint32_t> first_move_;
    std::uint32_t size_ = 0;
    mutable std::mutex mutex_;
    mutable std::map<std::pair<std::vector<float>, std::size_t>, std::shared_ptr<const FanModel>> fans_;
};

/// A face around a vertex, and which of its corners the vertex is.
struct Sector {
    int face = 0, corner = 0;
};
/// Returns the faces that follow a sector around its vertex, at most `most` of them, up to a border or to the sector itself.
std::vector<Sector> sectors_after(const OpenSubdiv::Far::TopologyLevel& level, Sector from, bool counter_clockwise,
                                  std::size_t most);

}  // namespace occam::lod
