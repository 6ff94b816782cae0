// Adds one scene to another: what the part holds is moved, and refers to its new handles.
#include <algorithm>
#include <filesystem>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/error_without_file.h"
#include "scenegraph/scene_state.h"

namespace occam {
namespace {

// The new handles of what was moved.
template <class Tag>
class NewHandles {
public:
    using Id = Handle<Tag>;

    /// Returns the new handle, or a null handle for what the part did not hold.
    Id of(Id old) const
    {
        const auto found = new_of_.find(old);
        return found == new_of_.end() ? Id() : found->second;
    }
    void replace(Id& id) const { id = of(id); }
    void replace(std::vector<Id>& ids) const
    {
        for (Id& id : ids) replace(id);
    }
    /// Calls make() for the new handle of `old`, and knows it from then on.
    template <class Make>
    Id add(Id old, Make&& make)
    {
        Id& made = new_of_[old];  // first, so that nothing is made that is not known
        return made = make();
    }
    template <class Visit>
    void for_each(Visit&& visit) const
    {
        for (const auto& [old, made] : new_of_)
            if (made) visit(made);
    }
    std::vector<Id> all() const
    {
        std::vector<Id> found;
        for_each([&](Id id) { found.push_back(id); });
        std::sort(found.begin(), found.end(), [](Id a, Id b) { return a.slot < b.slot; });
        return found;
    }

private:
    std::unordered_map<Id, Id> new_of_;
};

}  // namespace

// One addition: each function moves one kind of object from the part, after those that it refers to.
class Scene::State::Addition {
public:
    Addition(Scene& to, Scene& part) : scene_(to), part_scene_(part), to_(*to.state_), part_(*part.state_) {}

    void move_textures()
    {
        for (const TextureId old : part_scene_.texture_ids())
            textures_.add(old, [&] {
                // Renderers know it by its old identity, and one that has not decoded it yet keeps it as it is.
                const std::shared_ptr<Texture>& known = part_.textures.find(old)->texture;
                const bool is_shared = known.use_count() > 1;
                auto texture = is_shared ? std::make_shared<Texture>(*known) : std::make_shared<Texture>(std::move(*known));
                const std::uint64_t added = texture->identity = next_identity();
                return to_.textures.add({std::move(texture), added, {}, {}});
            });
    }
    void move_materials()
    {
        part_.materials.for_each([&](MaterialId old, MaterialRecord& from) {
            MaterialRecord record;
            static_cast<Material&>(record) = std::move(from);
            for (TextureUse* use : texture_uses(record)) textures_.replace(use->texture);
            const MaterialId made = materials_.add(old, [&] { return to_.materials.add(std::move(record)); });
            to_.watch_textures(made, *to_.materials.find(made));
        });
    }
    void move_cages()
    {
        part_.cages.for_each([&](CageId old, CageRecord& from) {
            CageRecord record;
            static_cast<CageSlot&>(record) = std::move(from);
            materials_.replace(record.cage.materials);
            if (record.cage.displacement) textures_.replace(record.cage.displacement->texture.texture);
            const CageId made = cages_.add(old, [&] { return to_.cages.add(std::move(record)); });
            CageRecord& moved = *to_.cages.find(made);
            to_.count_faces(moved, 1);
            to_.take_contents(made, moved);
        });
    }
    void move_lights_and_cameras()
    {
        part_.lights.for_each([&](LightId old, LightRecord& from) {
            LightRecord record;
            static_cast<Light&>(record) = std::move(from);
            lights_.add(old, [&] { return to_.lights.add(std::move(record)); });
        });
        part_.cameras.for_each([&](CameraId old, const CameraRecord& from) {
            CameraRecord record;
            static_cast<CameraLens&>(record) = from;
            cameras_.add(old, [&] { return to_.cameras.add(std::move(record)); });
        });
    }
    void move_nodes(NodeId parent)
    {
        std::vector<NodeId> originals = part_.subtree_to_copy(part_.root, part_.root);
        for (const NodeId old : originals) {
            const NodeRecord& from = *part_.nodes.find(old);
            NodeDesc desc = part_.desc_of_copy(old);
            desc.place = from.place;
            desc.matrix = from.matrix;
            desc.morph_weights = from.morph_weights;
            cages_.replace(desc.cages);
            materials_.replace(desc.materials);
            lights_.replace(desc.light);
            cameras_.replace(desc.camera);
            const NodeId above = old == part_.root ? parent : nodes_.of(from.parent);
            nodes_.add(old, [&] { return scene_.add_node(above, std::move(desc)); });
        }
        for (const NodeId old : originals) {
            NodeRecord& from = *part_.nodes.find(old);
            if (const NodeId shown = nodes_.of(from.instance_of)) to_.show_instance(nodes_.of(old), shown);
            const NodeId first = node_or_dead(from.first_original);
            NodeRecord& record = *to_.nodes.find(nodes_.of(old));
            record.first_original = first;
            record.rest = std::move(from.rest);
        }
        // What was added first is found first.
        std::sort(originals.begin(), originals.end(),
                  [&](NodeId a, NodeId b) { return part_.nodes.find(a)->added < part_.nodes.find(b)->added; });
        for (const NodeId old : originals) to_.nodes.find(nodes_.of(old))->added = next_identity();
    }
    void move_skins()
    {
        part_.skins.for_each([&](SkinId old, SkinRecord& from) {
            Skin skin = std::move(from.skin);
            for (NodeId& joint : skin.joints) joint = node_or_dead(joint);
            skins_.add(old, [&] { return to_.add_skin(std::move(skin)); });
        });
        part_.nodes.for_each([&](NodeId old, const NodeRecord& from) {
            if (const SkinId skin = skins_.of(from.skin)) scene_.set_skin(nodes_.of(old), skin);
        });
    }
    void move_poses()
    {
        for (const auto& [old, from] : part_.posed) {
            Posed& own = to_.posed[nodes_.of(old)];  // a null handle stands for the scene itself
            for (const auto& [original, made] : from.node_of) own.node_of[node_or_dead(original)] = node_or_dead(made);
            for (const SkinId skin : from.skins) own.skins.push_back(skins_.of(skin));
            move_moved(from, own);
        }
        // Its clips move its own nodes, whether the whole scene is posed or the part alone.
        Posed& alone = to_.posed[node()];
        nodes_.for_each([&](NodeId made) { alone.node_of[made] = made; });
        if (const auto from = part_.posed.find(NodeId()); from != part_.posed.end()) move_moved(from->second, alone);
    }
    std::vector<ClipId> move_clips()
    {
        std::vector<ClipId> made;
        for (const ClipId old : part_.clip_order) {
            Clip clip = std::move(*part_.clips.find(old));
            for (Channel& channel : clip.channels) channel.target = node_or_dead(channel.target);
            to_.clip_order.emplace_back();
            to_.clip_order.back() = clips_.add(old, [&] { return to_.clips.add(std::move(clip)); });
            made.push_back(to_.clip_order.back());
        }
        return made;
    }
    NodeId node() const { return nodes_.of(part_.root); }
    AddedScene all(std::vector<ClipId> made_clips) const
    {
        AddedScene added{.node = node(),
                         .clips = std::move(made_clips),
                         .environment = part_scene_.environment,
                         .cages = cages_.all(),
                         .materials = materials_.all(),
                         .textures = textures_.all(),
                         .lights = lights_.all(),
                         .cameras = cameras_.all(),
                         .skins = skins_.all()};
        textures_.replace(added.environment.image);
        return added;
    }

    /// Removes what was moved so far.
    void undo() noexcept
    {
        clips_.for_each([&](ClipId id) { to_.clips.remove(id); });
        std::erase_if(to_.clip_order, [&](ClipId id) { return !to_.clips.find(id); });
        if (const NodeId top = node()) scene_.remove(top);
        skins_.for_each([&](SkinId id) { to_.skins.remove(id); });
        cameras_.for_each([&](CameraId id) { to_.cameras.remove(id); });
        lights_.for_each([&](LightId id) { to_.lights.remove(id); });
        cages_.for_each([&](CageId id) {
            if (const CageRecord* cage = to_.cages.find(id)) to_.count_faces(*cage, -1);
            to_.cages.remove(id);
        });
        materials_.for_each([&](MaterialId id) { to_.materials.remove(id); });
        textures_.for_each([&](TextureId id) { to_.textures.remove(id); });
    }

private:
    /// Adds what the last pose() moved.
    void move_moved(const Posed& from, Posed& to) const
    {
        for (const NodeId node : from.placed)
            if (nodes_.of(node)) to.placed.push_back(nodes_.of(node));
        for (const NodeId node : from.weighted)
            if (nodes_.of(node)) to.weighted.push_back(nodes_.of(node));
    }
    /// Returns the new handle of a node. A removed node has a new dead handle, since clips know the copies of a node by it.
    NodeId node_or_dead(NodeId old)
    {
        if (const NodeId known = nodes_.of(old); known || !old) return known;
        if (const NodeId known = dead_.of(old)) return known;
        return dead_.add(old, [&] {
            const NodeId made = to_.nodes.add({});
            to_.nodes.remove(made);
            return made;
        });
    }

    Scene& scene_;
    Scene& part_scene_;
    State& to_;
    State& part_;
    NewHandles<TextureTag> textures_;
    NewHandles<MaterialTag> materials_;
    NewHandles<CageTag> cages_;
    NewHandles<LightTag> lights_;
    NewHandles<CameraTag> cameras_;
    NewHandles<NodeTag> nodes_, dead_;
    NewHandles<SkinTag> skins_;
    NewHandles<ClipTag> clips_;
};

namespace {

/// Appends those files that are not listed yet, so that parts which come and go do not make the list longer without end.
void add_files(std::vector<std::filesystem::path>& files, const std::vector<std::filesystem::path>& more)
{
    files.reserve(files.size() + more.size());  // the paths that are known by reference stay in their places
    std::unordered_set<std::string_view> known;
    for (const std::filesystem::path& file : files) known.insert(file.native());
    for (const std::filesystem::path& file : more)
        if (!known.contains(file.native())) known.insert(files.emplace_back(file).native());
}

}  // namespace

AddedScene Scene::add(Scene&& other, NodeId parent)
{
    if (!state_ || !other.state_) throw error_without_file("a scene that was moved from cannot be added");
    if (this == &other) throw error_without_file("a scene cannot be added to itself");
    state_->require_unrecorded();
    other.state_->require_unrecorded();
    State::at(state_->nodes, parent, "node");
    Scene part = std::move(other);
    part.clear_shutter();

    State::Addition addition(*this, part);
    Rollback added([&, lines = warnings.size(), choices = notes.size(), read = files.size()] {
        addition.undo();
        warnings.resize(lines);
        notes.resize(choices);
        files.resize(read);
    });
    addition.move_textures();
    addition.move_materials();
    addition.move_cages();
    addition.move_lights_and_cameras();
    addition.move_nodes(parent);
    addition.move_skins();
    addition.move_poses();
    AddedScene made = addition.all(addition.move_clips());
    warnings.insert(warnings.end(), part.warnings.begin(), part.warnings.end());
    notes.insert(notes.end(), part.notes.begin(), part.notes.end());
    add_files(files, part.files);
    added.keep();
    return made;
}

void Scene::remove(const AddedScene& part)
{
    state_->require_unrecorded();
    const auto remove_all = [&](const auto& ids, const auto& table) {
        for (const auto id : ids)
            if (table.find(id)) remove(id);
    };
    if (find(part.node)) remove(part.node);
    remove_all(part.clips, state_->clips);
    remove_all(part.skins, state_->skins);
    remove_all(part.cages, state_->cages);
    remove_all(part.lights, state_->lights);
    remove_all(part.cameras, state_->cameras);
    const auto remove_unused = [&](const auto& ids, const auto& table) {
        for (const auto id : ids) {
            try {
                if (table.find(id)) remove(id);
            } catch (const Error&) {           // something else uses it
            } catch (const std::bad_alloc&) {  // the same, without memory to say so
            }
        }
    };
    remove_unused(part.materials, state_->materials);
    remove_unused(part.textures, state_->textures);
}

}  // namespace occam
