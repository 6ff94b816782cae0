#include "io/import/gltf_skin_paths.h"

#include <unordered_set>

namespace occam::import {

template <class IsEnd>
void SkinPaths::charge_path(NodeId node, const std::string& where, IsEnd&& is_end)
{
    for (NodeId at = scene_.node(node).parent; at && !is_end(at); at = scene_.node(at).parent) {
        if (left_ == 0)
            throw Error(report_.name(), "there are too many nodes above the joints of skins and above what wears them",
                        where);
        --left_;
    }
}

void SkinPaths::charge_joints(const std::vector<NodeId>& joints, const std::string& where)
{
    const std::unordered_set<NodeId> of_skin(joints.begin(), joints.end());
    for (const NodeId joint : joints) charge_path(joint, where, [&](NodeId at) { return of_skin.contains(at); });
}

void SkinPaths::charge_wearer(NodeId wearer, NodeId joint, const std::string& where)
{
    for (const NodeId from : {wearer, joint}) charge_path(from, where, [](NodeId) { return false; });
}

}  // namespace occam::import
