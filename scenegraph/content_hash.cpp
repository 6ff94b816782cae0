#include "scenegraph/content_hash.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <unordered_map>

#include "base/hash.h"

namespace occam {
namespace {

// What no segment of the shutter shows is left out, unless it is there in the middle: lights shine as they are then.
bool counts(const Node& node) noexcept { return node.is_visible_in_shutter() || node.visible; }

class Walk {
public:
    Walk(const Scene& scene, bool has_slots) : scene_(scene), has_slots_(has_slots) {}

    std::uint64_t hash()
    {
        const Environment& sky = scene_.environment;
        add(sky.radiance, sky.rotation);
        add_texture(sky.image);
        if (counts(scene_.node(scene_.root()))) refer(scene_.root());
        while (!todo_.empty()) {
            const NodeId id = todo_.back();
            todo_.pop_back();
            add_node(*scene_.find(id));
        }
        return hash_;
    }

private:
    void add_bytes(const void* bytes, std::size_t size)
    {
        const auto* from = static_cast<const unsigned char*>(bytes);
        constexpr std::size_t kLanes = 8;  // independent sums, so that no step waits for the one before
        if (size >= kLanes * sizeof(std::uint64_t)) {
            std::uint64_t lanes[kLanes] = {};
            for (; size >= sizeof lanes; from += sizeof lanes, size -= sizeof lanes)
                for (std::size_t k = 0; k < kLanes; ++k) {
                    std::uint64_t word;
                    std::memcpy(&word, from + k * sizeof word, sizeof word);
                    lanes[k] = mix_bits(lanes[k] ^ word) + sizeof word;
                }
            for (const std::uint64_t lane : lanes) hash_ = mix_bits(hash_ ^ lane);
        }
        for (; size > 0;) {
            std::uint64_t word = 0;
            const std::size_t count = std::min(size, sizeof word);
            std::memcpy(&word, from, count);
            hash_ = mix_bits(hash_ ^ word) + count;
            from += count;
            size -= count;
        }
    }
    void add_one(const std::string& text) { add_list(text); }
    template <class T>
    void add_one(const std::vector<T>& list)
    {
        add_list(list);
    }
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void add_one(const T& value) { add_bytes(&value, sizeof value); }
    // No member of a list and no single value has padding.
    template <class List>
    void add_list(const List& list)
    {
        add_one(std::uint64_t(list.size()));
        add_bytes(list.data(), list.size() * sizeof(*list.data()));
    }
    template <class... Values>
    void add(const Values&... values)
    {
        (add_one(values), ...);
    }

    // Each returns or adds the number of a thing in the order in which things are met; what is new is added at once, but
    // nodes wait. 0 stands for nothing.
    template <class Id>
    bool is_new(std::unordered_map<Id, std::uint64_t>& numbers, Id id, bool is_alive)
    {
        if (!is_alive) {
            add(std::uint64_t(0));
            return false;
        }
        const auto [entry, is_first] = numbers.try_emplace(id, numbers.size() + 1);
        add(entry->second);
        return is_first;
    }
    void refer(NodeId id)
    {
        if (!is_new(nodes_, id, scene_.find(id) != nullptr)) return;
        if (has_slots_) add(id.slot);
        todo_.push_back(id);
    }
    void add_texture(TextureId id)
    {
        const Texture* texture = scene_.find(id);
        if (!is_new(textures_, id, texture != nullptr)) return;
        add(texture->role, texture->path.string(), texture->pixels, texture->width, texture->height,
            std::uint8_t(scene_.is_cut_out_by(id)));
        if (texture->encoded) add(*texture->encoded);
    }
    void add_use(const TextureUse& use)
    {
        add_texture(use.texture);
        if (use.texture)
            add(use.uv_set, use.offset, use.scale, use.rotation, use.wrap_s, use.wrap_t, std::uint8_t(use.nearest));
    }
    void add_material(MaterialId id);
    void add_materials(const std::vector<MaterialId>& list)
    {
        add(std::uint64_t(list.size()));
        for (const MaterialId id : list) add_material(id);
    }
    void add_light(LightId id);
    void add_cage(CageId id);
    void add_cage(const Cage& cage);
    void add_skin(SkinId id)
    {
        const SkinSlot* skin = scene_.find(id);
        if (!is_new(skins_, id, skin != nullptr)) return;
        add(skin->mesh_poses, std::uint64_t(skin->key_poses.size()));
        for (const std::vector<Mat4d>& poses : skin->key_poses) add(poses);
    }
    void add_node(const Node& node);

    const Scene& scene_;
    const bool has_slots_;
    std::uint64_t hash_ = kFnvStart;
    std::vector<NodeId> todo_;
    std::unordered_map<NodeId, std::uint64_t> nodes_;
    std::unordered_map<CageId, std::uint64_t> cages_;
    std::unordered_map<MaterialId, std::uint64_t> materials_;
    std::unordered_map<TextureId, std::uint64_t> textures_;
    std::unordered_map<LightId, std::uint64_t> lights_;
    std::unordered_map<SkinId, std::uint64_t> skins_;
};

void Walk::add_material(MaterialId id)
{
    const Material* material = scene_.find(id);
    if (!is_new(materials_, id, material != nullptr)) return;
    const Material& m = *material;
    add(m.name, m.base_color, m.metallic, m.roughness, m.emission, m.normal_scale, m.bump_scale, m.occlusion_strength,
        m.alpha_mode, m.alpha_cutoff, std::uint8_t(m.double_sided), std::uint8_t(m.unlit), m.ior, m.transmission,
        m.thickness, m.attenuation_color, m.attenuation_distance, m.clearcoat, m.clearcoat_roughness,
        m.clearcoat_normal_scale, m.specular, m.specular_color, m.sheen_color, m.sheen_roughness, m.anisotropy,
        m.anisotropy_rotation);
    const auto uses = texture_uses(m);
    for (const TextureUse* use : uses) add_use(*use);
    static_assert(sizeof(TextureUse) == 36 &&
                      sizeof(Material) == sizeof(std::string) + std::tuple_size_v<decltype(uses)> * sizeof(TextureUse) + 140,
                  "every member of a material counts");
}

void Walk::add_light(LightId id)
{
    const Light* light = scene_.find(id);
    if (!is_new(lights_, id, light != nullptr)) return;
    add(light->groups, std::uint64_t(light->kind.index()));
    if (const auto* point = std::get_if<PointLight>(&light->kind))
        add(point->intensity, point->range, point->inner_angle, point->outer_angle);
    if (const auto* sun = std::get_if<SunLight>(&light->kind)) add(sun->irradiance);
    if (const auto* area = std::get_if<AreaLight>(&light->kind))
        add(area->shape, area->size, area->radiance, std::uint8_t(area->two_sided));
}

void Walk::add_cage(CageId id)
{
    const CageSlot* slot = scene_.find(id);
    if (!is_new(cages_, id, slot != nullptr)) return;
    add(std::uint8_t(slot->is_on_demand()), slot->bounds.lo, slot->bounds.hi, std::uint64_t(slot->key_positions.size()));
    for (const std::vector<Vec3f>& positions : slot->key_positions) add(positions);
    add_cage(slot->cage);
}

void Walk::add_cage(const Cage& cage)
{
    add(cage.name, cage.scheme, cage.boundary, cage.face_varying, cage.positions, cage.face_sizes, cage.face_vertices,
        cage.creases, cage.corners, cage.holes, cage.normals, cage.colors, cage.color_indices, cage.face_slots,
        cage.morph_weights, cage.skin.sets, cage.skin.joints, cage.skin.weights, std::uint64_t(cage.uv_sets.size()),
        std::uint64_t(cage.morph_targets.size()), std::uint8_t(cage.displacement.has_value()));
    for (const UvSet& set : cage.uv_sets) add(set.values, set.indices);
    for (const MorphTarget& target : cage.morph_targets) add(target.positions, target.normals);
    if (const auto& d = cage.displacement) {
        add_use(d->texture);
        add(d->scale, d->midlevel, d->bound, d->space);
    }
    add_materials(cage.materials);
}

void Walk::add_node(const Node& node)
{
    add(node.name, node.parent_from_node, std::uint8_t(node.visible), node.seen_by, node.lit_by, node.morph_weights,
        std::uint64_t(node.keys.size()));
    for (const NodeKey& key : node.keys) {
        add(key.parent_from_node, std::uint8_t(key.visible), key.morph_weights);
        if (scene_.find(node.skin)) add(key.node_from_skin);
    }
    add_skin(node.skin);
    if (scene_.find(node.skin)) add(node.node_from_skin);
    add_light(node.light);
    for (const CageId cage : node.cages)
        if (scene_.find(cage)) add_cage(cage);
    add(std::uint64_t(0));
    add_materials(node.materials);
    refer(node.instance_of);
    for (const NodeId child : node.children)
        if (const Node* below = scene_.find(child); below && counts(*below)) refer(child);
    add(std::uint64_t(0));
}

}  // namespace

std::uint64_t content_hash(const Scene& scene) { return Walk(scene, false).hash(); }
std::uint64_t content_and_slots_hash(const Scene& scene) { return Walk(scene, true).hash(); }

}  // namespace occam
