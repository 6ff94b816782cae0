// Cryptomatte: which objects and materials a pixel shows, and the coverage of each, by Psyop's specification 1.2.0.
//
// The id of a name is its MurmurHash3, read as the bits of a float. The ids of a pixel are ranked by coverage, and two of
// them with their coverages make one RGBA layer: CryptoObject00 holds ranks 0 and 1, CryptoObject01 ranks 2 and 3, and so
// on. A manifest in the header of the file lists the names. An object is a node, identified by its name, so instances of
// one name are one matte.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "render/image.h"
#include "render/settings.h"
#include "scenegraph/scene.h"

namespace occam::render {

inline constexpr int kMatteRanks = 6, kMatteLayers = kMatteRanks / 2;

/// Returns the MurmurHash3_x86_32 (Appleby, public domain) of UTF-8 text with seed 0.
std::uint32_t murmur3(std::string_view text) noexcept;
/// Returns the same hash as a finite, normal number: an exponent of all zeros or all ones has its lowest bit flipped.
float matte_id(std::string_view name) noexcept;

std::string_view matte_name(const Scene& scene, NodeId node) noexcept;
std::string_view matte_name(const Material& material) noexcept;

/// Holds the share of one sample that one surface covers.
struct MatteShare {
    std::uint32_t sample = 0;  ///< index in the batch
    float object = 0, material = 0;
    float coverage = 0;
};

/// Sums the ids of one pixel. The sums depend only on the order of the samples and of the surfaces of each.
///
/// A pixel keeps at most kMostIds of them, of which the largest coverages are written. Where it has more, a new id takes the
/// place and the mass of the one with the least (Metwally et al. 2005, "Efficient computation of frequent and top-k elements
/// in data streams"). So each id with more than 1 / kMostIds of the mass of all is kept in the end, however late it comes,
/// and what is missing of its coverage is no more than that.
class MatteSums {
public:
    static constexpr std::size_t kMostIds = 64;

    void clear() noexcept { shares_.clear(); }
    void add(float id, double coverage);
    struct Share {
        float id;
        float mass;       ///< what it covers without the signs of weights, and the mass of those whose places it took
        double coverage;  ///< since it has its place
    };
    /// Adds an id of sums that were kept, in their order. Returns false if there are too many.
    bool restore(const Share& share);
    /// Writes id and coverage of each rank, the largest coverage first (then the id with the smaller bits), and zeros
    /// where there are fewer. Overwrites the order in which shares were added.
    /// weight   of all samples of the pixel
    void rank(double weight, float (&out)[2 * kMatteRanks]);

    const std::vector<Share>& shares() const noexcept { return shares_; }

private:
    std::vector<Share> shares_;
};

/// Returns CryptoObject or CryptoMaterial, or an empty name for other layers.
std::string_view matte_layer(Aov aov) noexcept;

/// Adds the attributes that readers of the layers need: names, hash, conversion and manifest.
void describe_mattes(Image& image, const Scene& scene, const Settings& settings);

}  // namespace occam::render
