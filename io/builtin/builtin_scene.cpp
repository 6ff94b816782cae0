#include "io/builtin/builtin_scene.h"

#include "base/maths.h"
#include "io/builtin/panelled_ball.h"
#include "io/builtin/pieces.h"
#include "io/builtin/shapes.h"
#include "io/builtin/textures.h"

namespace occam {
namespace {

using namespace builtin;

/// Returns the rotation about `axis` (a unit vector) by an angle in radians.
Vec4d turn(Vec3d axis, float angle) { return {axis * double(maths::sin(angle / 2)), double(maths::cos(angle / 2))}; }
Vec4d turn_upright(float angle) { return turn({0, 1, 0}, angle); }

/// Returns the rotation that applies b first, then a.
Vec4d after(Vec4d a, Vec4d b)
{
    const Vec3d u(a), v(b);
    return {u * b.w + v * a.w + glm::cross(u, v), a.w * b.w - glm::dot(u, v)};
}

struct Materials {
    MaterialId tiles, plaster, glaze, celadon, brass, ebony, rubber, wood, painted, leather, leather_dark, silver;

    explicit Materials(Scene& scene)
    {
        const auto add = [&](const char* name, Vec3f color, float roughness, float metallic = 0, float coat = 0) {
            Material m;
            m.name = name;
            m.base_color = Vec4f(color, 1);
            m.roughness = roughness;
            m.metallic = metallic;
            m.clearcoat = coat;
            m.clearcoat_roughness = 0.22f;
            return m;
        };
        const auto textured = [&](Material m, Texture texture, Vec2f scale) {
            m.base_color_texture.texture = scene.add(std::move(texture));
            m.base_color_texture.scale = scale;
            return scene.add(std::move(m));
        };
        constexpr float kTileSide = 0.9f;
        tiles = textured(add("marble tiles", Vec3f(1), 0.34f), builtin::tiles(), Vec2f(1 / (kTilesAcross * kTileSide)));
        glaze = textured(add("glaze", Vec3f(1), 0.5f, 0, 1), builtin::glaze(), Vec2f(1));
        wood = textured(add("wood", Vec3f(1), 0.42f), builtin::wood(), Vec2f(1));
        plaster = scene.add(add("plaster", {0.34f, 0.44f, 0.52f}, 0.9f));
        celadon = scene.add(add("celadon", {0.165f, 0.33f, 0.255f}, 0.5f, 0, 1));
        brass = scene.add(add("brass", {0.88f, 0.62f, 0.27f}, 0.30f, 1));
        silver = scene.add(add("silver", {0.90f, 0.89f, 0.87f}, 0.28f, 1));
        ebony = scene.add(add("ebony", {0.022f, 0.017f, 0.015f}, 0.32f));
        rubber = scene.add(add("rubber", {0.52f, 0.032f, 0.022f}, 0.55f));
        painted = scene.add(add("painted wood", {0.74f, 0.36f, 0.045f}, 0.38f));
        leather = scene.add(add("leather", {0.66f, 0.58f, 0.45f}, 0.48f));
        leather_dark = scene.add(add("dark leather", {0.16f, 0.055f, 0.03f}, 0.45f));
    }
};

class StillLife {
public:
    StillLife() : materials_(scene_) {}

    Scene make()
    {
        add_room();
        add_vessels();
        add_toys();
        add_light();
        const Camera camera = Camera::look_at({0.5, 3.5, 11.2}, {0.12, 1.22, 0}, {0, 1, 0}, 0.41f);
        CameraLens lens = camera.lens;
        lens.aspect = 16.0f / 9.0f;
        NodeDesc node;
        node.name = "main";
        node.matrix = camera.world_from_camera;
        node.camera = scene_.add(lens);
        scene_.add_node(scene_.root(), node);
        return std::move(scene_);
    }

private:
    CageId add(Cage cage, std::vector<MaterialId> materials)
    {
        cage.materials = std::move(materials);
        return scene_.add(std::move(cage));
    }
    NodeId put(const char* name, std::vector<CageId> cages, Vec3d at, Vec4d rotation, std::vector<MaterialId> materials = {})
    {
        NodeDesc node;
        node.name = name;
        node.place.translation = at;
        node.place.rotation = rotation;
        node.cages = std::move(cages);
        node.materials = std::move(materials);
        return scene_.add_node(scene_.root(), std::move(node));
    }
    /// Shows another node's subtree once more.
    void put_again(const char* name, NodeId what, Vec3d at, Vec4d rotation)
    {
        NodeDesc node;
        node.name = name;
        node.place.translation = at;
        node.place.rotation = rotation;
        node.instance_of = what;
        scene_.add_node(scene_.root(), std::move(node));
    }

    void add_room()
    {
        // The room is made of two cages, since the wall needs less detail. The wall rises from the floor before the floor
        // ends.
        const CageId floor = add(floor_sheet("floor", {16, 4, -5.7f, 16, 10}), {materials_.tiles});
        const CageId wall = add(wall_sheet("wall", {24, -5.4f, 3, 10, 16, 12}), {materials_.plaster});
        put("room", {floor}, {0, 0, 0}, turn_upright(0));
        put("wall", {wall}, {0, 0, 0}, turn_upright(0));
    }

    void add_vessels()
    {
        put("vase", {add(vase(), {materials_.glaze})}, {-2.5, 0, -1.5}, turn_upright(0.3f));
        std::vector<CageId> parts;
        for (Cage& part : teapot()) parts.push_back(add(std::move(part), {materials_.celadon}));
        put("teapot", parts, {0.15, 0, -0.35}, turn_upright(0.5f));
    }

    void add_toys()
    {
        const CageId pawn_cage = add(pawn(), {materials_.brass});
        const NodeId brass_pawn = put("pawn", {pawn_cage}, {-1.75, 0, 0.75}, turn_upright(0));
        put_again("pawn again", brass_pawn, {-3.35, 0, 0.1}, turn_upright(0.2f));
        put("ebony pawn", {pawn_cage}, {-2.65, 0, 1.15}, turn_upright(0.4f), {materials_.ebony});

        const auto block = [&](const char* name, float margin, float sharpness, MaterialId material) {
            return add(box(name, Vec3f(0.95f), margin, sharpness), {material});
        };
        put("sharp block", {block("sharp block", 0.2f, kInfiniteSharpness, materials_.wood)}, {2.45, 0, -1.5},
            turn_upright(0.45f));
        put("soft block", {block("soft block", 0.2f, 1.5f, materials_.painted)}, {3.55, 0, -1.05}, turn_upright(-0.3f));
        put("round block", {block("round block", 0.3f, 0, materials_.wood)}, {2.95, 0.95, -1.3}, turn_upright(0.95f));

        const CageId ball = add(panelled_ball("ball", 0.62f, 0.05f, 2), {materials_.leather, materials_.leather_dark});
        put("ball", {ball}, {2.25, 0.622, 0.65}, turn(glm::normalize(Vec3d(1, 0.5, 0.3)), 0.9f));
        put("knot", {add(knot(), {materials_.rubber})}, {-0.55, 0.396, 1.75}, turn_upright(0.35f));

        // The shape stands on three of its arms, so the diagonal of the cube is upright.
        const Vec4d tilt = turn(glm::normalize(Vec3d(-1, 0, 1)), maths::acos(0.57735027f));
        const CageId jack_cage = add(jack("jack", 0.36f, 0.13f), {materials_.silver});
        const double lift = 0.261;  // the height of its lowest points
        const NodeId first = put("jack", {jack_cage}, {0.85, lift, 1.75}, tilt);
        put_again("jack again", first, {1.5, lift, 2.35}, after(turn_upright(0.7f), tilt));
        put_again("jack once more", first, {3.25, lift, 1.25}, after(turn_upright(1.6f), tilt));
        put("brass jack", {jack_cage}, {-1.75, lift, 2.2}, after(turn_upright(2.3f), tilt), {materials_.brass});
    }

    void add_area_light(const char* name, Vec3d at, Vec3d target, Vec2f size, Vec3f radiance)
    {
        NodeDesc node;
        node.name = name;
        node.matrix = Camera::look_at(at, target, {0, 1, 0}, 1).world_from_camera;
        AreaLight area;
        area.size = size;
        area.radiance = radiance;
        node.light = scene_.add(Light{name, area});
        scene_.add_node(scene_.root(), std::move(node));
    }

    void add_light()
    {
        add_area_light("window", {-6.8, 5.2, 2.0}, {0, 0.4, 0}, {2.6f, 2.6f}, Vec3f(52, 46, 38));
        add_area_light("lamp", {6, 5, 6}, {0.5, 0.5, 0}, {2.5f, 2.5f}, Vec3f(3.0f, 3.6f, 4.6f));
        scene_.environment.radiance = Vec3f(0.36f);
        scene_.environment.image = scene_.add(studio());
    }

    Scene scene_;
    Materials materials_;
};

}  // namespace

Scene builtin_scene() { return StillLife().make(); }

}  // namespace occam
