#include "lod/extent.h"

#include <algorithm>
#include <unordered_map>

#include "base/arena.h"
#include "lod/deformed_cage.h"
#include "lod/refined_point.h"
#include "lod/topology_mesh.h"

namespace occam::lod {
namespace {

using namespace OpenSubdiv;

// A cage is refined as often as this number of faces allows, but at most kMostLevels times. Each time the distance between
// the surface and the hull of its control points falls to a quarter.
constexpr std::size_t kMostFaces = 60'000;
constexpr int kMostLevels = 3;
// Once refined cages have this many points, further cages give their vertices. A point of a cage that is deformed counts as
// several, since it is computed again for each pose.
constexpr std::size_t kMostRefined = 2'000'000, kWeightOfDeformed = 8;
// Beyond this many points in all, placed cages give the corners of their boxes.
constexpr std::size_t kMostPoints = 50'000'000;
constexpr std::size_t kMostPlacements = 1'000'000;

// Visits the corners of a box under an affine map.
void visit_corners(const Box3d& box, const Mat4d& world_from_box, const std::function<void(Vec3d)>& visit)
{
    if (box.is_empty()) return;
    for (int i = 0; i < 8; ++i)
        visit(transform_point(world_from_box,
                              Vec3d(i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z)));
}

}  // namespace

struct Extent::State {
    // Holds the connectivity of a cage at the level that gives the points.
    struct Shape {
        std::uint64_t identity = 0, version = 0;
        std::size_t refined = 0;                        // number of points that count, if it was refined
        std::unique_ptr<Far::TopologyRefiner> refiner;  // null if the vertices themselves are the points
        std::vector<std::uint32_t> used;                // vertices of faces that are visible
        std::vector<Vec3d> still;                       // points of a cage that nothing deforms, in object axes; for such
                                                        // a cage this is all that is kept
    };

    Shape& shape_of(CageId id, const CageSlot& slot);
    static std::vector<Vec3d> points_of(const Shape& shape, const std::vector<Vec3d>& controls);

    std::unordered_map<CageId, Shape> shapes;
    std::size_t points = 0;   // number of points in one visit
    std::size_t refined = 0;  // the sum of Shape::refined
};

Extent::State::Shape& Extent::State::shape_of(CageId id, const CageSlot& slot)
{
    Shape& shape = shapes[id];
    const bool is_made = !shape.used.empty() || !shape.still.empty();
    if (shape.identity == slot.identity && shape.version == slot.positions_version && is_made) return shape;
    const bool was_refined = shape.refined > 0;  // then it is again, so that a sequence is framed in one way
    // The shape is kept when it is whole. If there is no memory for all of it, it is made anew when it is next asked for.
    Shape made{slot.identity, slot.positions_version, 0, nullptr, {}, {}};
    const auto keep = [&]() -> Shape& {
        refined += made.refined - shape.refined;
        return shape = std::move(made);
    };
    const Cage& cage = slot.cage;
    std::vector<bool> is_used(cage.positions.size());
    int levels = 0;
    if (cage.scheme == Scheme::CatmullClark && cage.face_count() > 0 && (was_refined || refined < kMostRefined))
        for (std::size_t n = cage.face_vertices.size(); levels < kMostLevels && n <= kMostFaces; n *= 4) ++levels;
    if (levels > 0) {
        made.refiner = make_refiner(cage);
        made.refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(levels));
        const Far::TopologyLevel& finest = made.refiner->GetLevel(made.refiner->GetMaxLevel());
        is_used.assign(std::size_t(finest.GetNumVertices()), false);
        made.refined = is_used.size() * (slot.is_deformed() ? kWeightOfDeformed : 1);
        for (int f = 0; f < finest.GetNumFaces(); ++f)
            for (int k = 0; k < finest.GetFaceVertices(f).size() && !finest.IsFaceHole(f); ++k)
                is_used[std::size_t(finest.GetFaceVertices(f)[k])] = true;
    } else {
        for (const std::uint32_t v : cage.face_vertices) is_used[v] = true;
    }
    for (std::uint32_t v = 0; v < is_used.size(); ++v)
        if (is_used[v]) made.used.push_back(v);
    if (slot.is_deformed()) return keep();
    made.still = points_of(made, {cage.positions.begin(), cage.positions.end()});
    made.used = std::vector<std::uint32_t>();  // assigning {} would keep its memory
    made.refiner.reset();
    return keep();
}

std::vector<Vec3d> Extent::State::points_of(const Shape& shape, const std::vector<Vec3d>& controls)
{
    std::vector<RefinedPoint> points(controls.size());
    for (std::size_t i = 0; i < controls.size(); ++i) points[i].p = controls[i];
    if (shape.refiner) {
        const Far::PrimvarRefiner primvars(*shape.refiner);
        for (int level = 1; level <= shape.refiner->GetMaxLevel(); ++level) {
            std::vector<RefinedPoint> finer(std::size_t(shape.refiner->GetLevel(level).GetNumVertices()));
            primvars.Interpolate(level, points, finer);
            points.swap(finer);
        }
    }
    std::vector<Vec3d> out;
    out.reserve(shape.used.size());
    for (const std::uint32_t v : shape.used) out.push_back(points[v].p);
    return out;
}

Extent::Extent() : state_(std::make_unique<State>()) {}
Extent::~Extent() = default;

void Extent::visit_points(const Scene& scene, const std::function<void(Vec3d)>& visit)
{
    State& s = *state_;
    s.points = 0;
    std::size_t visits = 0;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
        // Instances of instances may be more than can be visited: from then on, subtrees give the corners of their boxes.
        if (++visits > kMostPlacements && !node.dirty) {
            visit_corners(node.bounds, world_from_node, visit);
            return false;
        }
        // What is hidden from the camera hides all that is below it, and its instances.
        if (!(node.seen_by & RayKind::Camera)) return false;
        const SkinSlot* skin = scene.find(node.skin);
        for (const CageId id : node.cages) {
            const CageSlot* slot = scene.find(id);
            if (!slot) continue;
            if (slot->is_on_demand() || slot->cage.is_displaced() || s.points > kMostPoints) {
                visit_corners(cage_bounds(node, *slot, skin), world_from_node, visit);
                continue;
            }
            const State::Shape& shape = s.shape_of(id, *slot);
            s.points += std::max(shape.still.size(), shape.used.size());
            if (!slot->is_deformed()) {
                for (const Vec3d p : shape.still) visit(transform_point(world_from_node, p));
                continue;
            }
            constexpr double kNode[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
            Arena arena;
            DeformCounters counters;
            DeformedCage deformed(*slot, CagePose(*slot, node, skin), kNode, arena, counters);
            std::vector<Vec3d> controls(slot->cage.positions.size());
            for (std::uint32_t v = 0; v < controls.size(); ++v) controls[v] = Vec3d(deformed.position(v));
            for (const Vec3d p : State::points_of(shape, controls)) visit(transform_point(world_from_node, p));
        }
        return true;
    });
}

}  // namespace occam::lod
