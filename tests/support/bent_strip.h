// A scene whose skinned cage two joints bend, for tests of poses.
#pragma once

#include <cmath>

#include "scenegraph/scene.h"
#include "tests/support/shape_builders.h"

namespace occam::test {

/// Returns a rotation about z.
inline Mat4d turned(double angle)
{
    Mat4d m(1);
    m[0] = Vec4d(std::cos(angle), std::sin(angle), 0, 0);
    m[1] = Vec4d(-std::sin(angle), std::cos(angle), 0, 0);
    return m;
}

/// A strip of quads that two joints bend.
struct Bent {
    Scene scene;
    NodeId root_joint, tip_joint, skinned;
    SkinId skin;
    CageId cage;

    Bent()
    {
        Cage strip;
        for (int i = 0; i <= 4; ++i)
            for (int side = 0; side < 2; ++side) strip.positions.push_back({float(i), float(side), 0});
        for (std::uint32_t i = 0; i < 4; ++i) {
            strip.face_sizes.push_back(4);
            for (const std::uint32_t v : {2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1}) strip.face_vertices.push_back(v);
        }
        strip.skin.sets = 1;
        for (int i = 0; i <= 4; ++i)
            for (int side = 0; side < 2; ++side) {
                strip.skin.joints.push_back({0, 1, 0, 0});
                strip.skin.weights.push_back({1 - float(i) / 4, float(i) / 4, 0, 0});
            }
        cage = scene.add(strip);
        root_joint = scene.add_node(scene.root(), {.name = "root joint"});
        tip_joint = scene.add_node(root_joint, {.name = "tip joint", .matrix = moved(2, 0, 0)});
        skin = scene.add(Skin{"skin", {root_joint, tip_joint}, {Mat4d(1), moved(-2, 0, 0)}});
        skinned = scene.add_node(scene.root(), {.name = "skinned", .cages = {cage}, .skin = skin});
    }
};

}  // namespace occam::test
