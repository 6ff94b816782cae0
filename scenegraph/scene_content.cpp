// Adds, replaces and removes what the nodes of a scene refer to: cages, materials, textures, lights, cameras and clips.
#include <algorithm>
#include <atomic>
#include <unordered_map>

#include "base/error_without_file.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/foreign_texture.h"
#include "scenegraph/large_parts.h"
#include "scenegraph/poles.h"
#include "scenegraph/scene_state.h"
#include "scenegraph/shown_nodes.h"

namespace occam {

namespace {

// Names an object in a message, by its handle if it has no name.
template <class Tag>
std::string named(const char* kind, const std::string& name, Handle<Tag> id)
{
    if (!name.empty()) return naming(kind, name);
    return kind + (" of slot " + std::to_string(id.slot)) + ", generation " + std::to_string(id.generation);
}
Error is_used(const std::string& what, const std::string& user)
{
    return error_without_file(what + " cannot be removed, because " + user + " uses it");
}

/// Repairs a cage. Returns the lines of sanitize(), each with the cage's name.
std::vector<std::string> repairs_of(Cage& cage)
{
    std::vector<std::string> lines = sanitize(cage);
    for (std::string& line : lines) line = (cage.name.empty() ? "cage" : cage.name) + ": " + line;
    return lines;
}

}  // namespace

std::uint64_t next_identity() noexcept
{
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

CageSlot CageSlot::made() const
{
    CageSlot slot;
    slot.id = id;
    slot.identity = identity;
    slot.bounds = bounds;
    slot.cage = make();
    slot.cage.name = cage.name;
    slot.cage.materials = cage.materials;  // first, since they decide which slots exist
    check(slot.cage);
    slot.repairs = repairs_of(slot.cage);
    if (slot.cage.skin.sets > 0 || !slot.cage.morph_targets.empty() || slot.cage.displacement)
        throw error_without_file("a cage made on demand has neither skin nor morph targets nor displacement",
                                 naming("cage", cage.name));
    slot.unused_vertices = find_unused_vertices(slot.cage);
    const Box3d box = box_of_used(slot, slot.cage.positions);
    if (!box.is_empty() && (glm::any(glm::lessThan(box.lo, bounds.lo)) || glm::any(glm::greaterThan(box.hi, bounds.hi))))
        throw error_without_file("a cage made on demand leaves its bounds", naming("cage", cage.name));
    slot.pole_faces = PoleFaces(slot.cage);
    find_poles(slot);
    return slot;
}

CageId Scene::add(OnDemandCage cage)
{
    state_->require_editable();
    const std::string where = naming("cage", cage.name);
    if (!cage.make) throw error_without_file("a cage on demand needs something that makes it", where);
    const auto is_number = [](const Vec3d& p) { return p == p; };
    const bool are_numbers = is_number(cage.bounds.lo) && is_number(cage.bounds.hi);
    if (are_numbers && cage.bounds.is_empty())
        throw error_without_file("the bounds of a cage made on demand are empty: no ray would ever make it", where);
    if (!are_numbers || !(cage.bounds.largest_coordinate() <= double(kMaxCoordinate)))
        throw error_without_file("a bound is not finite, or beyond 1e16", where);
    for (const MaterialId material : cage.materials)
        if (material) State::at(state_->materials, material, "material");
    State::CageRecord record;
    record.cage.name = std::move(cage.name);
    record.cage.materials = std::move(cage.materials);
    record.bounds = cage.bounds;
    record.make = std::move(cage.make);
    record.identity = next_identity();
    const CageId id = state_->cages.add(std::move(record));
    Rollback added([&] { state_->cages.remove(id); });
    state_->take_contents(id, *state_->cages.find(id));
    added.keep();
    return id;
}

void Scene::State::check_handles(const Material& material) const
{
    for (const TextureUse* use : texture_uses(material))
        if (use->texture) at(textures, use->texture, "texture");
}
void Scene::State::check_handles(const Cage& cage) const
{
    for (const MaterialId material : cage.materials)
        if (material) at(materials, material, "material");
    if (cage.displacement && cage.displacement->texture) at(textures, cage.displacement->texture.texture, "texture");
}

void Scene::State::make_record(Cage cage, CageRecord& record, std::vector<std::string>& warnings)
{
    check(cage);
    for (std::string& line : repairs_of(cage)) warnings.push_back(std::move(line));
    record.cage = std::move(cage);
    record.largest_face = 4;
    for (const std::uint32_t size : record.cage.face_sizes) record.largest_face = std::max(record.largest_face, size);
    record.derived_points = most_derived_points(record.cage);
    record.unused_vertices = find_unused_vertices(record.cage);
    record.identity = next_identity();
    record.pole_faces = PoleFaces(record.cage);
    find_bounds(record);
}

CageId Scene::add(Cage cage)
{
    state_->require_editable();
    state_->check_handles(cage);
    return add_with_foreign_texture(*this, std::move(cage));
}
CageId add_with_foreign_texture(Scene& scene, Cage cage)
{
    Scene::State& s = *scene.state_;
    Rollback warned([&, count = scene.warnings.size()] { scene.warnings.resize(count); });
    Scene::State::CageRecord record;
    Scene::State::make_record(std::move(cage), record, scene.warnings);
    const CageId id = s.cages.add(std::move(record));
    Rollback added([&] { s.cages.remove(id); });
    s.take_contents(id, *s.cages.find(id));
    s.count_faces(*s.cages.find(id), 1);
    warned.keep();
    added.keep();
    return id;
}
MaterialId Scene::add(Material material)
{
    state_->require_editable();
    check(material);
    state_->check_handles(material);
    State::MaterialRecord record;
    static_cast<Material&>(record) = std::move(material);
    const MaterialId id = state_->materials.add(std::move(record));
    Rollback added([&] { state_->materials.remove(id); });
    state_->watch_textures(id, *state_->materials.find(id));
    added.keep();
    return id;
}
TextureId Scene::add(Texture texture)
{
    state_->require_editable();
    check(texture);
    const std::uint64_t added = texture.identity = next_identity();
    return state_->textures.add({std::make_shared<Texture>(std::move(texture)), added, {}, {}});
}
LightId Scene::add(Light light)
{
    state_->require_editable();
    check(light);
    State::LightRecord record;
    static_cast<Light&>(record) = std::move(light);
    return state_->lights.add(std::move(record));
}
CameraId Scene::add(CameraLens lens)
{
    state_->require_editable();
    check(lens);
    State::CameraRecord record;
    static_cast<CameraLens&>(record) = lens;
    return state_->cameras.add(std::move(record));
}
ClipId Scene::add(Clip clip)
{
    state_->require_editable();
    check(clip);
    for (const Channel& channel : clip.channels) State::at(state_->nodes, channel.target, "node");
    state_->clip_order.emplace_back();
    Rollback added([&] { state_->clip_order.pop_back(); });
    const ClipId id = state_->clip_order.back() = state_->clips.add(std::move(clip));
    added.keep();
    return id;
}

void Scene::remove(CageId id)
{
    state_->require_unrecorded();
    State::CageRecord& record = State::at(state_->cages, id, "cage");
    state_->drop_keys(record);
    state_->mark_users_dirty(record);
    state_->count_faces(record, -1);
    state_->cages.remove(id);
}
// The lists of users may hold some that are no longer users.
void Scene::remove(MaterialId id)
{
    state_->require_editable();
    const State::MaterialRecord& material = State::at(state_->materials, id, "material");
    const auto names_it = [&](const std::vector<MaterialId>& list) {
        return std::find(list.begin(), list.end(), id) != list.end();
    };
    const auto refuse = [&](const std::string& user) { throw is_used(named("material", material.name, id), user); };
    for (const NodeId user : material.users.ids())
        if (const Node* node = find(user); node && names_it(node->materials)) refuse(named("node", node->name, user));
    for (const CageId user : material.cages.ids())
        if (const CageSlot* slot = find(user); slot && names_it(slot->cage.materials))
            refuse(named("cage", slot->cage.name, user));
    state_->materials.remove(id);
}
void Scene::remove(TextureId id)
{
    state_->require_editable();
    const State::TextureRecord& texture = State::at(state_->textures, id, "texture");
    const auto is_it = [&](const TextureUse* use) { return use->texture == id; };
    const auto refuse = [&](const std::string& user) { throw is_used(named("texture", texture.texture->name, id), user); };
    if (environment.image == id) refuse("the environment");
    for (const MaterialId user : texture.materials.ids()) {
        const Material* material = find(user);
        if (!material) continue;
        const auto uses = texture_uses(*material);
        if (std::any_of(uses.begin(), uses.end(), is_it)) refuse(named("material", material->name, user));
    }
    for (const CageId user : texture.cages.ids())
        if (const CageSlot* slot = find(user); slot && slot->cage.displacement && is_it(&slot->cage.displacement->texture))
            refuse(named("cage", slot->cage.name, user));
    state_->textures.remove(id);
}
void Scene::remove(LightId id)
{
    state_->require_editable();
    const auto has_it = [&](NodeId node) { return find(node) && find(node)->light == id; };
    for (const NodeId user : State::at(state_->lights, id, "light").users.those_that(has_it)) state_->mark_dirty(user);
    state_->lights.remove(id);
}
void Scene::remove(CameraId id)
{
    state_->require_editable();
    State::at(state_->cameras, id, "camera");
    state_->cameras.remove(id);
}
void Scene::remove(ClipId id)
{
    state_->require_editable();
    State::at(state_->clips, id, "clip");
    std::erase(state_->clip_order, id);
    state_->clips.remove(id);
}

const CageSlot& Scene::cage(CageId id) const { return State::at(state_->cages, id, "cage"); }
const Material& Scene::material(MaterialId id) const { return State::at(state_->materials, id, "material"); }
const Texture& Scene::texture(TextureId id) const { return *State::at(state_->textures, id, "texture").texture; }
const Light& Scene::light(LightId id) const { return State::at(state_->lights, id, "light"); }
const CameraLens& Scene::camera_lens(CameraId id) const { return State::at(state_->cameras, id, "camera"); }
const Clip& Scene::clip(ClipId id) const { return State::at(state_->clips, id, "clip"); }

void Scene::write_vertices(CageId id, std::span<const Vec3f> positions)
{
    state_->require_editable();
    State::CageRecord& record = State::at(state_->cages, id, "cage");
    const auto where = [&] { return naming("cage", record.cage.name); };
    if (record.is_on_demand()) throw error_without_file("a cage made on demand has no vertices to write", where());
    if (positions.size() != record.cage.positions.size())
        throw error_without_file(
            "write_vertices needs as many positions as the cage has",
            where() + ": " + std::to_string(positions.size()) + " for " + std::to_string(record.cage.positions.size()));
    for (Vec3f p : positions)
        if (!is_usable(p)) throw error_without_file("a position is not finite, or beyond 1e16", where());
    // The positions may be the cage's own: at a key of its shutter, which is dropped now, or those that are written.
    std::vector<Vec3f> own;
    if (!record.key_positions.empty() || positions.data() == record.cage.positions.data()) {
        own.assign(positions.begin(), positions.end());
        positions = own;
    }
    state_->about_to_write(id, record);
    // The bounds of a cage that is deformed need memory, which may be missing.
    std::vector<Vec3f> before;
    if (record.is_deformed()) before = record.cage.positions;
    Rollback written([&] {
        if (!before.empty()) record.cage.positions = std::move(before);
    });
    record.cage.positions.assign(positions.begin(), positions.end());
    find_bounds(record);
    written.keep();
    record.layers.measure(record.cage);
    state_->sum_up_materials(record);
    ++record.positions_version;
    state_->mark_users_dirty(record);
}

void Scene::replace(CageId id, Cage cage)
{
    state_->require_unrecorded();
    State::CageRecord& record = State::at(state_->cages, id, "cage");
    state_->check_handles(cage);
    Rollback warned([&, count = warnings.size()] { warnings.resize(count); });
    State::CageRecord fresh;
    State::make_record(std::move(cage), fresh, warnings);
    state_->take_contents(id, fresh);
    warned.keep();
    state_->drop_keys(record);
    state_->count_faces(record, -1);
    fresh.users = std::move(record.users);
    record = std::move(fresh);
    state_->count_faces(record, 1);
    state_->mark_users_dirty(record);
}
void Scene::replace(MaterialId id, Material material)
{
    state_->require_editable();
    State::MaterialRecord& known = State::at(state_->materials, id, "material");
    check(material);
    state_->check_handles(material);
    state_->watch_textures(id, material);
    const Contents::Kinds kinds = kinds_of(known);
    static_cast<Material&>(known) = std::move(material);
    if (kinds_of(known) != kinds) state_->mark_users_dirty(known);
}
void Scene::replace(TextureId id, Texture texture)
{
    state_->require_editable();
    State::TextureRecord& known = State::at(state_->textures, id, "texture");
    check(texture);
    texture.identity = next_identity();
    known.texture = std::make_shared<Texture>(std::move(texture));
}
void Scene::replace(LightId id, Light light)
{
    state_->require_editable();
    State::LightRecord& known = State::at(state_->lights, id, "light");
    check(light);
    static_cast<Light&>(known) = std::move(light);
}
void Scene::replace(CameraId id, CameraLens lens)
{
    state_->require_editable();
    CameraLens& known = State::at(state_->cameras, id, "camera");
    check(lens);
    known = lens;
}

const Node* Scene::find(NodeId id) const noexcept { return state_->nodes.find(id); }
const CageSlot* Scene::find(CageId id) const noexcept { return state_->cages.find(id); }
const Material* Scene::find(MaterialId id) const noexcept { return state_->materials.find(id); }
const Texture* Scene::find(TextureId id) const noexcept { return share(id).get(); }
const Light* Scene::find(LightId id) const noexcept { return state_->lights.find(id); }
const std::vector<ClipId>& Scene::clips() const noexcept { return state_->clip_order; }

std::vector<TextureId> Scene::texture_ids() const
{
    std::vector<std::pair<std::uint64_t, TextureId>> found;
    const State& s = *state_;
    s.textures.for_each([&](TextureId id, const State::TextureRecord& record) { found.emplace_back(record.added, id); });
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<TextureId> ids;
    for (const auto& [added, id] : found) ids.push_back(id);
    return ids;
}

Scene::Counts Scene::counts() const
{
    const State& s = *state_;
    return {.nodes = s.nodes.size(),
            .cages = s.cages.size(),
            .faces = s.faces,
            .lights = s.lights.size(),
            .cameras = s.cameras.size(),
            .materials = s.materials.size(),
            .textures = s.textures.size(),
            .clips = s.clips.size(),
            .skins = s.skins.size(),
            .mesh_triangles = s.mesh_triangles};
}

std::size_t Scene::placed_faces() const
{
    std::unordered_map<NodeId, double> known;
    double all = 0;
    for_each_shown_node_bottom_up(*this, [&](NodeId id, const Node& node) {
        double faces = 0;
        for (const CageId cage : node.cages)
            if (const CageSlot* slot = find(cage)) faces += double(slot->cage.face_count());
        for_each_shown_below(*this, node, [&](NodeId part) { faces += known.at(part); });
        known[id] = all = faces;  // the root comes last
    });
    return all < 0x1p63 ? static_cast<std::size_t>(all) : ~std::size_t(0);
}

Scene::FrameLock::FrameLock(const Scene& scene) : scene_(scene)
{
    scene_.state_->frames.fetch_add(1, std::memory_order_acq_rel);
}
Scene::FrameLock::~FrameLock() { scene_.state_->frames.fetch_sub(1, std::memory_order_acq_rel); }

}  // namespace occam
