#include "tests/support/diced_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "lod/pose_cage.h"
#include "lod/posed_patch.h"
#include "scenegraph/foreign_texture.h"

namespace occam::test {

DicedCage::DicedCage(const Cage& cage, int level, const Mat4d& world_from_object, const TextureStore* textures,
                     std::span<const Mat4d> joints)
{
    const CageId id = add_with_foreign_texture(scene_, cage);
    NodeDesc desc{.matrix = world_from_object, .cages = {id}};
    Skin skin;
    for (const Mat4d& joint : joints) skin.joints.push_back(scene_.add_node(scene_.root(), {.matrix = joint}));
    if (!joints.empty()) desc.skin = scene_.add(skin);
    const NodeId node = scene_.add_node(scene_.root(), desc);
    scene_.refit();
    const CageSlot& slot = scene_.cage(id);
    const lod::CageTables& tables = cache_.get(slot);
    const Node& shown = scene_.node(node);
    posed = lod::pose_cage({slot, shown, node, scene_.find(shown.skin), {&world_from_object, 1}}, {},
                           {tables, textures, pose_, deform_});
    posed.level = level;
}

std::vector<lod::TileRef> DicedCage::tiles()
{
    std::vector<lod::TileRef> all;
    for (std::uint32_t face = 0; face < topology().face_count(); ++face) {
        if (!topology().is_seen(face)) continue;
        for (std::uint32_t sub = 0; sub < topology().patches_of(face); ++sub) {
            const lod::PatchRates rates = dicer.scale(posed, {face, sub}).rates(posed.level);
            const int columns = 1 << rates.u, rows = 1 << rates.v, side = lod::TileRef::kMaxSide;
            for (int j = 0; j < rows; j += side)
                for (int i = 0; i < columns; i += side) {
                    const auto size = [&](int whole) { return static_cast<std::uint16_t>(std::min(whole, side)); };
                    all.push_back({{face, sub},
                                   rates,
                                   static_cast<std::uint32_t>(i),
                                   static_cast<std::uint32_t>(j),
                                   size(columns),
                                   size(rows)});
                }
        }
    }
    return all;
}

std::vector<MeshTriangle> DicedCage::triangles()
{
    std::vector<MeshTriangle> mesh;
    std::vector<lod::Hanging::Ends>
        known;  // gap triangles of the current patch, since each tile that one reaches into keeps a copy of it
    lod::PatchRef patch{~0u, 0};
    for (const lod::TileRef& tile : tiles()) {
        if (!(tile.patch == patch)) known.clear();
        patch = tile.patch;
        const lod::LevelGrid grid = dicer.dice(posed, tile, arena);
        for (int j = 0; j < tile.rows; ++j)
            for (int i = 0; i < tile.columns; ++i) {
                mesh.push_back({{grid.vertex(i, j), grid.vertex(i + 1, j), grid.vertex(i + 1, j + 1)}});
                mesh.push_back({{grid.vertex(i, j), grid.vertex(i + 1, j + 1), grid.vertex(i, j + 1)}});
            }
        for (const lod::Hanging& h : grid.hanging) {
            const lod::Hanging::Ends ends = h.on(grid.at(static_cast<int>(h.a)), grid.at(static_cast<int>(h.c)));
            const auto same = [&](const lod::Hanging::Ends& k) {
                return k.low == ends.low && k.middle == ends.middle && k.high == ends.high;
            };
            if (std::any_of(known.begin(), known.end(), same)) continue;
            known.push_back(ends);
            mesh.push_back({{ends.low, ends.middle, ends.high}, true});
        }
    }
    return mesh;
}

int DicedCage::level_of_largest_exponent(int exponent)
{
    dicer.forget();
    // From coarse to fine, exponents rise by one at each level, once they have left their least value.
    for (posed.level = std::ilogb(posed.radius) + 4;; --posed.level) {
        int largest = 0;
        for (const lod::TileRef& tile : tiles()) largest = std::max({largest, tile.rates.u, tile.rates.v});
        if (largest >= exponent) return posed.level;
    }
}

Bits bits_of(Vec3f p)
{
    return {std::bit_cast<std::uint32_t>(p.x + 0.0f), std::bit_cast<std::uint32_t>(p.y + 0.0f),
            std::bit_cast<std::uint32_t>(p.z + 0.0f)};
}

bool has_finite_surface(const DicedCage& diced)
{
    const lod::Topology& topology = diced.topology();
    lod::PosedPatch patch;
    bool is_finite = true;
    for (std::uint32_t f = 0; f < topology.face_count(); ++f) {
        if (!topology.is_seen(f)) continue;
        for (std::uint32_t sub = 0; sub < topology.patches_of(f); ++sub) {
            patch.set(diced.posed, {f, sub});
            float values[9][4];
            float* const rows[9] = {values[0], values[1], values[2], values[3], values[4],
                                    values[5], values[6], values[7], values[8]};
            patch.points_and_tangents({0, 0, 1, 1, 2, 2}, rows, 2);
            for (const auto& row : values)
                is_finite &= std::all_of(std::begin(row), std::end(row), [](float value) { return std::isfinite(value); });
            for (int set = 0; set < topology.uv_set_count() && !topology.has_linear_uv(f); ++set)
                is_finite &= !topology.uv_controls({f, sub}, set).indices.empty();
        }
    }
    return is_finite;
}

std::size_t open_edges(const std::vector<MeshTriangle>& mesh)
{
    std::map<std::pair<Bits, Bits>, int> uses;
    for (const MeshTriangle& t : mesh) {
        const std::array<Bits, 3> v{bits_of(t.v[0]), bits_of(t.v[1]), bits_of(t.v[2])};
        for (int k = 0; k < 3; ++k) {
            const Bits& a = v[k];
            const Bits& b = v[(k + 1) % 3];
            if (a != b) ++uses[{std::min(a, b), std::max(a, b)}];
        }
    }
    std::size_t open = 0;
    for (const auto& [edge, count] : uses) open += count & 1;
    return open;
}

}  // namespace occam::test
