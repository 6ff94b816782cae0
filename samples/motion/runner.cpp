#include "runner.h"

#include <cmath>

#include "shapes.h"

namespace sample {

using namespace occam;

namespace {

constexpr double kTurn = 6.283185307179586, kLeg = 0.45, kHip = 0.95;

// Returns a place whose turn by `angle` about z swings what hangs there forward, along +x.
Trs hinge(Vec3d at, double angle)
{
    return {.translation = at, .rotation = {0, 0, std::sin(angle / 2), std::cos(angle / 2)}};
}

}  // namespace

Runner::Runner(Scene& scene)
{
    Material wood;
    wood.base_color = {0.72f, 0.42f, 0.2f, 1};
    wood.roughness = 0.35f;
    const MaterialId skin = scene.add(wood);
    wood.base_color = {0.1f, 0.2f, 0.45f, 1};
    const MaterialId cloth = scene.add(wood);

    body_ = scene.add_node(scene.root(), {.name = "runner"});
    const CageId trunk = scene.add(turned(
        {{0.08f, -0.1f}, {0.17f, -0.04f}, {0.15f, 0.18f}, {0.22f, 0.42f}, {0.17f, 0.55f}, {0.06f, 0.6f}, {0.05f, 0.66f}}, 10,
        cloth));
    scene.add_node(body_, {.name = "trunk", .place = {.scale = {0.8, 1, 1.1}}, .cages = {trunk}});
    const CageId head = scene.add(turned({{0.07f, -0.15f}, {0.14f, -0.06f}, {0.15f, 0.08f}, {0.08f, 0.17f}}, 10, skin));
    scene.add_node(body_, {.name = "head", .place = {.translation = {0.03, 0.8, 0}}, .cages = {head}});
    const CageId thigh = scene.add(limb(float(kLeg), 0.12f, 0.085f, cloth));
    const CageId shin = scene.add(limb(float(kLeg), 0.085f, 0.055f, skin));
    const CageId foot = scene.add(rounded_box({0.3f, 0.1f, 0.13f}, cloth));
    const CageId upper_arm = scene.add(limb(0.28f, 0.075f, 0.055f, cloth));
    const CageId forearm = scene.add(limb(0.26f, 0.055f, 0.05f, skin));
    for (Limb& leg : legs_) {
        leg.upper = scene.add_node(body_, {.name = "thigh", .cages = {thigh}});
        leg.lower = scene.add_node(leg.upper, {.name = "shin", .cages = {shin}});
        scene.add_node(leg.lower, {.name = "foot", .place = {.translation = {0.07, -kLeg - 0.05, 0}}, .cages = {foot}});
    }
    for (Limb& arm : arms_) {
        arm.upper = scene.add_node(body_, {.name = "upper arm", .cages = {upper_arm}});
        arm.lower = scene.add_node(arm.upper, {.name = "forearm", .cages = {forearm}});
    }
}

void Runner::pose(Scene& scene, double x, double z, double stride) const
{
    const double phase = kTurn * stride;
    scene.set_transform(body_, hinge({x, kHip + 0.06 * std::abs(std::sin(phase)), z}, -0.22));
    for (int side : {0, 1}) {
        const double swing = std::sin(phase + side * kTurn / 2), lift = std::cos(phase + side * kTurn / 2);
        const double out = side ? 1 : -1;
        scene.set_transform(legs_[side].upper, hinge({0, -0.02, 0.11 * out}, 0.35 + 0.85 * swing));
        scene.set_transform(legs_[side].lower, hinge({0, -kLeg, 0}, -0.75 - 0.65 * lift));
        scene.set_transform(arms_[side].upper, hinge({0, 0.5, 0.26 * out}, -0.9 * swing));
        scene.set_transform(arms_[side].lower, hinge({0, -0.28, 0}, 1.5 - 0.3 * swing));
    }
}

}  // namespace sample
