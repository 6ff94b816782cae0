// What a Scene keeps: the tables behind its handles, and who uses what, so that an edit knows which bounds it touches.
#pragma once

#include "scenegraph/base/error.h"
#include "scenegraph/base/handle.h"
#include "scenegraph/scene.h"

namespace occam {

/// Nodes to be told about an edit. Removed nodes are forgotten when the list would grow, so that it stays in
/// proportion to the nodes alive at one time.
class Watchers {
public:
    template <class IsAlive>
    void add(NodeId id, IsAlive&& is_alive)
    {
        if (ids_.size() == ids_.capacity()) std::erase_if(ids_, [&](NodeId known) { return !is_alive(known); });
        ids_.push_back(id);
    }
    const std::vector<NodeId>& ids() const noexcept { return ids_; }

private:
    std::vector<NodeId> ids_;
};

struct Scene::State {
    struct NodeRecord : Node {
        Watchers instances;  ///< nodes whose instance_of is this one
    };
    struct CageRecord : CageSlot {
        Watchers users;
    };

    SlotMap<NodeRecord, NodeTag> nodes;
    SlotMap<CageRecord, CageTag> cages;
    SlotMap<Material, MaterialTag> materials;
    SlotMap<Texture, TextureTag> textures;
    SlotMap<Light, LightTag> lights;
    SlotMap<CameraLens, CameraTag> cameras;
    SlotMap<Skin, SkinTag> skins;
    SlotMap<Clip, ClipTag> clips;
    std::vector<ClipId> clip_order;
    NodeId root;
    mutable std::atomic<int> frames{0};  ///< FrameLocks alive

    void require_editable() const
    {
        if (frames.load(std::memory_order_acquire) > 0) throw Error("", "the scene is being rendered: edits have to wait");
    }
    /// The value of a live handle; throws Error otherwise.
    template <class T, class Tag>
    static T& at(SlotMap<T, Tag>& map, Handle<Tag> id, const char* kind)
    {
        if (T* value = map.find(id)) return *value;
        throw Error("", std::string("dead or foreign handle of a ") + kind,
                    id ? "slot " + std::to_string(id.slot) + ", generation " + std::to_string(id.generation) : "no handle");
    }
    template <class T, class Tag>
    static const T& at(const SlotMap<T, Tag>& map, Handle<Tag> id, const char* kind)
    {
        return at(const_cast<SlotMap<T, Tag>&>(map), id, kind);
    }

    /// Marks the node, its ancestors, and all that show one of them as an instance. Stops at what is dirty already: what
    /// lies above that is dirty too.
    void mark_dirty(NodeId id);
    void mark_users_dirty(const CageRecord& cage);
    /// True if `below` lies in what `above` shows, or is `above`.
    bool is_shown_by(NodeId below, NodeId above) const;
    void refit_node(NodeRecord& node) const;
};

}  // namespace occam
