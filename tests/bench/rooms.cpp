#include "tests/bench/rooms.h"

#include <array>
#include <cmath>
#include <map>

#include "io/import/import.h"
#include "lod/pose_cage.h"
#include "tests/bench/crowd.h"
#include "tests/bench/subjects.h"

namespace occam::bench {
namespace {

constexpr float kPi = 3.14159265f;

// Returns a number in [0, 1) that depends on its arguments alone.
float number(std::uint32_t i, std::uint32_t which)
{
    std::uint32_t h = i * 0x9e3779b9u + which * 0x85ebca6bu + 1;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return static_cast<float>(h ^ h >> 16) / 4294967296.0f;
}

// Builds a triangle mesh.
struct Builder {
    Cage mesh;

    Builder() { mesh.scheme = Scheme::Triangles; }

    void quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d)
    {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {a, b, c, d});
        for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.face_vertices.push_back(first + corner);
    }
    // Adds the six sides of a box; with `inward` they face inwards, as those of a room.
    void box(Vec3f lo, Vec3f hi, bool inward = false)
    {
        const auto corner = [&](int i) { return Vec3f(i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z); };
        constexpr int kSides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
        for (const auto& s : kSides)
            if (inward) quad(corner(s[3]), corner(s[2]), corner(s[1]), corner(s[0]));
            else quad(corner(s[0]), corner(s[1]), corner(s[2]), corner(s[3]));
    }
    void sphere(Vec3f centre, float radius, int around, int down)
    {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size()), row = static_cast<std::uint32_t>(around + 1);
        for (int j = 0; j <= down; ++j)
            for (int i = 0; i <= around; ++i) {
                const float a = 2 * kPi * float(i) / float(around), b = kPi * float(j) / float(down);
                mesh.positions.push_back(centre +
                                         radius * Vec3f(std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a)));
            }
        for (std::uint32_t j = 0; j < std::uint32_t(down); ++j)
            for (std::uint32_t i = 0; i < std::uint32_t(around); ++i) {
                const std::uint32_t v = first + j * row + i;
                if (j > 0) mesh.face_vertices.insert(mesh.face_vertices.end(), {v, v + 1, v + row + 1});
                if (j + 1 < std::uint32_t(down))
                    mesh.face_vertices.insert(mesh.face_vertices.end(), {v, v + row + 1, v + row});
            }
    }
    // Adds four legs and a plate.
    void table(Vec3f at, Vec3f size, float thick)
    {
        for (int leg = 0; leg < 4; ++leg) {
            const Vec3f foot = at + Vec3f(leg & 1 ? size.x - thick : 0, 0, leg & 2 ? size.z - thick : 0);
            box(foot, foot + Vec3f(thick, size.y, thick));
        }
        box(at + Vec3f(0, size.y, 0), at + Vec3f(size.x, size.y + thick, size.z));
    }
};

constexpr Vec3f kRoom{8, 3, 6};

// Adds what stands in a room whose lowest corner is at `at`. Each sphere has 2 * fineness * (fineness - 1) triangles.
void furnish(Builder& to, Vec3f at, std::uint32_t seed, int shelves, int fineness)
{
    to.table(at + Vec3f(2.5f, 0, 2), {2.2f, 0.75f, 1.2f}, 0.06f);
    for (std::uint32_t chair = 0; chair < 4; ++chair) {
        const Vec3f foot = at + Vec3f(2.6f + 1.1f * float(chair % 2), 0, chair < 2 ? 1.3f : 3.4f) +
                           0.2f * Vec3f(number(seed, chair), 0, number(seed, chair + 4));
        to.table(foot, {0.45f, 0.45f, 0.45f}, 0.04f);
        to.box(foot + Vec3f(0, 0.45f, chair < 2 ? 0 : 0.41f), foot + Vec3f(0.45f, 0.95f, chair < 2 ? 0.04f : 0.45f));
    }
    for (int shelf = 0; shelf < shelves; ++shelf) {
        const Vec3f foot = at + Vec3f(6.2f, 0.4f + 0.45f * float(shelf), 0.1f);
        to.box(foot, foot + Vec3f(1.6f, 0.03f, 0.3f));
        for (std::uint32_t book = 0; book < 24; ++book) {
            const float x = 0.02f + 0.065f * float(book),
                        high = 0.2f + 0.15f * number(seed + book, 20 + std::uint32_t(shelf));
            to.box(foot + Vec3f(x, 0.03f, 0.02f), foot + Vec3f(x + 0.05f, 0.03f + high, 0.26f));
        }
    }
    for (std::uint32_t ball = 0; ball < 6; ++ball)
        to.sphere(at + Vec3f(0.8f + 6 * number(seed, ball + 40), 0.25f, 4.2f + 1.2f * number(seed, ball + 60)), 0.25f,
                  2 * fineness, fineness);
}

Material grey_material()
{
    Material grey;
    grey.base_color = {0.7f, 0.7f, 0.7f, 1};
    grey.roughness = 1;
    grey.specular = 0;
    return grey;
}

Scene scene_of(Cage mesh)
{
    Scene scene;
    mesh.materials = {scene.add(grey_material())};
    NodeDesc desc;
    desc.cages = {scene.add(std::move(mesh))};
    scene.add_node(scene.root(), std::move(desc));
    return scene;
}

void add_lamp(Scene& scene, Vec3d at, float candela)
{
    NodeDesc desc;
    desc.light = scene.add(Light{"lamp", PointLight{Vec3f(candela)}});
    desc.place.translation = at;
    scene.add_node(scene.root(), std::move(desc));
}

}  // namespace

std::vector<Vec3f> WholeScene::triangles(lod::TopologyCache& topologies, lod::LevelSettings levels) const
{
    levels.mode = lod::LevelMode::PerInstance;  // one mesh for all rays, as the peer has
    std::vector<Vec3f> corners;
    scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d& world_from_node) {
        const SkinSlot* skin = scene.find(node.skin);
        for (const CageId cage : node.cages) {
            const CageSlot& slot = scene.cage(cage);
            if (slot.cage.face_count() == 0) continue;
            const lod::CageTables& tables = topologies.get(slot);
            Arena arena;
            lod::DeformCounters counters;
            const lod::PosedCage& posed = lod::pose_cage({slot, node, id, skin, {&world_from_node, 1}}, levels,
                                                         {tables, nullptr, arena, counters});
            std::vector<Vec3f> own;
            if (posed.topology) own = micropolygons(posed);
            else
                for (const std::uint32_t v : slot.cage.face_vertices) own.push_back(posed.vertex(v));
            for (const Vec3f p : own) corners.push_back(Vec3f(posed.anchor + Vec3d(p)));
        }
    });
    return corners;
}

WholeScene furnished_room()
{
    Builder room;
    room.box(Vec3f(0), kRoom, true);
    furnish(room, Vec3f(0), 1, 5, 22);
    WholeScene made{"room", scene_of(std::move(room.mesh)), Camera::look_at({0.6, 1.7, 0.6}, {5, 0.8, 4}, {0, 1, 0}, 1.0f)};
    add_lamp(made.scene, {4, 2.7, 3}, 8);
    return made;
}

WholeScene level_of_rooms()
{
    constexpr int kSide = 8;
    constexpr float kDoor = 1.2f, kDoorHeight = 2.1f, kWall = 0.1f;
    Builder level;
    const Vec3f whole(kRoom.x * kSide, kRoom.y, kRoom.z * kSide);
    level.box(Vec3f(0), whole, true);
    // Each inner wall is two pieces beside a door and one above it.
    const auto wall = [&](int axis, Vec3f from, float length) {
        const auto piece = [&](float begin, float end, float low, float high) {
            Vec3f lo = from, hi = from;
            lo[axis] += begin;
            hi[axis] += end;
            lo.y = low;
            hi.y = high;
            hi[2 - axis] += kWall;
            level.box(lo, hi);
        };
        const float door = (length - kDoor) / 2;
        piece(0, door, 0, kRoom.y);
        piece(door + kDoor, length, 0, kRoom.y);
        piece(door, door + kDoor, kDoorHeight, kRoom.y);
    };
    for (int z = 0; z < kSide; ++z)
        for (int x = 0; x < kSide; ++x) {
            const Vec3f at(kRoom.x * float(x), 0, kRoom.z * float(z));
            if (x > 0) wall(2, at, kRoom.z);
            if (z > 0) wall(0, at, kRoom.x);
            furnish(level, at + Vec3f(kWall, 0, kWall), static_cast<std::uint32_t>(z * kSide + x), (x + z) % 2 ? 2 : 0, 8);
        }
    WholeScene made{"level", scene_of(std::move(level.mesh)),
                    Camera::look_at({24.6, 1.7, 18.6}, {30, 0.9, 24}, {0, 1, 0}, 1.0f)};
    for (const Vec3d at : {Vec3d(28, 2.7, 21), Vec3d(36, 2.7, 21), Vec3d(28, 2.7, 27), Vec3d(20, 2.7, 15)})
        add_lamp(made.scene, at, 8);
    return made;
}

WholeScene many_objects()
{
    Builder hall;
    hall.box({-20, 0, -20}, {20, 8, 20}, true);
    Scene scene = scene_of(std::move(hall.mesh));
    std::array<CageId, 3> kinds;
    for (int kind = 0; kind < 3; ++kind) {
        Builder thing;
        if (kind == 0) thing.table(Vec3f(-0.25f, 0, -0.25f), {0.5f, 0.5f, 0.5f}, 0.05f);
        else thing.sphere({0, 0.25f, 0}, 0.25f, 12 * kind, 6 * kind);
        kinds[std::size_t(kind)] = scene.add(std::move(thing.mesh));
    }
    for (std::uint32_t i = 0; i < 3000; ++i) {
        NodeDesc desc;
        desc.cages = {kinds[i % 3]};
        desc.place.translation = {-19 + 38 * double(number(i, 1)), 2.5 * double(number(i, 2)),
                                  -19 + 38 * double(number(i, 3))};
        scene.add_node(scene.root(), std::move(desc));
    }
    add_lamp(scene, {0, 7, 0}, 120);
    return {"many objects", std::move(scene), Camera::look_at({-17, 2, -17}, {0, 1, 0}, {0, 1, 0}, 1.0f)};
}

namespace {

// Returns a ball of quads, as a cube whose sides are pushed outward.
Cage ball_cage(Vec3f radii, std::uint32_t quads)
{
    Cage cage;
    const std::uint32_t row = quads + 1;
    std::map<std::array<std::uint32_t, 3>, std::uint32_t> known;
    const auto vertex = [&](const std::array<std::uint32_t, 3>& at) {
        const auto [entry, is_new] = known.try_emplace(at, std::uint32_t(cage.positions.size()));
        if (is_new) {
            const Vec3f p = Vec3f(at[0], at[1], at[2]) * (2 / float(quads)) - Vec3f(1);
            cage.positions.push_back(radii * glm::normalize(p));
        }
        return entry->second;
    };
    for (std::uint32_t side = 0; side < 6; ++side)
        for (std::uint32_t i = 0; i + 1 < row; ++i)
            for (std::uint32_t j = 0; j + 1 < row; ++j) {
                const std::uint32_t axis = side / 2, fixed = side % 2 ? quads : 0;
                const auto at = [&](std::uint32_t u, std::uint32_t v) {
                    std::array<std::uint32_t, 3> p{};
                    p[axis] = fixed;
                    p[(axis + 1) % 3] = side % 2 ? u : v;
                    p[(axis + 2) % 3] = side % 2 ? v : u;
                    return vertex(p);
                };
                for (const std::uint32_t v : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)})
                    cage.face_vertices.push_back(v);
                cage.face_sizes.push_back(4);
            }
    return cage;
}

void add_floor(Scene& scene, MaterialId material, float half, float y)
{
    Builder floor;
    floor.quad({-half, y, half}, {half, y, half}, {half, y, -half}, {-half, y, -half});
    floor.mesh.materials = {material};
    NodeDesc desc;
    desc.cages = {scene.add(std::move(floor.mesh))};
    scene.add_node(scene.root(), std::move(desc));
}

}  // namespace

WholeScene crowd_of_cages()
{
    const Crowd crowd("crowd", torus(24, 12), 64, 1);
    Scene scene;
    const MaterialId grey = scene.add(grey_material());
    Cage cage = crowd.cage;
    cage.materials = {grey};
    const CageId shape = scene.add(std::move(cage));
    for (int i = 0; i < crowd.copies; ++i) {
        NodeDesc desc;
        desc.place.translation = crowd.place(i);
        desc.cages = {shape};
        scene.add_node(scene.root(), std::move(desc));
    }
    add_floor(scene, grey, static_cast<float>(crowd.extent()), -0.6f);
    add_lamp(scene, crowd.lights()[0].centre, 60);
    return {"crowd of 64 cages", std::move(scene), Camera::look_at(crowd.eye(), {0, 0, 0}, {0, 1, 0}, 0.785f)};
}

WholeScene figure_with_hair()
{
    Scene scene;
    const MaterialId grey = scene.add(grey_material());
    const auto add = [&](Cage cage, Vec3d at) {
        cage.materials = {grey};
        NodeDesc desc;
        desc.place.translation = at;
        desc.cages = {scene.add(std::move(cage))};
        scene.add_node(scene.root(), std::move(desc));
    };
    const Vec3d head(0, 1.62, 0), trunk(0, 1.1, 0);
    add(ball_cage({0.11f, 0.14f, 0.12f}, 16), head);
    add(ball_cage({0.2f, 0.36f, 0.13f}, 16), trunk);
    add(ball_cage({0.215f, 0.33f, 0.145f}, 24), trunk);  // a shirt
    for (const double side : {-1.0, 1.0}) {
        add(ball_cage({0.06f, 0.34f, 0.06f}, 12), {side * 0.27, 1.1, 0});
        add(ball_cage({0.068f, 0.18f, 0.068f}, 16), {side * 0.27, 1.25, 0});  // a sleeve
        add(ball_cage({0.08f, 0.46f, 0.09f}, 12), {side * 0.11, 0.45, 0});
        add(ball_cage({0.09f, 0.3f, 0.1f}, 16), {side * 0.11, 0.62, 0});  // a trouser leg
    }
    Builder hair;
    for (std::uint32_t card = 0; card < 4000; ++card) {
        const float around = 2 * kPi * number(card, 1), up = number(card, 2);
        const Vec3f out(std::cos(around) * (1 - 0.7f * up), 0.3f + 0.7f * up, std::sin(around) * (1 - 0.7f * up));
        const Vec3f root = Vec3f(head) + Vec3f(0.11f, 0.14f, 0.12f) * glm::normalize(out);
        const Vec3f along = 0.05f * glm::normalize(out) - Vec3f(0, 0.08f + 0.1f * number(card, 3), 0);
        const Vec3f wide = 0.002f * glm::normalize(glm::cross(out, Vec3f(number(card, 4), 1, number(card, 5))));
        hair.quad(root - wide, root + wide, root + along + wide, root + along - wide);
    }
    add(std::move(hair.mesh), Vec3d(0));
    add_floor(scene, grey, 4, 0);
    add_lamp(scene, {1.5, 2.6, 2}, 12);
    return {"figure with hair", std::move(scene), Camera::look_at({0.5, 1.6, 1.9}, {0, 1.15, 0}, {0, 1, 0}, 0.7f)};
}

std::vector<WholeScene> shared_scenes()
{
    struct Known {
        const char *name, *file;
        Subdivide subdivide;
        bool is_inside;
    };
    std::vector<WholeScene> all;
    for (const Known& known : {Known{"pandora", "scenes/pandora/pandora.obj", Subdivide::Off, true},
                               Known{"garage", "gltf/scenes/garage/garage.gltf", Subdivide::Off, true},
                               Known{"chess set", "subdiv/chess/chess_set.gltf", Subdivide::Auto, false},
                               Known{"knight", "gltf/skinned/Knight/Knight.glb", Subdivide::Off, false}}) {
        if (!std::filesystem::exists(shared_folder() / known.file)) continue;
        WholeScene made{known.name, load(shared_folder() / known.file, {.subdivide = known.subdivide}), {}};
        const Box3d box = made.scene.bounds();
        const Vec3d middle = box.centre();
        if (known.is_inside) made.camera = Camera::look_at(middle, middle + Vec3d(1, -0.1, 0.6), {0, 1, 0}, 1.1f);
        else made.camera = made.scene.camera().value_or(Camera::framing(box, 16.0f / 9));
        all.push_back(std::move(made));
    }
    return all;
}

}  // namespace occam::bench
