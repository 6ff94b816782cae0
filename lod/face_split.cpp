#include "lod/face_split.h"

#include <algorithm>
#include <limits>

namespace occam::lod {
namespace {

constexpr int kBins = 16;
constexpr std::size_t kSamples = 8192;     // most faces by which a plane is chosen: of more faces every n-th is taken
constexpr std::size_t kWorthParting = 32;  // number of faces from which on large ones are separated
constexpr float kLarge = 1.0f / 16;        // share of the whole box's area from which on a face is large
constexpr float kWorthIt = 0.9f;           // a split pays below this share of the cost without it

struct Bin {
    Box3f box;
    std::size_t count = 0;
    void add(const Bin& other) noexcept
    {
        box.add(other.box);
        count += other.count;
    }
    float cost() const noexcept
    {
        return count == 0 ? 0.0f : box.half_area() * static_cast<float>((count + kFacesOfABlock - 1) / kFacesOfABlock);
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

// Tries all planes between the bins of an axis.
void try_axis(const Sampled& sampled, int axis, float from, float to, Plane& best)
{
    const auto [faces, step, most] = sampled;
    const float scale = float(kBins) / (to - from);
    if (!(scale < std::numeric_limits<float>::max())) return;
    Bin bins[kBins];
    for (std::size_t i = 0; i < faces.size(); i += step) {
        Bin& bin = bins[bin_of(twice_centre(faces[i])[axis], from, scale)];
        bin.box.add(faces[i].box);
        ++bin.count;
    }
    Bin above[kBins];  // the sum of each bin and all that follow
    above[kBins - 1] = bins[kBins - 1];
    for (int b = kBins - 2; b > 0; --b) {
        above[b] = above[b + 1];
        above[b].add(bins[b]);
    }
    Bin below;
    for (int b = 1; b < kBins; ++b) {
        below.add(bins[b - 1]);
        if (below.count == 0 || above[b].count == 0 || below.count > most || above[b].count > most) continue;
        const float cost = below.cost() + above[b].cost();
        if (cost < best.cost) best = {axis, b, from, scale, cost};
    }
}

}  // namespace

FaceSplit split_faces(std::span<BoxedFace> faces, std::size_t most) noexcept
{
    const std::size_t count = faces.size(), step = (count + kSamples - 1) / kSamples;
    Bin all;
    Box3f centres;
    for (std::size_t i = 0; i < count; i += step) {
        all.box.add(faces[i].box);
        centres.add(twice_centre(faces[i]));
        ++all.count;
    }
    const auto are_parted = [&](std::size_t first) {
        return first > 0 && first < count && first <= most && count - first <= most;
    };
    if (count >= kWorthParting) {
        const float large = all.box.half_area() * kLarge;
        const auto is_large = [&](const BoxedFace& f) { return f.box.half_area() >= large; };
        std::size_t n = 0;
        for (std::size_t i = 0; i < count; i += step) n += is_large(faces[i]);
        if (n > 0 && n <= all.count / 4) {
            const auto first = static_cast<std::size_t>(std::partition(faces.begin(), faces.end(), is_large) -
                                                        faces.begin());
            if (are_parted(first)) return {first, true};
        }
    }
    Plane best;
    const std::size_t most_sampled = step == 1 ? most : all.count;
    const Sampled sampled{faces, step, most_sampled};
    for (int axis = 0; axis < 3; ++axis) try_axis(sampled, axis, centres.lo[axis], centres.hi[axis], best);
    if (best.axis >= 0) {
        const auto is_below = [&](const BoxedFace& f) {
            return bin_of(twice_centre(f)[best.axis], best.from, best.scale) < best.bin;
        };
        const auto first = static_cast<std::size_t>(std::partition(faces.begin(), faces.end(), is_below) - faces.begin());
        if (are_parted(first)) return {first, best.cost < kWorthIt * all.cost()};
    }
    // All centres are in one place, or each plane would leave too many faces in one part.
    return {count / 2, false};
}

}  // namespace occam::lod
