// Builds small cages, for tests that need no data.
#pragma once

#include <cmath>

#include "scenegraph/scene.h"

namespace occam::test {

/// Returns a torus of quads about y. The steps around it are unequal, so that neighbours have different rates.
inline Cage torus(std::uint32_t around = 9, std::uint32_t across = 5, bool uneven = true)
{
    Cage cage;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = double(i) / around, v = double(j) / across;
            const double a = 6.283185307 * (uneven ? u + 0.1 * std::sin(6.283185307 * u) : u),
                         b = 6.283185307 * (uneven ? v * v : v);
            const double r = 1 + 0.4 * std::cos(b);
            cage.positions.push_back({float(r * std::cos(a)), float(0.4 * std::sin(b)), float(r * std::sin(a))});
            const std::uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
            cage.face_vertices.insert(cage.face_vertices.end(),
                                      {i * across + j, i * across + j1, i1 * across + j1, i1 * across + j});
            cage.face_sizes.push_back(4);
        }
    return cage;
}

/// Returns the torus as a mesh: each quad as two triangles.
inline Cage torus_mesh(std::uint32_t around, std::uint32_t across)
{
    const Cage quads = torus(around, across);
    Cage mesh;
    mesh.scheme = Scheme::Triangles;
    mesh.positions = quads.positions;
    for (std::size_t f = 0; f < quads.face_sizes.size(); ++f)
        for (const std::size_t k : {0, 1, 2, 0, 2, 3}) mesh.face_vertices.push_back(quads.face_vertices[4 * f + k]);
    return mesh;
}

/// Returns one quad from the origin to (1, 1, 0).
inline Cage unit_square()
{
    Cage cage;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    cage.face_sizes = {4};
    cage.face_vertices = {0, 1, 2, 3};
    return cage;
}

/// Returns a bilinear square over [-1, 1] in x and y that faces +z, with texture coordinates from 0 to 1.
inline Cage textured_square()
{
    Cage cage;
    cage.scheme = Scheme::Bilinear;
    cage.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    cage.face_sizes = {4};
    cage.face_vertices = {0, 1, 2, 3};
    cage.uv_sets = {{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}}};
    return cage;
}

/// Returns a translation.
inline Mat4d moved(double x, double y, double z)
{
    Mat4d m(1);
    m[3] = Vec4d(x, y, z, 1);
    return m;
}

/// Returns a prism over a polygon of n corners: two n-gons and n quads, with some creased edges.
inline Cage prism(std::uint32_t n)
{
    Cage cage;
    for (std::uint32_t k = 0; k < 2; ++k)
        for (std::uint32_t i = 0; i < n; ++i) {
            const double a = 6.283185307 * i / n;
            cage.positions.push_back({float(std::cos(a)), k ? 0.8f : -0.8f, float(-std::sin(a))});
        }
    cage.face_sizes = {n, n};
    for (std::uint32_t i = 0; i < n; ++i) cage.face_vertices.push_back(n - 1 - i);
    for (std::uint32_t i = 0; i < n; ++i) cage.face_vertices.push_back(n + i);
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n;
        cage.face_sizes.push_back(4);
        cage.face_vertices.insert(cage.face_vertices.end(), {i, j, n + j, n + i});
        cage.creases.push_back({n + i, n + j, i % 2 ? 10.0f : 1.5f});
    }
    return cage;
}

/// Returns a spindle of triangles with a pole of `valence` edges at both ends.
inline Cage spindle(std::uint32_t valence)
{
    Cage cage;
    cage.positions = {{0, 1.5f, 0}, {0, -1.5f, 0}};
    for (std::uint32_t i = 0; i < valence; ++i) {
        const float angle = 6.2831853f * float(i) / float(valence);
        cage.positions.push_back({std::cos(angle), 0.1f * float(i % 2), std::sin(angle)});
    }
    for (std::uint32_t i = 0; i < valence; ++i) {
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % valence;
        cage.face_vertices.insert(cage.face_vertices.end(), {0, b, a, 1, a, b});
        cage.face_sizes.insert(cage.face_sizes.end(), {3, 3});
    }
    return cage;
}

/// Returns a cube whose twelve edges have one sharpness.
inline Cage creased_cube(float sharpness)
{
    Cage cage;
    for (int i = 0; i < 8; ++i) cage.positions.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
    cage.face_vertices = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
    cage.face_sizes.assign(6, 4);
    for (std::uint32_t v = 0; v < 8; ++v)
        for (std::uint32_t axis = 1; axis < 8; axis *= 2)
            if ((v & axis) == 0 && sharpness > 0) cage.creases.push_back({v, v | axis, sharpness});
    return cage;
}

/// Returns a closed box of triangles from (-1, -1, -1) to (1, 1, 1), which is visible from inside and outside.
inline Cage triangle_box()
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (int i = 0; i < 8; ++i) cage.positions.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
    cage.face_vertices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                          2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    return cage;
}

/// Returns a level square of two triangles that faces up.
inline Cage level_square(float half)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{-half, 0, -half}, {half, 0, -half}, {half, 0, half}, {-half, 0, half}};
    cage.face_vertices = {0, 2, 1, 0, 3, 2};
    return cage;
}

inline NodeId place(Scene& scene, CageId cage, Vec3d at, double scale = 1)
{
    NodeDesc desc;
    desc.place.translation = at;
    desc.place.scale = Vec3d(scale);
    desc.cages = {cage};
    return scene.add_node(scene.root(), desc);
}

/// Adds a square lamp of 2 x 2 that shines down.
inline void add_lamp(Scene& scene, Vec3d at)
{
    NodeDesc lamp;
    lamp.place.translation = at;
    lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
    lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(6)}});
    scene.add_node(scene.root(), lamp);
}

}  // namespace occam::test
