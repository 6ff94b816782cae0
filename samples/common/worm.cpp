#include "worm.h"

#include <cmath>

namespace sample {

using namespace occam;

namespace {

constexpr int kRings = 13, kAround = 8, kJoints = 4;
constexpr float kPi = 3.14159265f, kBone = 2.0f / (kJoints - 1);

Cage tube(MaterialId material)
{
    Cage cage;
    cage.name = "worm";
    cage.materials = {material};
    cage.skin.sets = 1;
    for (int r = 0; r < kRings; ++r) {
        const float along = float(r) / (kRings - 1), radius = 0.1f + 0.25f * std::sin(kPi * (0.1f + 0.8f * along));
        for (int k = 0; k < kAround; ++k) {
            const float angle = 2 * kPi * float(k) / kAround;
            cage.positions.push_back({2 * along - 1, radius * std::cos(angle), radius * std::sin(angle)});
            // Each vertex is weighted between the two nearest joints.
            const float at = along * (kJoints - 1);
            const int joint = std::min(int(at), kJoints - 2);
            cage.skin.joints.push_back({joint, joint + 1, 0, 0});
            cage.skin.weights.push_back({1 - (at - float(joint)), at - float(joint), 0, 0});
        }
    }
    const auto vertex = [](int ring, int k) { return static_cast<std::uint32_t>(ring * kAround + k % kAround); };
    for (int r = 0; r + 1 < kRings; ++r)
        for (int k = 0; k < kAround; ++k) {
            cage.face_sizes.push_back(4);
            for (const std::uint32_t v : {vertex(r, k), vertex(r, k + 1), vertex(r + 1, k + 1), vertex(r + 1, k)})
                cage.face_vertices.push_back(v);
        }
    for (int end : {0, 1}) {
        cage.face_sizes.push_back(kAround);
        for (int k = 0; k < kAround; ++k) cage.face_vertices.push_back(end ? vertex(kRings - 1, k) : vertex(0, kAround - k));
    }
    return cage;
}

// The joints turn from side to side, so that the worm stays on the floor.
Channel turning(NodeId joint, float phase)
{
    Channel channel{joint, Channel::Path::Rotation, Channel::Interpolation::Linear, {}, {}, 4};
    for (int key = 0; key <= 8; ++key) {
        const float angle = 0.5f * std::sin(2 * kPi * (float(key) / 8 + phase));
        channel.times.push_back(float(key) / 8);
        for (float value : {0.0f, std::sin(angle / 2), 0.0f, std::cos(angle / 2)}) channel.values.push_back(value);
    }
    return channel;
}

}  // namespace

Worm add_worm(Scene& scene, Vec3f color)
{
    Worm worm;
    worm.node = scene.add_node(scene.root(), {.name = "worm"});
    Skin skin;
    Clip clip{"crawl", {}};
    NodeId above = worm.node;
    for (int j = 0; j < kJoints; ++j) {
        NodeDesc desc;
        desc.place.translation = {j == 0 ? -1.0 : double(kBone), 0, 0};
        above = scene.add_node(above, desc);
        Mat4d joint_from_mesh(1);
        joint_from_mesh[3] = Vec4d(1 - double(kBone) * j, 0, 0, 1);
        skin.joints.push_back(above);
        skin.joint_from_mesh.push_back(joint_from_mesh);
        clip.channels.push_back(turning(above, float(j) / kJoints));
    }
    Material material;
    material.base_color = Vec4f(color, 1);
    material.roughness = 0.4f;
    NodeDesc body;
    body.cages = {scene.add(tube(scene.add(material)))};
    body.skin = scene.add(std::move(skin));
    scene.add_node(worm.node, body);
    worm.crawl = scene.add(std::move(clip));
    return worm;
}

void add_surroundings(Scene& scene, float half_side)
{
    Cage floor;
    floor.scheme = Scheme::Triangles;
    floor.positions = {
        {-half_side, 0, half_side}, {half_side, 0, half_side}, {half_side, 0, -half_side}, {-half_side, 0, -half_side}};
    floor.face_vertices = {0, 1, 2, 0, 2, 3};
    Material grey;
    grey.base_color = {0.34f, 0.33f, 0.31f, 1};
    grey.roughness = 0.8f;
    floor.materials = {scene.add(std::move(grey))};
    scene.add_node(scene.root(), {.name = "floor", .cages = {scene.add(std::move(floor))}});
    NodeDesc sun;
    sun.place.rotation = {-0.4545, 0.2706, 0.1464, 0.8361};  // it shines from behind, high, and a little from one side
    sun.light = scene.add(Light{"sun", SunLight{Vec3f(3)}});
    scene.add_node(scene.root(), sun);
    scene.environment.radiance = Vec3f(0.35f, 0.45f, 0.6f);
}

}  // namespace sample
