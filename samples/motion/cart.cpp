#include "cart.h"

#include <cmath>

#include "shapes.h"

namespace sample {

using namespace occam;

namespace {

constexpr double kTurn = 6.283185307179586, kWheel = 0.5;
constexpr int kSpokes = 8;

MaterialId paint(Scene& scene, Vec3f color, float roughness, float metallic = 0)
{
    Material material;
    material.base_color = Vec4f(color, 1);
    material.roughness = roughness;
    material.metallic = metallic;
    return scene.add(material);
}

// Adds a wheel that is never seen itself, but shown by four nodes.
NodeId add_wheel(Scene& scene)
{
    const NodeId wheel = scene.add_node(scene.root(), {.name = "wheel", .visible = false});
    const MaterialId rubber = paint(scene, {0.04f, 0.04f, 0.045f}, 0.6f),
                     brass = paint(scene, {0.85f, 0.6f, 0.25f}, 0.25f, 1);
    const MaterialId red = paint(scene, {0.75f, 0.06f, 0.04f}, 0.35f), white = paint(scene, {0.85f, 0.83f, 0.78f}, 0.4f);
    scene.add_node(wheel, {.name = "tyre", .cages = {scene.add(ring(float(kWheel) - 0.05f, 0.05f, rubber))}});
    scene.add_node(wheel, {.name = "rim", .cages = {scene.add(ring(float(kWheel) - 0.11f, 0.025f, brass))}});
    const CageId hub = scene.add(
        turned({{0.04f, -0.12f}, {0.085f, -0.09f}, {0.1f, 0}, {0.085f, 0.09f}, {0.04f, 0.12f}}, 10, brass));
    const double half = kTurn / 8;
    scene.add_node(wheel, {.name = "hub", .place = {.rotation = {std::sin(half), 0, 0, std::cos(half)}}, .cages = {hub}});
    const CageId spokes[] = {scene.add(limb(float(kWheel) - 0.13f, 0.045f, 0.03f, red)),
                             scene.add(limb(float(kWheel) - 0.13f, 0.045f, 0.03f, white))};
    for (int k = 0; k < kSpokes; ++k) {
        const double angle = kTurn * k / kSpokes;
        scene.add_node(wheel, {.name = "spoke",
                               .place = {.rotation = {0, 0, std::sin(angle / 2), std::cos(angle / 2)}},
                               .cages = {spokes[k % 2]}});
    }
    return wheel;
}

}  // namespace

Cart::Cart(Scene& scene)
{
    const NodeId wheel = add_wheel(scene);
    body_ = scene.add_node(scene.root(), {.name = "cart"});
    const CageId bed = scene.add(rounded_box({2.3f, 0.16f, 1.0f}, paint(scene, {0.08f, 0.3f, 0.16f}, 0.3f)));
    const CageId rail = scene.add(rounded_box({2.3f, 0.34f, 0.08f}, paint(scene, {0.55f, 0.34f, 0.16f}, 0.5f)));
    scene.add_node(body_, {.name = "bed", .place = {.translation = {0, 0.72, 0}}, .cages = {bed}});
    for (const double side : {-1, 1})
        scene.add_node(body_, {.name = "rail", .place = {.translation = {0, 0.92, 0.48 * side}}, .cages = {rail}});
    for (int k = 0; k < 4; ++k) wheels_[k] = scene.add_node(body_, {.name = "turning wheel", .instance_of = wheel});
    const Worm worm = add_worm(scene, {0.95f, 0.75f, 0.1f});
    passenger_ = worm.node;
    crawl_ = worm.crawl;
}

void Cart::pose(Scene& scene, double x, double z, double seconds) const
{
    scene.set_transform(body_, Trs{.translation = {x, 0, z}});
    const double angle = -x / kWheel;
    for (int k = 0; k < 4; ++k) {
        const Vec3d at(k % 2 ? 0.75 : -0.75, kWheel, k < 2 ? 0.62 : -0.62);
        const double phase = angle + 0.4 * k;
        scene.set_transform(wheels_[k],
                            Trs{.translation = at, .rotation = {0, 0, std::sin(phase / 2), std::cos(phase / 2)}});
    }
    scene.set_transform(passenger_, Trs{.translation = {x, 1.22, z}, .scale = Vec3d(0.9)});
    const ClipAt now{crawl_, looped({0, 1}, 2.5 * seconds)};
    scene.pose({&now, 1});
}

}  // namespace sample
