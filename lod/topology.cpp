#include "lod/topology.h"

#include <deque>
#include <mutex>
#include <unordered_map>
#include <unordered_set>

#include "base/cancellation.h"
#include "base/hash.h"
#include "lod/bfr_source.h"
#include "lod/class_memory.h"
#include "lod/ring_patch.h"
#include "lod/unsafe_faces.h"

namespace occam::lod {
namespace {

/// The number of faces that are visited between two looks at the request to stop.
constexpr std::uint32_t kFacesBetweenChecks = 4096;

/// The lists of patches with more control points than this are counted as tables are: those of other patches are in
/// proportion to the cage.
constexpr std::size_t kUsualControls = 64;

/// Returns a corner of a quad patch.
PatchPoint quad_corner(std::uint32_t face, std::uint32_t corner) noexcept
{
    constexpr float kU[4] = {0, 1, 1, 0}, kV[4] = {0, 0, 1, 1};
    return {{face, 0}, kU[corner], kV[corner]};
}

/// Returns the point at parameter s along edge j of a quad, counted from its corner j.
PatchPoint quad_edge(std::uint32_t face, int j, float s) noexcept
{
    switch (j) {
        case 0:
            return {{face, 0}, s, 0};
        case 1:
            return {{face, 0}, 1, s};
        case 2:
            return {{face, 0}, 1 - s, 1};
        default:
            return {{face, 0}, 0, 1 - s};
    }
}

}  // namespace

struct Topology::Tables {
    using Slots = std::vector<std::atomic<const PatchControls*>>;

    explicit Tables(std::shared_ptr<ClassMemory> shared) : memory(std::move(shared)), counted(*memory) {}

    std::shared_ptr<ClassMemory> memory;
    CountedBytes counted;  ///< lists that are no part of a class
    std::mutex mutex;
    std::vector<Slots> slots;  ///< slots[0] is for vertices and slots[1 + s] for UV set s; each has an entry for each patch
    std::unordered_map<std::vector<std::uint32_t>, std::unique_ptr<const PatchClass>, WordsHash> classes;
    std::unordered_set<std::vector<std::uint32_t>, WordsHash> counted_keys;  ///< tables_key() of surfaces that are counted
    std::deque<PatchControls> records;
    std::deque<std::vector<std::uint32_t>> indices;
    std::vector<std::uint32_t> first_inner;  ///< first inner curve of each face; empty when all faces are quads
    std::vector<std::uint32_t> inner_face;
    PatchClass linear{4, bilinear_source()};
};

Topology::Topology(const Cage& cage, std::shared_ptr<ClassMemory> memory)
    : tables_(std::make_unique<Tables>(memory ? std::move(memory) : std::make_shared<ClassMemory>())),
      mesh_(std::make_unique<Mesh>(cage, *tables_->memory))
{
    const auto& level = mesh_->level();
    face_count_ = static_cast<std::uint32_t>(level.GetNumFaces());
    edge_count_ = static_cast<std::uint32_t>(level.GetNumEdges());
    uv_set_count_ = static_cast<int>(cage.uv_sets.size());
    seen_.resize(face_count_);
    bool all_quads = true;
    for (std::uint32_t f = 0; f < face_count_; ++f) {
        if (f % kFacesBetweenChecks == 0) throw_if_cancelled();
        const int face = static_cast<int>(f);
        seen_[f] = mesh_->factory->FaceHasLimitSurface(face) && !level.IsFaceHole(face);
        all_quads &= face_size(f) == 4;
    }
    patch_count_ = face_count_;
    if (!all_quads) {
        patch_count_ = 0;
        std::uint32_t corners = 0;
        for (std::uint32_t f = 0; f < face_count_; ++f) {
            first_patch_.push_back(patch_count_);
            first_corner_.push_back(corners);
            corners += face_size(f);
            tables_->first_inner.push_back(inner_count_);
            patch_count_ += patches_of(f);
            if (face_size(f) == 4) continue;
            inner_count_ += face_size(f);
            tables_->inner_face.insert(tables_->inner_face.end(), face_size(f), f);
        }
    }
    for (int s = 0; s <= uv_set_count_; ++s) tables_->slots.emplace_back(patch_count_);
}

Topology::~Topology() = default;

std::uint32_t Topology::face_size(std::uint32_t face) const noexcept
{
    return static_cast<std::uint32_t>(mesh_->level().GetFaceVertices(static_cast<int>(face)).size());
}

std::uint32_t Topology::patch_index(PatchRef p) const noexcept
{
    return first_patch_.empty() ? p.face : first_patch_[p.face] + p.sub;
}

std::size_t Topology::derived_count() const noexcept { return mesh_->derived ? mesh_->derived->size() : 0; }

void Topology::derive(std::span<const Vec3f> vertices, std::span<Vec3f> out) const
{
    mesh_->derived->compute(vertices, out);
}

bool Topology::has_linear_uv(std::uint32_t face) const noexcept { return mesh_->derived && mesh_->derived->has_face(face); }

const PatchClass& Topology::linear_class() const noexcept { return tables_->linear; }

const PatchControls& Topology::controls(PatchRef patch) const
{
    const PatchControls* found = tables_->slots[0][patch_index(patch)].load(std::memory_order_acquire);
    return found ? *found : make_controls(patch, -1);
}

const PatchControls& Topology::uv_controls(PatchRef patch, int set) const
{
    const PatchControls* found = tables_->slots[set + 1][patch_index(patch)].load(std::memory_order_acquire);
    return found ? *found : make_controls(patch, set);
}

const PatchControls& Topology::make_controls(PatchRef patch, int uv_set) const
{
    throw_if_cancelled();
    if (uv_set < 0 && mesh_->derived && mesh_->derived->has_face(patch.face)) return make_derived_controls(patch);
    Neighbourhood around = neighbourhood(mesh_->level(), patch, mesh_->bilinear, uv_set);
    const std::lock_guard lock(tables_->mutex);
    const std::size_t key_bytes = around.key.size() * sizeof(std::uint32_t);
    auto& kind = tables_->classes[std::move(around.key)];
    if (!kind) {
        kind = make_class(patch, around, uv_set);
        kind->count(key_bytes);
    }
    return store(patch, uv_set, {kind.get(), {}}, std::move(around.controls));
}

std::unique_ptr<const PatchClass> Topology::make_class(PatchRef patch, const Neighbourhood& around, int uv_set) const
{
    ClassMemory& memory = *tables_->memory;
    memory.check_room();
    const int controls = static_cast<int>(around.controls.size());
    if (around.crease_depth == 0 && around.controls.size() <= kUsualControls) {
        auto source = limit_source(*mesh_->factory, patch, around.controls, uv_set, &memory);
        const std::size_t bytes = source->bytes();
        auto kind = std::make_unique<const PatchClass>(controls, std::move(source), 0, &memory);
        // Surfaces that are connected alike share their tables, though their patches may be of many classes.
        const bool is_shared = mesh_->shares_tables && !joins_border(mesh_->level(), static_cast<int>(patch.face));
        const bool is_new =
            !is_shared ||
            tables_->counted_keys.insert(tables_key(mesh_->level(), patch.face, mesh_->bilinear, uv_set)).second;
        if (is_new) kind->count(bytes);
        return kind;
    }
    const auto make = [&factory = *mesh_->creased_factory, patch, uv_set, indices = around.controls] {
        return limit_source(factory, patch, indices, uv_set);
    };
    return std::make_unique<const PatchClass>(controls, memory.pooled(make), around.crease_depth, &memory);
}

const PatchControls& Topology::make_derived_controls(PatchRef patch) const
{
    const DerivedPoints& points = *mesh_->derived;
    if (mesh_->bilinear) {
        const std::lock_guard lock(tables_->mutex);
        return store(patch, -1, {&tables_->linear, {}, true}, corner_points(points, patch));
    }
    auto ring = std::make_shared<RingPatch>(ring_patch(points, patch, mesh_->boundary));
    const std::lock_guard lock(tables_->mutex);
    const std::size_t key_bytes = ring->key.size() * sizeof(std::uint32_t);
    auto& kind = tables_->classes[std::move(ring->key)];
    if (!kind) {
        ClassMemory& memory = *tables_->memory;
        memory.check_room();
        auto source = memory.pooled([&points, ring] { return limit_source(points, *ring); });
        kind = std::make_unique<const PatchClass>(static_cast<int>(ring->controls.size()), std::move(source),
                                                  ring->crease_depth, &memory);
        kind->count(key_bytes + ring->bytes());
    }
    return store(patch, -1, {kind.get(), {}, true, ring->move_count()}, ring->controls);
}

const PatchControls& Topology::store(PatchRef patch, int uv_set, PatchControls record,
                                     std::vector<std::uint32_t> indices) const
{
    auto& slot = tables_->slots[static_cast<std::size_t>(uv_set + 1)][patch_index(patch)];
    if (const PatchControls* found = slot.load(std::memory_order_relaxed)) return *found;  // another thread was first
    if (indices.size() > kUsualControls) {
        tables_->memory->check_room();
        tables_->counted.add(indices.size() * sizeof(std::uint32_t));
    }
    record.indices = tables_->indices.emplace_back(std::move(indices));
    const PatchControls& stored = tables_->records.emplace_back(record);
    slot.store(&stored, std::memory_order_release);
    return stored;
}

SideCurve Topology::side(PatchRef patch, int side) const noexcept
{
    const auto& level = mesh_->level();
    const int face = static_cast<int>(patch.face);
    const auto edges = level.GetFaceEdges(face);
    const auto vertices = level.GetFaceVertices(face);
    const int n = vertices.size();
    const bool is_quad = n == 4;
    // Describes a part of base edge j of this face, from e0 to e1 as counted from corner j. The curve runs the other way if
    // it starts at the next corner.
    const auto on_edge = [&](int j, float e0, float e1) -> SideCurve {
        const bool forward = level.GetEdgeVertices(edges[j])[0] == vertices[j];
        return {static_cast<std::uint32_t>(edges[j]), forward ? e0 : 1 - e0, forward ? e1 : 1 - e1};
    };
    if (is_quad) return side < 2 ? on_edge(side, 0, 1) : on_edge(side, 1, 0);
    const int i = static_cast<int>(patch.sub), before = (i + n - 1) % n;
    const auto on_inner = [&](int j) -> SideCurve {
        return {edge_count_ + tables_->first_inner[patch.face] + static_cast<std::uint32_t>(j), 0, 1};
    };
    switch (side) {
        case 0:
            return on_edge(i, 0, 0.5f);
        case 1:
            return on_inner(i);
        case 2:
            return on_inner(before);
        default:
            return on_edge(before, 1, 0.5f);
    }
}

PatchPoint Topology::curve_point(std::uint32_t curve, float c) const noexcept
{
    if (curve >= edge_count_) {
        const std::uint32_t inner = curve - edge_count_, face = tables_->inner_face[inner];
        return {{face, inner - tables_->first_inner[face]}, 1, c};
    }
    const auto& level = mesh_->level();
    const int edge = static_cast<int>(curve);
    const std::uint32_t face = mesh_->edge_owner[curve];
    const auto edges = level.GetFaceEdges(static_cast<int>(face));
    const auto vertices = level.GetFaceVertices(static_cast<int>(face));
    int j = 0;
    while (edges[j] != edge) ++j;
    const float s = level.GetEdgeVertices(edge)[0] == vertices[j] ? c : 1 - c;
    const int n = vertices.size();
    if (n == 4) return quad_edge(face, j, s);
    if (s <= 0.5f) return {{face, static_cast<std::uint32_t>(j)}, 2 * s, 0};
    return {{face, static_cast<std::uint32_t>((j + 1) % n)}, 0, 2 * (1 - s)};
}

std::uint32_t Topology::end_vertex(std::uint32_t edge, int end) const noexcept
{
    return static_cast<std::uint32_t>(mesh_->level().GetEdgeVertices(static_cast<int>(edge))[end]);
}

std::array<std::uint32_t, 4> Topology::quad_vertices(std::uint32_t face) const noexcept
{
    const auto vertices = mesh_->level().GetFaceVertices(static_cast<int>(face));
    std::array<std::uint32_t, 4> quad;
    for (int i = 0; i < 4; ++i) quad[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(vertices[i]);
    return quad;
}

PatchPoint Topology::vertex_point(std::uint32_t vertex) const noexcept
{
    const std::uint32_t face = mesh_->vertex_owner[vertex];
    std::uint32_t corner = mesh_->vertex_corner[vertex];
    if (corner == 0xff) {
        const auto vertices = mesh_->level().GetFaceVertices(static_cast<int>(face));
        while (static_cast<std::uint32_t>(vertices[static_cast<int>(corner)]) != vertex) ++corner;
    }
    return face_size(face) == 4 ? quad_corner(face, corner) : PatchPoint{{face, corner}, 0, 0};
}

std::uint32_t Topology::base_edge(std::uint32_t inner_curve) const noexcept
{
    const std::uint32_t inner = inner_curve - edge_count_, face = tables_->inner_face[inner];
    const auto edges = mesh_->level().GetFaceEdges(static_cast<int>(face));
    return static_cast<std::uint32_t>(edges[static_cast<int>(inner - tables_->first_inner[face])]);
}

int Topology::least_exponent(std::uint32_t curve) const noexcept
{
    if (curve >= edge_count_) return 0;
    for (const int f : mesh_->level().GetEdgeFaces(static_cast<int>(curve)))
        if (mesh_->level().GetFaceVertices(f).size() != 4) return 1;
    return 0;
}

bool Topology::has_middle_knot(std::uint32_t curve) const noexcept
{
    return curve < edge_count_ && face_size(mesh_->edge_owner[curve]) != 4;
}

}  // namespace occam::lod
