// Cryptomatte: which objects and materials a pixel shows, and how much of it each covers, by Psyop's specification 1.2.0.
//
// A name's id is its MurmurHash3 as a float's bits. A pixel's ids are ranked by coverage; two of them with their coverages
// make one RGBA layer: CryptoObject00 holds ranks 0 and 1, CryptoObject01 ranks 2 and 3, and so on. A manifest in the file's
// head says the names. An object is a node by its name, so instances of one name are one matte.
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

/// MurmurHash3_x86_32 (Appleby, public domain) of UTF-8, seed 0.
std::uint32_t murmur3(std::string_view text) noexcept;
/// The same as a finite, normal number: an exponent of all zeros or ones has its lowest bit turned.
float matte_id(std::string_view name) noexcept;

std::string_view matte_name(const Scene& scene, NodeId node) noexcept;
std::string_view matte_name(const Material& material) noexcept;

/// What one surface covers of one sample.
struct MatteShare {
    std::uint32_t sample = 0;  ///< of the batch
    float object = 0, material = 0;
    float coverage = 0;
};

/// The ids of one pixel. Sums depend on the order of the samples alone.
class MatteSums {
public:
    void clear() noexcept { shares_.clear(); }
    void add(float id, double coverage);
    /// Id and coverage of each rank, the largest coverage first (then the smaller bits of the id); zeros where there are
    /// fewer. weight   of all samples of the pixel; overwrites the order of what was added
    void rank(double weight, float (&out)[2 * kMatteRanks]);

private:
    struct Share {
        float id;
        double coverage;
    };
    std::vector<Share> shares_;
};

/// CryptoObject or CryptoMaterial; empty for other layers.
std::string_view matte_layer(Aov aov) noexcept;

/// Adds what readers of the layers want to know: names, hash, conversion, manifest.
void describe_mattes(Image& image, const Scene& scene, const Settings& settings);

}  // namespace occam::render
