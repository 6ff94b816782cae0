// Measures how the faces of a cage lie in its box.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "base/hash.h"
#include "scenegraph/cage.h"
#include "scenegraph/cage_faces.h"
#include "scenegraph/contents.h"

namespace occam {
namespace {

/// Sums up how the faces of a cage lie in its box.
class LayerSums {
public:
    /// of_slot   gets the sums of the faces of each material slot, if there are several
    LayerSums(const Cage& cage, std::span<FaceLayers::Passing> of_slot) noexcept
        : cage_(cage), of_slot_(of_slot), bound_(cage.is_displaced() ? double(cage.displacement->bound) : 0)
    {
        std::ranges::fill(of_slot_, FaceLayers::Passing());
    }
    /// first   of the face's corners, in Cage::face_vertices
    void add(std::size_t face, std::size_t first, std::size_t corners) noexcept
    {
        // A box of triangles is tested together with seven others. Each corner of a polygon that is subdivided has a patch
        // of its own, which is smaller the more corners there are.
        constexpr double kOfATriangle = 1.0 / 8;
        constexpr std::size_t kCornersOfALayer = 8;
        Box3d box;
        for (std::size_t c = first; c < first + corners; ++c) box.add(Vec3d(cage_.positions[cage_.face_vertices[c]]));
        box = {box.lo - bound_, box.hi + bound_};
        whole_.add(box);
        sizes_ += Contents::size_of(box) * (cage_.scheme == Scheme::Triangles
                                                ? kOfATriangle
                                                : double(std::max<std::size_t>(1, corners / kCornersOfALayer)));
        const double volume = Contents::volume_of(box),
                     area = polygon_area(corners, [&](std::size_t corner) {
                         return Vec3d(cage_.positions[cage_.face_vertices[first + corner]]);
                     });
        volumes_ += volume;
        areas_ += area;
        if (of_slot_.empty()) return;
        FaceLayers::Passing& slot = of_slot_[std::min<std::size_t>(cage_.face_slots[face], of_slot_.size() - 1)];
        slot.held += volume;
        slot.area += area;
    }
    /// Writes how many surfaces a ray meets, and in how many boxes a point lies: at least 1, and 1 for what is a point,
    /// flat, or overflows.
    ///
    /// Returns how many faces a ray passes that crosses the cage's box.
    /// scale   the number of the cage's faces for each that was added
    double write(double scale, FaceLayers& layers) const noexcept
    {
        constexpr double kOfAClosedSurface = 3;  // what the boxes of its faces come to: 2.7 for a cube
        const double to_depth = scale / Contents::volume_of(whole_);
        const double across = scale * sizes_ / Contents::size_of(whole_), depth = to_depth * volumes_;
        layers.crossed = std::isfinite(across) && whole_.extent() != Vec3d(0) ? std::max(1.0, across - kOfAClosedSurface)
                                                                              : 1;
        layers.all = {std::isfinite(depth) ? std::max(1.0, depth) : 1, scale * areas_};
        for (FaceLayers::Passing& slot : of_slot_)
            slot = {std::isfinite(depth) ? to_depth * slot.held : 0, scale * slot.area};
        return scale * areas_ / Contents::area_of(whole_);
    }

private:
    const Cage& cage_;
    std::span<FaceLayers::Passing> of_slot_;
    double bound_;
    Box3d whole_;
    double sizes_ = 0, volumes_ = 0, areas_ = 0;
};

/// Measures the layers by one face of every `step`. Which one it is changes, so that a regular order of the faces has no
/// influence. Returns as LayerSums::write().
double measure_by(const Cage& cage, std::size_t step, FaceLayers& layers) noexcept
{
    LayerSums sums(cage, layers.of_slot);
    std::size_t first = 0;
    for (std::size_t face = 0; face < cage.face_count(); ++face) {
        const std::size_t corners = cage.scheme == Scheme::Triangles ? 3 : cage.face_sizes[face];
        if (step == 1 || face % step == mix_bits(face / step) % step) sums.add(face, first, corners);
        first += corners;
    }
    return sums.write(double(step), layers);
}

}  // namespace

void FaceLayers::measure(const Cage& cage)
{
    of_slot.resize(cage.face_slots.empty() || cage.materials.size() < 2 ? 0 : cage.materials.size());
    // Of many faces some are looked at first, and all of them only where these overlap. So a cage whose faces hardly overlap
    // costs little whenever its vertices move, and the result depends on the cage alone.
    constexpr std::size_t kLookedAt = 1024;
    constexpr double kMany = 64;
    const std::size_t step = std::max<std::size_t>(1, cage.face_count() / kLookedAt);
    const double passed = measure_by(cage, step, *this);
    if (step > 1 && (crossed > kMany || all.held > kMany || passed > kMany)) measure_by(cage, 1, *this);
}

}  // namespace occam
