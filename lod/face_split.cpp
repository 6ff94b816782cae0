#include "lod/face_split.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "base/simd.h"

namespace occam::lod {
namespace {

constexpr int kBins = 16;
constexpr std::size_t kSamples = 8192;     // most faces by which a plane is chosen: of more faces every n-th is taken
constexpr std::size_t kWorthParting = 32;  // number of faces from which on large ones are separated
constexpr float kLarge = 1.0f / 16;        // share of the whole box's area from which on a face is large
constexpr float kWorthIt = 0.9f;           // a split pays below this share of the cost without it

// The least and the largest of eight numbers at a time. Of the words of a BoxedFace these are the bounds of its box: the
// least of the first three, and the largest of the next three.
class Bounds {
public:
    Bounds() noexcept
    {
        for (int i = 0; i < kParts; ++i) {
            least_[i] = std::numeric_limits<float>::infinity();
            largest_[i] = -std::numeric_limits<float>::infinity();
        }
    }
    void add(const BoxedFace& face) noexcept
    {
        static_assert(sizeof(BoxedFace) == 8 * sizeof(float) && offsetof(BoxedFace, box) == 0);
        const float* words = reinterpret_cast<const float*>(&face);
        for (int i = 0; i < kParts; ++i) {
            const vfloat some = vfloat::load(words + i * kLanes);
            add(i, some, some);
        }
    }
    void add(const Bounds& other) noexcept
    {
        for (int i = 0; i < kParts; ++i) add(i, other.least_[i], other.largest_[i]);
    }
    float half_area() const noexcept
    {
        alignas(32) float least[8], largest[8];
        for (int i = 0; i < kParts; ++i) {
            least_[i].store(least + i * kLanes);
            largest_[i].store(largest + i * kLanes);
        }
        return Box3f{{least[0], least[1], least[2]}, {largest[3], largest[4], largest[5]}}.half_area();
    }

private:
    static constexpr int kParts = 8 / kLanes;

    // What is not a number changes nothing.
    void add(int i, vfloat low, vfloat high) noexcept
    {
        least_[i] = min(low, least_[i]);
        largest_[i] = max(high, largest_[i]);
    }
    vfloat least_[kParts], largest_[kParts];
};

struct Bin {
    Bounds bounds;
    std::size_t count = 0;
    void add(const BoxedFace& face) noexcept
    {
        bounds.add(face);
        ++count;
    }
    void add(const Bin& other) noexcept
    {
        bounds.add(other.bounds);
        count += other.count;
    }
    float cost() const noexcept
    {
        return count == 0 ? 0.0f : bounds.half_area() * static_cast<float>((count + kFacesOfABlock - 1) / kFacesOfABlock);
    }
};

Vec3f twice_centre(const BoxedFace& f) noexcept { return f.box.lo + f.box.hi; }

// Returns the bin of a position; NaN belongs to the first bin.
int bin_of(float position, float from, float scale) noexcept
{
    const float x = (position - from) * scale;
    return x > 0 ? x < float(kBins) ? static_cast<int>(x) : kBins - 1 : 0;
}

struct Plane {
    int axis = -1;
    int bin = 0;  // first bin of the second part
    float from = 0, scale = 0;
    float cost = std::numeric_limits<float>::infinity();
};

// Refers to one in `step` of the faces. No part may have more than `most` of these.
struct Sampled {
    std::span<const BoxedFace> faces;
    std::size_t step, most;
};

// The faces in bins along the three axes.
class Bins {
public:
    /// centres   the bounds of the faces' centres, doubled
    Bins(const Sampled& sampled, const Box3f& centres) noexcept : most_(sampled.most), from_(centres.lo)
    {
        for (int axis = 0; axis < 3; ++axis) {
            scale_[axis] = float(kBins) / (centres.hi[axis] - centres.lo[axis]);
            is_flat_[axis] = !(scale_[axis] < std::numeric_limits<float>::max());
        }
        for (std::size_t i = 0; i < sampled.faces.size(); i += sampled.step) {
            const BoxedFace& face = sampled.faces[i];
            const Vec3f at = twice_centre(face);
            for (int axis = 0; axis < 3; ++axis)
                if (!is_flat_[axis]) bins_[axis][bin_of(at[axis], from_[axis], scale_[axis])].add(face);
        }
    }
    /// Tries all planes between the bins of an axis.
    void try_axis(int axis, Plane& best) const noexcept
    {
        if (is_flat_[axis]) return;
        const Bin(&bins)[kBins] = bins_[axis];
        Bin above[kBins];  // the sum of each bin and all that follow
        above[kBins - 1] = bins[kBins - 1];
        for (int b = kBins - 2; b > 0; --b) {
            above[b] = above[b + 1];
            above[b].add(bins[b]);
        }
        Bin below;
        for (int b = 1; b < kBins; ++b) {
            below.add(bins[b - 1]);
            if (below.count == 0 || above[b].count == 0 || below.count > most_ || above[b].count > most_) continue;
            const float cost = below.cost() + above[b].cost();
            if (cost < best.cost) best = {axis, b, from_[axis], scale_[axis], cost};
        }
    }

private:
    std::size_t most_;
    Vec3f from_, scale_;
    bool is_flat_[3];
    Bin bins_[3][kBins];
};

// Moves the faces for which is_first() holds to the front and returns their number. It has no branch that depends on a face:
// half of these would be foretold wrongly, which takes longer than to move each face.
template <class IsFirst>
std::size_t part(std::span<BoxedFace> faces, const IsFirst& is_first) noexcept
{
    std::size_t count = 0;
    for (BoxedFace& face : faces) {
        const BoxedFace moved = face;
        face = faces[count];
        faces[count] = moved;
        count += is_first(moved) ? 1u : 0u;
    }
    return count;
}

}  // namespace

FaceSplit split_faces(std::span<BoxedFace> faces, std::size_t most) noexcept
{
    const std::size_t count = faces.size(), step = (count + kSamples - 1) / kSamples;
    Bin all;
    Box3f centres;
    for (std::size_t i = 0; i < count; i += step) {
        all.add(faces[i]);
        centres.add(twice_centre(faces[i]));
    }
    const auto are_parted = [&](std::size_t first) {
        return first > 0 && first < count && first <= most && count - first <= most;
    };
    if (count >= kWorthParting) {
        const float large = all.bounds.half_area() * kLarge;
        const auto is_large = [&](const BoxedFace& f) { return f.box.half_area() >= large; };
        std::size_t n = 0;
        for (std::size_t i = 0; i < count; i += step) n += is_large(faces[i]);
        if (n > 0 && n <= all.count / 4) {
            const std::size_t first = part(faces, is_large);
            if (are_parted(first)) return {first, true};
        }
    }
    Plane best;
    const std::size_t most_sampled = step == 1 ? most : all.count;
    const Bins bins({faces, step, most_sampled}, centres);
    for (int axis = 0; axis < 3; ++axis) bins.try_axis(axis, best);
    if (best.axis >= 0) {
        // Those of the bins before best.bin, as bin_of() has them.
        const auto is_below = [&, from = best.from, scale = best.scale, end = float(best.bin)](const BoxedFace& f) {
            return !((twice_centre(f)[best.axis] - from) * scale >= end);
        };
        const std::size_t first = part(faces, is_below);
        if (are_parted(first)) return {first, best.cost < kWorthIt * all.cost()};
    }
    // All centres are in one place, or each plane would leave too many faces in one part.
    return {count / 2, false};
}

}  // namespace occam::lod
