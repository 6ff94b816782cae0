#include "tests/support/motions.h"

#include <cmath>

#include "lod/topology_cache.h"
#include "tests/support/shape_builders.h"

namespace occam::test {

Mat4d moved_by(Vec3d by) { return moved(by.x, by.y, by.z); }
Mat4d scaled_by(Vec3d by)
{
    Mat4d m(1);
    for (int a = 0; a < 3; ++a) m[a][a] = by[a];
    return m;
}

namespace {

/// Turns about an axis that is none of the coordinate axes.
Mat4d turned_by(double angle)
{
    const Vec3d n = glm::normalize(Vec3d(1, 2, -0.5));
    const double c = std::cos(angle), s = std::sin(angle);
    Mat4d m(1);
    for (int a = 0; a < 3; ++a) {
        Vec3d e(0);
        e[a] = 1;
        m[a] = Vec4d(e * c + glm::cross(n, e) * s + n * (glm::dot(n, e) * (1 - c)), 0);
    }
    return m;
}

Cage with_deformation(Cage cage, const Motion& motion)
{
    if (motion.upper_joint) {
        cage.skin.sets = 1;
        for (const Vec3f p : cage.positions) {
            const float up = std::clamp(0.5f + 0.5f * p.y, 0.0f, 1.0f);
            cage.skin.joints.push_back({0, 1, 0, 0});
            cage.skin.weights.push_back({1 - up, up, 0, 0});
        }
    }
    if (motion.morph) {
        MorphTarget swollen;
        for (const Vec3f p : cage.positions) swollen.positions.push_back(p * Vec3f(0.6f, 0.1f, -0.3f));
        cage.morph_targets.push_back(std::move(swollen));
        cage.morph_weights = {0};
    }
    return cage;
}

}  // namespace

std::vector<Motion> motions()
{
    const auto of_matrix = [](const char* name, int segments, std::function<Mat4d(double)> matrix) {
        return Motion{name, segments, std::move(matrix), {}, {}, {}};
    };
    std::vector<Motion> all;
    all.push_back(of_matrix("translating", 1, [](double tau) { return moved_by(Vec3d(6, -3, 7) * tau); }));
    all.push_back(of_matrix("rotating_in_one", 1, [](double tau) { return turned_by(2.1 * tau); }));
    all.push_back(of_matrix("rotating_in_four", 4, [](double tau) { return turned_by(3.1 * tau); }));
    all.push_back(of_matrix("scaling", 1, [](double tau) { return scaled_by(Vec3d(0.25 + 0.75 * tau)); }));
    all.push_back(of_matrix("shearing", 2, [](double tau) {
        Mat4d m = scaled_by(Vec3d(1, 1 - 0.95 * tau, 1));
        m[2].x = 2 * tau;
        return m;
    }));
    all.push_back(of_matrix("collapsing", 1, [](double tau) { return scaled_by(Vec3d(1 - tau)); }));
    all.push_back(of_matrix("inverting", 1, [](double tau) { return scaled_by(Vec3d(1 - 2 * tau)); }));
    all.push_back(of_matrix("jumping", 1, [](double tau) { return moved_by(Vec3d(30, 0, -30) * tau); }));
    all.push_back({"bending",
                   4,
                   {},
                   [](Vec3f p, double tau) {
                       const auto a = static_cast<float>(tau) * p.y;
                       return Vec3f(p.x * std::cos(a) - p.y * std::sin(a), p.x * std::sin(a) + p.y * std::cos(a), p.z);
                   },
                   {},
                   {}});
    all.push_back({"skinned",
                   4,
                   [](double tau) { return moved_by(Vec3d(tau, 0, 0)); },
                   {},
                   [](double tau) { return turned_by(1.5 * tau); },
                   {}});
    all.push_back({"morphed", 2, {}, {}, {}, [](double tau) { return static_cast<float>(tau * tau); }});
    all.push_back({"morphed_and_rotating",
                   4,
                   [](double tau) { return turned_by(tau); },
                   {},
                   {},
                   [](double tau) { return static_cast<float>(tau); }});
    return all;
}

NodeId add_moving(Scene& scene, const Cage& cage, const Motion& motion, const Mat4d& place)
{
    const CageId id = scene.add(with_deformation(cage, motion));
    NodeDesc desc{.matrix = place, .cages = {id}};
    NodeId upper;
    if (motion.upper_joint) {
        Skin skin;
        skin.joints = {scene.add_node(scene.root(), {.matrix = place}), scene.add_node(scene.root(), {.matrix = place})};
        upper = skin.joints[1];
        desc.skin = scene.add(std::move(skin));
    }
    const NodeId node = scene.add_node(scene.root(), desc);
    const std::vector<Vec3f> rest = scene.cage(id).cage.positions;
    scene.record_shutter(motion.segments, [&](double tau) {
        if (motion.matrix && !motion.upper_joint) scene.set_transform(node, place * motion.matrix(tau));
        if (motion.upper_joint) scene.set_transform(upper, place * motion.upper_joint(tau));
        if (motion.morph) scene.set_morph_weights(node, {motion.morph(tau)});
        if (!motion.vertex) return;
        std::vector<Vec3f> moved;
        for (const Vec3f p : rest) moved.push_back(motion.vertex(p, tau));
        scene.write_vertices(id, moved);
    });
    return node;
}

DicedMotion::DicedMotion(const Scene& scene, NodeId id, int level) : segments_(scene.shutter_segments())
{
    const Node& node = scene.node(id);
    const CageSlot& slot = scene.cage(node.cages.front());
    lod::TopologyCache topologies;
    const lod::CageTables& tables = topologies.get(slot);
    lod::PosedCage still;
    still.slot = &slot;
    still.topology = tables.topology.get();
    still.clusters = tables.clusters.get();
    still.node = &node;
    const std::vector<Mat4d> moving = scene.world_from_node_keys(id);
    const Mat4d placed = scene.world_from_node(id);
    const std::span<const Mat4d> matrices = moving.empty() ? std::span(&placed, 1) : std::span(moving);
    const lod::CageMotion motion(slot, node, scene.find(node.skin), matrices, segments_);
    Arena arena;
    lod::DeformCounters counters;
    const lod::PosedCage& posed = motion.make_keys(still, segments_, {tables, nullptr, arena, counters});
    lod::Dicer dicer;
    for (int key = 0; key <= segments_; ++key) {
        const lod::PosedCage& at = posed.keys[key];
        std::vector<Vec3d>& corners = keys_.emplace_back();
        const auto add = [&](Vec3f p) { corners.push_back(at.anchor + Vec3d(p)); };
        if (!posed.topology) {
            for (const std::uint32_t v : slot.cage.face_vertices) add(at.vertex(v));
            continue;
        }
        for (std::uint32_t face = 0; face < posed.topology->face_count(); ++face)
            for (std::uint32_t sub = 0; posed.topology->is_seen(face) && sub < posed.topology->patches_of(face); ++sub) {
                const lod::PatchScale scale = dicer.scale(posed, {face, sub});
                const lod::PatchRates rates = scale.rates(level);
                for (std::uint32_t j = 0; j < 1u << rates.v; j += lod::TileRef::kMaxSide)
                    for (std::uint32_t i = 0; i < 1u << rates.u; i += lod::TileRef::kMaxSide) {
                        const lod::LevelGrid grid = dicer.dice(at, lod::Dicer::tile({face, sub}, scale, level, i, j), arena);
                        for (int y = 0; y < grid.tile.rows; ++y)
                            for (int x = 0; x < grid.tile.columns; ++x)
                                for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
                                    add(grid.vertex(x + dx, y + dy));
                    }
            }
    }
}

std::vector<Vec3d> DicedMotion::corners_at(double tau) const
{
    const int key = std::min(static_cast<int>(tau * segments_), segments_ - 1);
    const double share = tau * segments_ - key;
    const std::vector<Vec3d>&a = keys_[std::size_t(key)], &b = keys_[std::size_t(key) + 1];
    std::vector<Vec3d> at;
    for (std::size_t k = 0; k < a.size(); ++k) at.push_back(glm::mix(a[k], b[k], share));
    return at;
}

}  // namespace occam::test
