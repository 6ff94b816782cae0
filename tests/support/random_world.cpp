#include "tests/support/random_world.h"

#include "tests/support/made_cages.h"

namespace occam::test {
namespace {

Material random_material(CaseRandom& random, Scene& scene)
{
    Material material;
    material.base_color = Vec4f(random.color(), 1);
    material.roughness = float(random.number());
    material.metallic = random.number() < 0.3;
    material.clearcoat = random.number() < 0.3;
    if (random.number() < 0.2) material.emission = random.color();
    if (random.number() < 0.1) material.alpha_mode = AlphaMode::Blend, material.base_color.w = 0.5f;
    if (random.number() < 0.4) {
        Texture checks;
        checks.width = checks.height = 8;
        for (int k = 0; k < 64; ++k) checks.pixels.push_back(Vec4f(random.color(), float(random.number())));
        material.base_color_texture.texture = scene.add(std::move(checks));
        if (random.number() < 0.3) material.alpha_mode = AlphaMode::Mask;
    }
    return material;
}

/// Removes something; it stays if it is in use.
template <class Id>
void remove_if_unused(Scene& scene, Id id)
{
    try {
        scene.remove(id);
    } catch (const Error&) {
    }
}

/// Removes the textures that are not in use, and gives one of the others new texels.
const char* edit_textures(CaseRandom& random, Scene& scene)
{
    for (const TextureId id : scene.texture_ids()) remove_if_unused(scene, id);
    const std::vector<TextureId> left = scene.texture_ids();
    if (left.empty()) return "textures removed";
    Texture other;
    other.width = other.height = 8;
    for (int k = 0; k < 64; ++k) other.pixels.push_back(Vec4f(random.color(), 0.5f + 0.5f * float(k % 2)));
    scene.replace(left[random.index(left.size())], std::move(other));
    return "textures";
}

/// Returns a clip in which the object's node moves along two straight lines, and the joint that bends the object turns; if
/// it has none, its node turns.
Clip random_clip(CaseRandom& random, const AddedPart& object)
{
    Clip clip;
    Channel goes{.target = object.node, .times = {0, 1, 3}, .values = {}};
    for (int k = 0; k < 3; ++k) {
        const Vec3d at = random.inside_cube() * 2.0;
        goes.values.insert(goes.values.end(), {float(at.x), float(at.y), float(at.z)});
    }
    clip.channels.push_back(std::move(goes));
    Channel turns;
    turns.target = object.joint ? object.joint : object.node;
    turns.path = Channel::Path::Rotation;
    turns.interpolation = random.number() < 0.3 ? Channel::Interpolation::Step : Channel::Interpolation::Linear;
    turns.times = {0, 2};
    turns.values = {0, 0, 0, 1, 0, 0.6f, 0, 0.8f};
    turns.width = 4;
    clip.channels.push_back(std::move(turns));
    return clip;
}

}  // namespace

RandomWorld::RandomWorld(std::uint64_t seed) : seed_(seed)
{
    for (int k = 0; k < 3; ++k) ++step_, add_object();
    RandomCase lit = part_case();
    lit.settings = 0;
    light(scene_, lit, Vec3d(0));
}

RandomCase RandomWorld::part_case() const
{
    RandomCase c = random_case(seed_ * 1000 + step_);
    c.parts.resize(1);
    RandomPart& part = c.parts[0];
    for (const PartFeature f : {PartFeature::Large, PartFeature::Small, PartFeature::Body, PartFeature::Glass})
        part.remove(f);
    // A new renderer would take half a minute for the limit surface of its creased faces, each of which has 720 neighbours.
    if (part.cage == "pole_360") part.remove(PartFeature::Creases);
    c.remove(SettingFeature::Far);
    return c;
}

RandomCase RandomWorld::picture_case() const
{
    RandomCase c = random_case(seed_ * 77 + step_);
    for (const SettingFeature f : {SettingFeature::Shutter, SettingFeature::Layers, SettingFeature::Far}) c.remove(f);
    return c;
}

void RandomWorld::add_object()
{
    const RandomCase c = part_case();
    objects_.push_back(add_part(scene_, c, c.parts[0]));
}

AddedPart* RandomWorld::any_object(CaseRandom& random)
{
    return objects_.empty() ? nullptr : &objects_[random.index(objects_.size())];
}

const char* RandomWorld::edit_object(CaseRandom& random, const AddedPart& object)
{
    const CageId cage = object.cage;
    switch (random.index(6)) {
        case 0: {
            std::vector<Vec3f> moved = scene_.cage(cage).cage.positions;
            const Vec3d way = random.inside_cube() * 0.2;
            for (Vec3f& p : moved) p += Vec3f(way) * (1 + p.y);
            scene_.write_vertices(cage, moved);
            return "vertices";
        }
        case 1: {
            const std::vector<MadeCage> all = made_cages();
            Cage other = all[random.index(all.size())].cage;
            other.materials = scene_.cage(cage).cage.materials;
            if (random.number() < 0.5) {
                MorphTarget grown;
                for (const Vec3f& p : other.positions) grown.positions.push_back(p * 0.3f * p.y);
                other.morph_targets = {std::move(grown)};
                other.morph_weights = {0.5f};
            }
            scene_.set_skin(object.node, {});
            scene_.replace(cage, std::move(other));
            return "topology";
        }
        case 2: {
            const MaterialId material = scene_.cage(cage).cage.materials.at(0);
            scene_.replace(material, random_material(random, scene_));
            return "material";
        }
        case 3:
            scene_.set_morph_weights(object.node, {float(random.between(-1, 2))});
            return "morph weight";
        case 4: {
            if (!object.joint) return "nothing";
            const Trs turned = random_place(random);
            scene_.set_transform(object.joint, object.place * turned.matrix());
            return "joint";
        }
        default: {
            const std::vector<MaterialId> before = scene_.node(object.node).materials;
            scene_.set_materials(object.node, {scene_.add(random_material(random, scene_))});
            for (const MaterialId material : before) remove_if_unused(scene_, material);
            return "materials of a node";
        }
    }
}

const char* RandomWorld::edit_nodes(CaseRandom& random, AddedPart& object)
{
    const NodeId node = object.node;
    switch (random.index(8)) {
        case 0:
            scene_.set_transform(node, random_place(random));
            return "place";
        case 1:
            scene_.set_visible(node, !scene_.node(node).visible);
            return "visible";
        case 2:
            scene_.set_seen_by(node, random.number() < 0.5 ? RayKind::All : RayKind::Camera);
            return "seen by";
        case 3: {
            NodeDesc instance;
            instance.instance_of = node;
            instance.place = random_place(random);
            copies_.push_back(scene_.add_node(scene_.root(), instance));
            return "instance";
        }
        case 4:
            copies_.push_back(scene_.copy(node, scene_.root()));
            return "copy";
        case 5:
            if (copies_.empty()) return "nothing";
            scene_.remove(copies_.back());
            copies_.pop_back();
            return "copy removed";
        case 6:
            scene_.set_lit_by(node, random.number() < 0.5 ? kAllGroups : LightGroups(1 + random.index(3)));
            return "lit by";
        default: {
            const bool goes = random.number() < 0.5;
            const std::vector<MaterialId> before = scene_.cage(object.cage).cage.materials;
            scene_.remove(node);
            if (goes) scene_.remove(object.cage);
            for (const MaterialId material : before) remove_if_unused(scene_, material);
            return "object removed";
        }
    }
}

const char* RandomWorld::edit_links(CaseRandom& random, const AddedPart& object)
{
    const AddedPart& other = *any_object(random);
    const NodeId moved = object.joint && random.number() < 0.3 ? object.joint : object.node;
    try {
        switch (random.index(4)) {
            case 0: {
                const bool is_copy = !copies_.empty() && random.number() < 0.3;
                scene_.set_parent(moved, is_copy ? copies_.back() : other.node);
                return "parent";
            }
            case 1:
                scene_.set_parent(moved, scene_.root());
                return "root as parent";
            case 2:
                if (random.number() < 0.5) scene_.set_cages(object.node, {object.cage, other.cage});
                else scene_.set_cages(object.node, {object.cage});
                return "cages of a node";
            default:
                if (copies_.empty()) return "nothing";
                scene_.set_instance_of(copies_.back(), random.number() < 0.7 ? other.node : NodeId());
                return "another instance";
        }
    } catch (const Error&) {
        return "a circle is refused";
    }
}

void RandomWorld::forget_removed()
{
    std::erase_if(objects_, [&](const AddedPart& object) { return !scene_.find(object.node); });
    for (AddedPart& object : objects_)
        if (object.joint && !scene_.find(object.joint)) object.joint = {};
    std::erase_if(copies_, [&](NodeId id) { return !scene_.find(id); });
}

const char* RandomWorld::edit_light(CaseRandom& random)
{
    switch (random.index(4)) {
        case 0: {
            NodeDesc lamp;
            lamp.place = random_place(random);
            lamp.light = scene_.add(random_light(random));
            lights_.push_back(lamp.light);
            scene_.add_node(scene_.root(), lamp);
            return "lamp";
        }
        case 1:
            if (lights_.empty()) return "nothing";
            {
                Light other = random_light(random);
                other.groups = random.number() < 0.5 ? kAllGroups : LightGroups(1 + random.index(3));
                scene_.replace(lights_.back(), std::move(other));
            }
            return "light";
        case 2:
            if (lights_.empty()) return "nothing";
            scene_.remove(lights_.back());
            lights_.pop_back();
            return "light removed";
        default: {
            scene_.environment.radiance = random.color();
            if (random.number() < 0.5) scene_.environment.radiance = Vec3f(0);
            Texture sky;
            sky.width = sky.height = 4;
            for (int k = 0; k < 16; ++k) sky.pixels.push_back(Vec4f(random.color() * (k == 5 ? 20.0f : 1.0f), 1));
            scene_.environment.image = random.number() < 0.5 ? scene_.add(std::move(sky)) : TextureId();
            return "environment";
        }
    }
}

const char* RandomWorld::edit_shutter(CaseRandom& random)
{
    if (random.number() < 0.4) {
        scene_.clear_shutter();
        return "shutter cleared";
    }
    scene_.record_shutter(1 << random.index(3), [&](double tau) {
        for (const AddedPart& object : objects_) {
            // move_part() would bend the vertices that the cage had at first.
            Trs moves;
            moves.translation = Vec3d(0.4 * tau, 0, -0.2 * tau);
            if (object.part.has(PartFeature::Moving) || object.part.has(PartFeature::Creases))
                scene_.set_transform(object.node, object.place * moves.matrix());
        }
    });
    return "shutter";
}

const char* RandomWorld::edit_clips(CaseRandom& random, const AddedPart& object)
{
    if (random.number() < 0.4 || scene_.clips().empty()) {
        scene_.add(random_clip(random, object));
        return "clip";
    }
    const std::vector<ClipId>& clips = scene_.clips();
    std::vector<ClipAt> now;
    for (std::size_t n = random.index(3); n > 0; --n) {
        const ClipId clip = clips[random.index(clips.size())];
        const double seconds = random.between(-0.5, 3.5);
        now.push_back({clip, seconds, random.number()});
    }
    scene_.pose(now);
    return "pose";
}

const char* RandomWorld::edit()
{
    const char* what = make_edit();
    forget_removed();
    return what;
}

const char* RandomWorld::make_edit()
{
    ++step_;
    CaseRandom random(seed_, step_, 300);
    const std::size_t kind = random.index(17);
    AddedPart* const object = any_object(random);
    if (kind == 0 || !object) {
        add_object();
        return "object";
    }
    if (kind < 4) return edit_object(random, *object);
    if (kind < 8) return edit_nodes(random, *object);
    if (kind == 8) return edit_light(random);
    if (kind == 9) return edit_shutter(random);
    if (kind == 14) return edit_textures(random, scene_);
    if (kind > 14) return edit_links(random, *object);
    return kind < 12 ? edit_clips(random, *object) : groups_.edit(scene_, random, object->node);
}

Settings RandomWorld::settings() const
{
    Settings settings = settings_of(picture_case());
    if (scene_.shutter_segments() > 0) settings.shutter = {0, 0.5};
    return settings;
}

Camera RandomWorld::camera() { return camera_of(picture_case(), scene_); }

}  // namespace occam::test
