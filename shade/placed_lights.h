// The placed lights of a frame, with the tree over them. All of it is a function of the lights and, where some are very far
// away, of about where the scene is (LightTree::origin_for()). So a renderer keeps it, and a frame whose lights are those of
// the frame before makes neither a list nor a tree.
//
// Space    world axes, frame lengths (scenegraph/frame_scale.h).
// Memory   with a tree, about 300 bytes a light, until a frame has other lights.
// Threads  PlacedLights are const once they are made.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "shade/light_tree.h"
#include "shade/lights.h"

namespace occam::shade {

struct PlacedLights {
    /// More lights than this are drawn by a tree, except for suns.
    static constexpr std::size_t kMostWithoutTree = 16;

    PlacedLights() = default;
    /// middle   that of the scene; none: it is where the lights are
    explicit PlacedLights(std::vector<WorldLight> all, std::optional<Vec3d> middle = {});

    std::vector<WorldLight> lights;  ///< first those outside the tree
    std::size_t outside_tree = 0;
    std::vector<std::uint32_t> with_extent;  ///< of those outside the tree
    LightTree tree;
    Box3d places;  ///< of the lights in the tree
};

/// Holds the placed lights of the last frame; null before the first one. It belongs to one thread at a time.
using KeptLights = std::shared_ptr<const PlacedLights>;

/// Gathers the placed lights of a frame, and compares them with those of the last one as they come.
class LightGathering {
public:
    /// last   may be null
    explicit LightGathering(KeptLights last);

    void add(const WorldLight& light);
    bool is_empty() const noexcept { return same_suns_ + same_others_ == 0 && lights_.empty(); }
    /// Returns all lights: what was kept, if they are the same to the last bit. May be called once.
    /// middle   as PlacedLights takes it
    KeptLights finish(std::optional<Vec3d> middle = {});

private:
    bool is_next(const WorldLight& light) noexcept;
    void stop_comparing();

    KeptLights last_;
    bool is_comparing_;
    /// Counts the lights that were equal to the last frame's. The list of PlacedLights has the suns in the order in which
    /// they were gathered, and the other lights in theirs.
    std::size_t same_suns_ = 0, same_others_ = 0;
    std::uint32_t suns_ = 0;          ///< has a bit for each of the first kMostWithoutTree of them: it is a sun
    std::vector<WorldLight> lights_;  ///< filled from the first difference on
};

}  // namespace occam::shade
