#include "verify/subject.h"

#include <algorithm>
#include <cmath>

#include "scenegraph/foreign_texture.h"

namespace occam {

Cage without_materials(Cage cage)
{
    cage.materials.clear();
    cage.face_slots.clear();
    return cage;
}

Subject::Subject(const ShownCage& shown, const TextureStore* textures, std::size_t size)
{
    add(shown);
    scene_.refit();
    const CageSlot& slot = scene_.cage(cage_);
    if (slot.cage.face_count() == 0) return;
    const lod::CageTables& tables = topologies_.get(slot);
    const Node& node = scene_.node(node_);
    const std::vector<Mat4d> moving = scene_.world_from_node_keys(node_);
    const Mat4d still = scene_.world_from_node(node_);
    const std::span<const Mat4d> matrices = moving.empty() ? std::span(&still, 1) : std::span(moving);
    // The frame's tolerance is that of exact paths, too.
    lod::LevelSettings exact;
    exact.motion_edges = 0;
    const auto pose = [&] {
        size_count_ = 0;
        lod::for_each_size({slot, node, node_, scene_.find(node.skin), matrices, scene_.shutter_segments()}, exact,
                           {tables, textures, pose_, deform_}, [&](const lod::PosedCage& posed) {
                               if (size_count_++ == size) posed_ = &posed;
                           });
    };
    pose();
    if (!posed_) return;
    exact.origin = posed_->anchor;  // as in the frame, whose eye is there
    pose();
    const lod::Topology& topology = *posed_->topology;
    for (std::uint32_t face = 0; face < topology.face_count(); ++face)
        for (std::uint32_t sub = 0; topology.is_seen(face) && sub < topology.patches_of(face); ++sub)
            patches_.push_back({{face, sub}, dicer_.scale(*posed_, {face, sub})});
}

// Adds the cage and its node, with joints below the root wherever they are in the other scene, and records their motion.
void Subject::add(const ShownCage& shown)
{
    cage_ = add_with_foreign_texture(scene_, without_materials(shown.slot.cage));
    const auto matrix_at = [&](std::size_t key) {
        return shown.world_from_object.size() > 1 ? shown.world_from_object[key] : shown.world_from_object[0];
    };
    NodeDesc desc{.matrix = matrix_at(0), .cages = {cage_}};
    if (shown.node) desc.morph_weights = shown.node->morph_weights;
    std::vector<NodeId> joints;
    const bool is_skinned = shown.skin && shown.slot.cage.skin.sets > 0;
    const bool moves = shown.segments > 0;
    const auto pose_at = [&](std::size_t key) {
        return lod::CagePose(shown.slot, *shown.node, shown.skin, moves ? static_cast<int>(key) : -1);
    };
    const auto joint_at = [&](const lod::CagePose& pose, std::size_t j, std::size_t key) {
        return matrix_at(key) * pose.node_from_skin * pose.joints[j];
    };
    if (is_skinned) {
        Skin skin;
        const lod::CagePose pose = pose_at(0);
        for (std::size_t j = 0; j < pose.joints.size(); ++j)
            skin.joints.push_back(scene_.add_node(scene_.root(), {.matrix = joint_at(pose, j, 0)}));
        joints = skin.joints;
        desc.skin = scene_.add(std::move(skin));
    }
    node_ = scene_.add_node(scene_.root(), desc);
    if (!moves) return;
    scene_.record_shutter(shown.segments, [&](double tau) {
        const auto key = static_cast<std::size_t>(tau * shown.segments);
        scene_.set_transform(node_, matrix_at(key));
        if (!shown.slot.key_positions.empty()) scene_.write_vertices(cage_, shown.slot.key_positions[key]);
        if (!shown.node) return;
        const lod::CagePose pose = pose_at(key);
        for (std::size_t j = 0; j < joints.size(); ++j) scene_.set_transform(joints[j], joint_at(pose, j, key));
        if (!shown.node->keys.empty()) scene_.set_morph_weights(node_, shown.node->keys[key].morph_weights);
    });
}

bool Subject::is_mirrored_at(float time) const noexcept
{
    const int segments = posed_->segments;
    return segments > 0 ? posed_->is_mirrored_at(lod::key_time(time, segments)) : posed_->is_mirrored;
}

std::vector<std::uint32_t> Subject::faces() const
{
    std::vector<std::uint32_t> faces;
    for (const Patch& patch : patches_)
        if (faces.empty() || faces.back() != patch.ref.face) faces.push_back(patch.ref.face);
    return faces;
}

std::span<const lod::LevelGrid> Subject::Pair::of_face(const std::vector<lod::LevelGrid>& grids, std::uint32_t face)
{
    const auto face_of = [](const lod::LevelGrid& grid) { return grid.tile.patch.face; };
    return {std::ranges::lower_bound(grids, face, {}, face_of), std::ranges::upper_bound(grids, face, {}, face_of)};
}

int Subject::level_of_rate(int rate) const
{
    int level = lod::kFinestLevel;
    for (const Patch& p : patches_) {
        const int exponent = static_cast<int>(std::log2(std::max(rate, 1)));
        level = std::max({level, p.scale.k[0] - exponent, p.scale.k[1] - exponent});
    }
    return std::max(level, posed_->finest_level());
}

lod::LevelGrid Subject::grid_at(const lod::TileRef& tile, const lod::PatchRates& coarser, float time)
{
    if (posed_->segments == 0) return dicer_.dice_pair(*posed_, tile, coarser, arena_);
    if (posed_->still_pose) return image_at(dicer_.dice_pair(*posed_->still_pose, tile, coarser, arena_), time);
    const lod::KeyTime at = lod::key_time(time, posed_->segments);
    lod::LevelGrid grid = dicer_.dice_pair(posed_->keys[at.key], tile, coarser, arena_);
    const lod::LevelGrid next = dicer_.dice_pair(posed_->keys[at.key + 1], tile, coarser, arena_);
    const bool blends = grid.blends();
    for (int a = 0; a < 3; ++a)
        for (int v = 0; v < grid.vertex_count; ++v) {
            grid.fine[a][v] = lod::between_keys(at.share, grid.fine[a][v], next.fine[a][v]);
            if (blends) grid.coarse[a][v] = lod::between_keys(at.share, grid.coarse[a][v], next.coarse[a][v]);
        }
    return grid;
}

lod::LevelGrid Subject::image_at(lod::LevelGrid grid, float time) const
{
    const lod::AffinePose pose = posed_->still_pose->affine->at(time);
    const auto move = [&](float* const(&p)[3], int v) {
        const Vec3d moved = pose.apply({p[0][v], p[1][v], p[2][v]});
        for (int a = 0; a < 3; ++a) p[a][v] = static_cast<float>(moved[a]);
    };
    const bool blends = grid.blends();
    for (int v = 0; v < grid.vertex_count; ++v) {
        move(grid.fine, v);
        if (blends) move(grid.coarse, v);
    }
    return grid;
}

Vec3d Subject::anchor_at(float time) const noexcept
{
    return posed_->still_pose ? posed_->still_pose->affine->at(time).anchor : posed_->anchor;
}

float Subject::radius_at(float time) const noexcept
{
    if (posed_->segments == 0) return posed_->radius;
    const int key = lod::key_time(time, posed_->segments).key;
    return std::max(posed_->keys[key].radius, posed_->keys[key + 1].radius);
}

std::size_t Subject::corner_count(int level) const
{
    std::size_t count = 0;
    for (const Patch& p : patches_) {
        const lod::PatchRates rates = p.scale.rates(level);
        count += std::size_t(6) << (rates.u + rates.v);
    }
    return count;
}

Subject::Pair Subject::dice(int level, float time)
{
    Pair pair;
    pair.level = level;
    for (const Patch& p : patches_) {
        const lod::PatchRates rates = p.scale.rates(level);
        for (std::uint32_t j = 0; j < 1u << rates.v; j += lod::TileRef::kMaxSide)
            for (std::uint32_t i = 0; i < 1u << rates.u; i += lod::TileRef::kMaxSide) {
                const lod::TileRef tile = lod::Dicer::tile(p.ref, p.scale, level, i, j);
                const lod::LevelGrid grid = grid_at(tile, p.scale.rates(level + 1), time);
                pair.grids.push_back(grid);
                if (!grid.hanging.empty()) pair.hanging.push_back(grid);
                for (int y = 0; y < tile.rows; ++y)
                    for (int x = 0; x < tile.columns; ++x)
                        for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
                            pair.corners.push_back(grid.vertex(x + dx, y + dy));
            }
    }
    return pair;
}

}  // namespace occam
