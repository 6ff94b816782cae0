// A limit to the nodes between the joints of skins, what wears them and the root: linking and posing a skin visits them, and
// each remembers what it moves, so a small file with many skins below a long chain of nodes would take minutes and
// gigabytes.
#pragma once

#include "io/import/report.h"
#include "scenegraph/scene.h"

namespace occam::import {

/// Counts the nodes between the joints of skins, what wears them and the root.
class SkinPaths {
public:
    SkinPaths(const Scene& scene, const Report& report) : scene_(scene), report_(report) {}

    /// Charges the nodes from each joint up to the nearest joint of the skin, or else to the root. Throws Error, naming the
    /// element, if they are too many.
    void charge_joints(const std::vector<NodeId>& joints, const std::string& where);
    /// Charges the nodes above one that wears a skin, those above one of its joints, and all of its joints, likewise: the
    /// bounds of what is worn hold what each joint moves.
    void charge_wearer(NodeId wearer, const std::vector<NodeId>& joints, const std::string& where);

private:
    void charge(std::size_t nodes, const std::string& where);
    template <class IsEnd>
    void charge_path(NodeId node, const std::string& where, IsEnd&& is_end);

    const Scene& scene_;
    const Report& report_;
    std::size_t left_ = std::size_t(1) << 24;
};

}  // namespace occam::import
