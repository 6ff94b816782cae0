#include "tests/bench/rooms.h"

#include <array>
#include <cmath>

#include "io/import/import.h"
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

Scene scene_of(Cage mesh)
{
    Scene scene;
    Material grey;
    grey.base_color = {0.7f, 0.7f, 0.7f, 1};
    grey.roughness = 1;
    grey.specular = 0;
    mesh.materials = {scene.add(grey)};
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

std::vector<Vec3f> TriangleScene::triangles() const
{
    std::vector<Vec3f> corners;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
        for (const CageId id : node.cages) {
            const Cage& cage = scene.cage(id).cage;
            for (const std::uint32_t v : cage.face_vertices)
                corners.push_back(Vec3f(Vec3d(world_from_node * Vec4d(Vec3d(cage.positions[v]), 1))));
        }
    });
    return corners;
}

TriangleScene furnished_room()
{
    Builder room;
    room.box(Vec3f(0), kRoom, true);
    furnish(room, Vec3f(0), 1, 5, 22);
    TriangleScene made{"room", scene_of(std::move(room.mesh)),
                       Camera::look_at({0.6, 1.7, 0.6}, {5, 0.8, 4}, {0, 1, 0}, 1.0f)};
    add_lamp(made.scene, {4, 2.7, 3}, 8);
    return made;
}

TriangleScene level_of_rooms()
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
    TriangleScene made{"level", scene_of(std::move(level.mesh)),
                       Camera::look_at({24.6, 1.7, 18.6}, {30, 0.9, 24}, {0, 1, 0}, 1.0f)};
    for (const Vec3d at : {Vec3d(28, 2.7, 21), Vec3d(36, 2.7, 21), Vec3d(28, 2.7, 27), Vec3d(20, 2.7, 15)})
        add_lamp(made.scene, at, 8);
    return made;
}

TriangleScene many_objects()
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

std::vector<TriangleScene> shared_triangle_scenes()
{
    using Known = std::pair<const char*, const char*>;
    std::vector<TriangleScene> all;
    for (const auto& [name, file] :
         {Known{"pandora", "scenes/pandora/pandora.obj"}, Known{"garage", "gltf/scenes/garage/garage.gltf"}}) {
        if (!std::filesystem::exists(shared_folder() / file)) continue;
        TriangleScene made{name, load(shared_folder() / file, {.subdivide = Subdivide::Off}), {}};
        const Box3d box = made.scene.bounds();
        const Vec3d middle = box.centre();
        made.camera = Camera::look_at(middle, middle + Vec3d(1, -0.1, 0.6), {0, 1, 0}, 1.1f);
        all.push_back(std::move(made));
    }
    return all;
}

}  // namespace occam::bench
