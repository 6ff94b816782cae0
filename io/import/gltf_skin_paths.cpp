#include "io/import/gltf_skin_paths.h"

#include <unordered_set>

namespace occam::import {

void SkinPaths::charge(std::size_t nodes, const std::string& where)
{
    if (nodes > left_)
        throw Error(
            report_.name(),
            "there are too many nodes above the joints of skins and above what wears them, or too many joints in what "
            "is worn",
            where);
    left_ -= nodes;
}

template <class IsEnd>
void SkinPaths::charge_path(NodeId node, const std::string& where, IsEnd&& is_end)
{
    for (NodeId at = scene_.node(node).parent; at && !is_end(at); at = scene_.node(at).parent) charge(1, where);
}

void SkinPaths::charge_joints(const std::vector<NodeId>& joints, const std::string& where)
{
    const std::unordered_set<NodeId> of_skin(joints.begin(), joints.end());
    for (const NodeId joint : joints) charge_path(joint, where, [&](NodeId at) { return of_skin.contains(at); });
}

void SkinPaths::charge_wearer(NodeId wearer, const std::vector<NodeId>& joints, const std::string& where)
{
    for (const NodeId from : {wearer, joints.front()}) charge_path(from, where, [](NodeId) { return false; });
    charge(joints.size(), where);
}

}  // namespace occam::import
