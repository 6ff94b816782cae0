// Tests that the cages of the built-in scene are sound, that it is the same each time, and that it shows what it should.
#include "io/builtin/builtin_scene.h"
#include "verify/verify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "base/hash.h"
#include "io/builtin/pieces.h"

namespace occam {
namespace {

// Returns the enclosed volume, by the divergence theorem over each face's fan. It is above zero if faces run
// counter-clockwise as seen from outside.
double volume(const Cage& cage)
{
    double sum = 0;
    std::size_t first = 0;
    for (const std::uint32_t n : cage.face_sizes) {
        const auto at = [&](std::size_t k) { return Vec3d(cage.positions[cage.face_vertices[first + k]]); };
        for (std::size_t k = 1; k + 1 < n; ++k) sum += glm::dot(at(0), glm::cross(at(k), at(k + 1))) / 6;
        first += n;
    }
    return sum;
}

TEST(BuiltinScene, ClosedPiecesAreClosedAndFaceOutwards)
{
    for (const Cage& cage : builtin::closed_pieces()) {
        EXPECT_EQ(why_not_closed(cage), "") << cage.name;
        EXPECT_GT(volume(cage), 0) << cage.name;
    }
}

TEST(BuiltinScene, EveryVertexOfAPieceHasOneFan)
{
    for (const Cage& cage : builtin::closed_pieces()) {
        // For a face (.., b, v, a, ..), next[v][a] is b. A fan is a cycle through all neighbours.
        std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> next;
        std::size_t first = 0;
        for (const std::uint32_t n : cage.face_sizes) {
            for (std::size_t k = 0; k < n; ++k) {
                const std::uint32_t* corners = cage.face_vertices.data() + first;
                next[corners[k]][corners[(k + 1) % n]] = corners[(k + n - 1) % n];
            }
            first += n;
        }
        EXPECT_EQ(next.size(), cage.positions.size()) << cage.name << " has vertices without a face";
        for (const auto& [vertex, turns] : next) {
            std::size_t steps = 0;
            std::uint32_t at = turns.begin()->first;
            do at = turns.at(at), ++steps;
            while (at != turns.begin()->first && steps <= turns.size());
            EXPECT_EQ(steps, turns.size()) << cage.name << ", vertex " << vertex;
        }
    }
}

TEST(BuiltinScene, NothingInItHasToBeMended) { EXPECT_EQ(builtin_scene().warnings, std::vector<std::string>()); }

TEST(BuiltinScene, ShowsCreasesPolesPolygonsTexturesAndInstances)
{
    const Scene scene = builtin_scene();
    std::set<std::uint32_t> face_sizes, valences;
    bool is_semi_sharp = false, is_sharp = false, has_instance = false, has_override = false;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        has_instance |= bool(node.instance_of);
        has_override |= !node.materials.empty();
        for (const CageId id : node.cages) {
            const Cage& cage = scene.cage(id).cage;
            face_sizes.insert(cage.face_sizes.begin(), cage.face_sizes.end());
            for (const Crease& c : cage.creases) (c.sharpness < kInfiniteSharpness ? is_semi_sharp : is_sharp) = true;
            std::vector<std::uint32_t> faces_at(cage.positions.size());
            for (const std::uint32_t v : cage.face_vertices) ++faces_at[v];
            valences.insert(faces_at.begin(), faces_at.end());
        }
    });
    EXPECT_TRUE(is_semi_sharp && is_sharp && has_instance && has_override);
    for (const std::uint32_t n : {3u, 4u, 5u, 6u, 12u}) EXPECT_TRUE(face_sizes.count(n)) << n << "-gons";
    for (const std::uint32_t n : {3u, 6u, 12u, 16u}) EXPECT_TRUE(valences.count(n)) << "valence " << n;
    EXPECT_GE(scene.texture_ids().size(), 4u);
    EXPECT_TRUE(scene.camera("main").has_value());
    EXPECT_EQ(scene.counts().lights, 2u);
}

std::uint64_t hash_of(const Scene& scene)
{
    std::uint64_t h = kFnvStart;
    const auto add = [&](const auto& values) { h = fnv1a(values.data(), values.size() * sizeof(values[0]), h); };
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
        h = fnv1a(&world_from_node, sizeof world_from_node, h);
        for (const CageId id : node.cages) {
            add(scene.cage(id).cage.positions);
            add(scene.cage(id).cage.face_vertices);
        }
    });
    for (const TextureId id : scene.texture_ids()) add(scene.texture(id).pixels);
    return h;
}

TEST(BuiltinScene, IsTheSameEachTime) { EXPECT_EQ(hash_of(builtin_scene()), hash_of(builtin_scene())); }

TEST(BuiltinScene, TexelsAreNumbersThatLightCanHave)
{
    const Scene scene = builtin_scene();
    for (const TextureId id : scene.texture_ids())
        for (const Vec4f& p : scene.texture(id).pixels)
            ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x < 100 && p.y < 100 && p.z < 100) << scene.texture(id).name;
}

}  // namespace
}  // namespace occam
