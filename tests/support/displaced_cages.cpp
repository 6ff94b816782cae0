#include "tests/support/displaced_cages.h"

#include <algorithm>
#include <random>

#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Returns the torus of shape_builders with one chart, cut open once in each direction.
Cage torus_with_seams(bool creased)
{
    constexpr std::uint32_t kAround = 9, kAcross = 5;
    Cage cage = torus(kAround, kAcross);
    UvSet set;
    for (std::uint32_t i = 0; i <= kAround; ++i)
        for (std::uint32_t j = 0; j <= kAcross; ++j) set.values.push_back({float(i) * 0.37f, float(j) * 0.41f});
    for (std::uint32_t i = 0; i < kAround; ++i)
        for (std::uint32_t j = 0; j < kAcross; ++j)
            for (const auto& [di, dj] : {std::pair{0u, 0u}, {0u, 1u}, {1u, 1u}, {1u, 0u}})
                set.indices.push_back((i + di) * (kAcross + 1) + j + dj);
    cage.uv_sets = {set};
    for (std::uint32_t i = 0; creased && i < kAround; ++i)
        cage.creases.push_back({i * kAcross, (i + 1) % kAround * kAcross, i % 2 ? 10.0f : 1.3f});
    return cage;
}

Cage charted(Cage cage)
{
    add_charts(cage);
    return cage;
}

Cage creased_spindle()
{
    Cage cage = charted(spindle(9));
    cage.creases = {{0, 2, 10}, {2, 3, 2.5f}, {4, 1, 0.7f}, {3, 4, 10}};
    return cage;
}

}  // namespace

void add_charts(Cage& cage)
{
    UvSet set;
    for (const std::uint32_t size : cage.face_sizes)
        for (std::uint32_t k = 0; k < size; ++k) {
            const float angle = 6.2831853f * float(k) / float(size);
            set.indices.push_back(static_cast<std::uint32_t>(set.values.size()));
            set.values.push_back({0.5f + 0.45f * std::cos(angle), 0.5f + 0.45f * std::sin(angle)});
        }
    cage.uv_sets = {set};
}

void add_skin(Cage& cage)
{
    cage.skin.sets = 1;
    for (const Vec3f p : cage.positions) {
        const float second = std::clamp(0.5f + 0.5f * p.x, 0.0f, 1.0f);
        cage.skin.joints.push_back({0, 1, 0, 0});
        cage.skin.weights.push_back({1 - second, second, 0, 0});
    }
}

std::vector<Mat4d> bent_joints()
{
    Mat4d second(1);
    second[0] = {0.8, 0.6, 0, 0};
    second[1] = {-0.48, 0.64, 0.6, 0};
    second[2] = {0.36, -0.48, 0.8, 0};
    second[3] = {0.1, 0.3, -0.2, 1};
    return {Mat4d(1), second};
}

DisplacedCage::DisplacedCage(std::string called, Cage of, float bound, std::uint64_t seed, Displacement::Space space)
    : name(std::move(called)), cage(std::move(of)), textures(std::size_t(1) << 24)
{
    std::mt19937_64 random(seed);
    Texture noise;
    noise.role = TextureRole::Data;
    noise.width = noise.height = 64;
    const auto number = [&] { return float(random() >> 40) * 0x1p-24f; };
    for (int k = 0; k < 64 * 64; ++k) {
        const bool is_vector = space != Displacement::Space::Normal;
        const float x = number(), y = is_vector ? number() : x, z = is_vector ? number() : x;
        noise.pixels.push_back({x, y, z, 1});
    }
    Displacement displacement;
    displacement.texture.texture = scene.add(std::move(noise));
    displacement.scale = 2 * bound;
    displacement.bound = bound;
    displacement.space = space;
    cage.name = name;
    cage.displacement = displacement;
    textures.prepare(scene);
}

void set_texel(DisplacedCage& displaced, Vec3f texel)
{
    Texture full;
    full.width = full.height = 1;
    full.pixels = {Vec4f(texel, 1)};
    full.role = TextureRole::Data;
    displaced.cage.displacement->texture.texture = displaced.scene.add(full);
    displaced.textures.prepare(displaced.scene);
}

DisplacedCage displaced_case(int index)
{
    switch (index) {
        case 0:
            return {"torus", torus_with_seams(false), 0.04f, 1};
        case 1:
            return {"creased_torus", torus_with_seams(true), 0.06f, 2};
        case 2:
            return {"charted_torus", charted(torus()), 0.05f, 3};
        case 3:
            return {"creased_spindle", creased_spindle(), 0.03f, 4};
        case 4:
            return {"prism", charted(prism(7)), 0.04f, 5};
        case 5: {
            Cage bilinear = charted(prism(5));
            bilinear.scheme = Scheme::Bilinear;
            return {"bilinear_prism", std::move(bilinear), 0.02f, 6};
        }
        case 6:
            return {"creased_torus_by_vectors", torus_with_seams(true), 0.06f, 7, Displacement::Space::Object};
        case 7:
            return {"creased_spindle_by_vectors", creased_spindle(), 0.03f, 8, Displacement::Space::Object};
        case 8:
            return {"creased_torus_by_tangents", torus_with_seams(true), 0.06f, 9, Displacement::Space::Tangent};
        default:
            return {"creased_spindle_by_tangents", creased_spindle(), 0.03f, 10, Displacement::Space::Tangent};
    }
}

}  // namespace occam::test
