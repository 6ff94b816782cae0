#include "lod/topology_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <unordered_map>

#include <opensubdiv/sdc/crease.h>

#include "base/error_without_file.h"
#include "lod/derived_points.h"
#include "lod/fan_limits.h"
#include "lod/unsafe_faces.h"
#include "scenegraph/content_rules.h"

namespace occam::lod {

using namespace OpenSubdiv;

Sdc::Options::FVarLinearInterpolation linear_interpolation(FaceVaryingRule rule) noexcept
{
    switch (rule) {
        case FaceVaryingRule::CornersPlus1:
            return Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1;
        case FaceVaryingRule::CornersPlus2:
            return Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2;
        case FaceVaryingRule::CornersOnly:
            return Sdc::Options::FVAR_LINEAR_CORNERS_ONLY;
        case FaceVaryingRule::Boundaries:
            return Sdc::Options::FVAR_LINEAR_BOUNDARIES;
        case FaceVaryingRule::All:
            return Sdc::Options::FVAR_LINEAR_ALL;
        case FaceVaryingRule::None:
            break;
    }
    return Sdc::Options::FVAR_LINEAR_NONE;
}

namespace {

Sdc::Options sdc_options(const Cage& cage)
{
    Sdc::Options options;
    switch (cage.boundary) {
        case BoundaryRule::EdgeAndCorner:
            options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
            break;
        case BoundaryRule::EdgeOnly:
            options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
            break;
        case BoundaryRule::None:
            options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_NONE);
            break;
    }
    options.SetFVarLinearInterpolation(linear_interpolation(cage.face_varying));
    return options;
}

// Numbers values in the order in which they first occur. Rings are small; poles of hundreds of edges get a map.
class Numbering {
public:
    explicit Numbering(std::vector<std::uint32_t>& values) : values_(values) { values_.reserve(kUsual); }

    std::uint32_t of(std::uint32_t value)
    {
        if (values_.size() <= kLinear) {
            // Most values occur several times, and few of a ring have the same last bits.
            std::uint8_t& latest = latest_[value % latest_.size()];
            if (latest < values_.size() && values_[latest] == value) return latest;
            for (std::uint32_t i = 0; i < values_.size(); ++i)
                if (values_[i] == value) return i;
            latest = static_cast<std::uint8_t>(values_.size());
            values_.push_back(value);
            if (values_.size() > kLinear)
                for (std::uint32_t i = 0; i < values_.size(); ++i) map_.emplace(values_[i], i);
            return static_cast<std::uint32_t>(values_.size() - 1);
        }
        const auto [at, is_new] = map_.emplace(value, static_cast<std::uint32_t>(values_.size()));
        if (is_new) values_.push_back(value);
        return at->second;
    }

private:
    static constexpr std::size_t kLinear = 48, kUsual = 16;
    std::vector<std::uint32_t>& values_;
    std::array<std::uint8_t, 64> latest_{};  // the latest number that was given to a value with these last bits
    std::unordered_map<std::uint32_t, std::uint32_t> map_;
};

/// Makes refiners as the factory of the library does, which loses them if there is not enough memory.
class RefinerFactory : public Far::TopologyRefinerFactory<Far::TopologyDescriptor> {
public:
    static std::unique_ptr<Far::TopologyRefiner> make(const Far::TopologyDescriptor& of, const Options& options)
    {
        auto refiner = std::make_unique<Far::TopologyRefiner>(options.schemeType, options.schemeOptions);
        if (!populateBaseLevel(*refiner, of, options)) refiner.reset();
        return refiner;
    }
};

/// Sets the corners of a description, which borrows them.
void describe_corners(Far::TopologyDescriptor& d, const std::vector<int>& vertices, const std::vector<float>& weights)
{
    d.numCorners = static_cast<int>(weights.size());
    d.cornerVertexIndices = vertices.data();
    d.cornerWeights = weights.data();
}

}  // namespace

std::unique_ptr<Far::TopologyRefiner> make_refiner(const Cage& cage)
{
    const std::vector<int> sizes(cage.face_sizes.begin(), cage.face_sizes.end());
    const std::vector<int> vertices(cage.face_vertices.begin(), cage.face_vertices.end());
    const std::vector<int> holes(cage.holes.begin(), cage.holes.end());
    std::vector<int> crease_pairs, corner_vertices;
    std::vector<float> crease_weights, corner_weights;
    for (const Crease& c : cage.creases) {
        crease_pairs.insert(crease_pairs.end(), {static_cast<int>(c.v0), static_cast<int>(c.v1)});
        crease_weights.push_back(c.sharpness);
    }
    for (const Corner& c : cage.corners) {
        corner_vertices.push_back(static_cast<int>(c.vertex));
        corner_weights.push_back(c.sharpness);
    }
    std::vector<std::vector<int>> uv_indices(cage.uv_sets.size());
    std::vector<Far::TopologyDescriptor::FVarChannel> channels(cage.uv_sets.size());
    for (std::size_t s = 0; s < channels.size(); ++s) {
        const UvSet& set = cage.uv_sets[s];
        const auto& from = set.indices.empty() ? cage.face_vertices : set.indices;
        uv_indices[s].assign(from.begin(), from.end());
        channels[s].numValues = static_cast<int>(set.values.size());
        channels[s].valueIndices = uv_indices[s].data();
    }

    Far::TopologyDescriptor d;
    d.numVertices = static_cast<int>(cage.positions.size());
    d.numFaces = static_cast<int>(sizes.size());
    d.numVertsPerFace = sizes.data();
    d.vertIndicesPerFace = vertices.data();
    d.numCreases = static_cast<int>(crease_weights.size());
    d.creaseVertexIndexPairs = crease_pairs.data();
    d.creaseWeights = crease_weights.data();
    describe_corners(d, corner_vertices, corner_weights);
    d.numHoles = static_cast<int>(holes.size());
    d.holeIndices = holes.data();
    d.numFVarChannels = static_cast<int>(channels.size());
    d.fvarChannels = channels.data();
    const bool is_bilinear = cage.scheme == Scheme::Bilinear;
    const RefinerFactory::Options options{is_bilinear ? Sdc::SCHEME_BILINEAR : Sdc::SCHEME_CATMARK, sdc_options(cage)};
    auto refiner = RefinerFactory::make(d, options);
    if (!refiner) throw error_without_file("the cage is beyond what can be refined", naming("cage", cage.name));
    if (is_bilinear) return refiner;
    const std::vector<int> held = vertices_without_one_limit(refiner->GetLevel(0));
    if (held.empty()) return refiner;
    corner_vertices.insert(corner_vertices.end(), held.begin(), held.end());
    corner_weights.insert(corner_weights.end(), held.size(), kInfiniteSharpness);
    describe_corners(d, corner_vertices, corner_weights);
    return RefinerFactory::make(d, options);
}

void refine_once(Far::TopologyRefiner& refiner)
{
    Far::TopologyRefiner::UniformOptions options(1);
    options.fullTopologyInLastLevel = true;
    refiner.RefineUniform(options);
}

std::unique_ptr<const SurfaceFactory> make_factory(const Far::TopologyRefiner& refiner, bool keeps)
{
    // Bfr's defaults (2, 6) do not give the limit surface: positions are off by 1.5e-3 of the cage, and normals by 10
    // degrees. At the end of an inner crease the error falls by a factor of 3.2 a level, and is 1.7e-5 of the cage at
    // level 8.
    constexpr int kApproxLevel = 10;  // the largest value that the library allows
    SurfaceFactory::Options options;
    options.SetApproxLevelSmooth(kApproxLevel).SetApproxLevelSharp(kApproxLevel);
    // Where two faces close around a vertex, OpenSubdiv 3.5 may find two surfaces alike whose vertices coincide in different
    // places, and share tables that do not fit both.
    options.EnableCaching(keeps && !has_pairs(refiner.GetLevel(0)));
    return std::make_unique<const SurfaceFactory>(refiner, options);
}

Topology::Mesh::Mesh(const Cage& cage, ClassMemory& memory)
    : bilinear(cage.scheme == Scheme::Bilinear),
      boundary(cage.boundary),
      shares_tables(false),
      refiner(make_refiner(cage)),
      factory(make_factory(*refiner)),
      creased_factory(make_factory(*refiner, false)),
      derived(DerivedPoints::make(cage, *refiner, memory))
{
    constexpr std::uint32_t kNobody = ~0u;
    const int faces = level().GetNumFaces();
    shares_tables = !has_pairs(level());
    vertex_owner.assign(level().GetNumVertices(), kNobody);
    vertex_corner.assign(level().GetNumVertices(), 0);
    edge_owner.assign(level().GetNumEdges(), kNobody);
    for (int f = 0; f < faces; ++f) {
        if (!factory->FaceHasLimitSurface(f)) continue;
        const auto vertices = level().GetFaceVertices(f);
        for (int i = 0; i < vertices.size(); ++i)
            if (vertex_owner[vertices[i]] == kNobody) {
                vertex_owner[vertices[i]] = static_cast<std::uint32_t>(f);
                vertex_corner[vertices[i]] = static_cast<std::uint8_t>(std::min(i, 0xff));
            }
        for (const int e : level().GetFaceEdges(f))
            if (edge_owner[e] == kNobody) edge_owner[e] = static_cast<std::uint32_t>(f);
    }
}

Topology::Mesh::~Mesh() = default;

namespace {

/// from_corners   list faces from the corner at hand on, and not from their first one
Neighbourhood look_around(const Far::TopologyLevel& level, PatchRef patch, bool bilinear, int uv_set, bool from_corners)
{
    Neighbourhood out;
    std::vector<std::uint32_t> vertex_numbers;
    Numbering vertex(uv_set < 0 ? out.controls : vertex_numbers);
    Numbering value(out.controls);
    const int face = static_cast<int>(patch.face);
    const auto corners = level.GetFaceVertices(face);
    out.key.reserve(160);
    out.key.push_back(static_cast<std::uint32_t>(corners.size()) << 8 | static_cast<std::uint32_t>(uv_set + 1));
    out.key.push_back(patch.sub);

    const int size = corners.size();
    const auto add_face = [&](int g, int first) {
        const auto add = [&](Numbering& number, const Far::ConstIndexArray& list) {
            for (int i = first; i < list.size(); ++i) out.key.push_back(number.of(static_cast<std::uint32_t>(list[i])));
            for (int i = 0; i < first; ++i) out.key.push_back(number.of(static_cast<std::uint32_t>(list[i])));
        };
        const auto vertices = level.GetFaceVertices(g);
        out.key.push_back(static_cast<std::uint32_t>(vertices.size()));
        add(vertex, vertices);
        if (uv_set >= 0) add(value, level.GetFaceFVarValues(g, uv_set));
    };

    if (bilinear) {
        add_face(face, 0);
        return out;
    }
    for (int c = 0; c < size; ++c) {
        const int v = corners[c];
        const auto faces = level.GetVertexFaces(v);
        const auto places = level.GetVertexFaceLocalIndices(v);
        int start = 0;
        while (faces[start] != face || places[start] != c) ++start;
        // Around an inner vertex the order is cyclic, and starting at this face makes equal neighbourhoods look equal.
        const bool cyclic = !level.IsVertexBoundary(v) && !level.IsVertexNonManifold(v);
        out.key.push_back(static_cast<std::uint32_t>(faces.size()) << 2 | (level.IsVertexBoundary(v) ? 2u : 0u) |
                          (level.IsVertexNonManifold(v) ? 1u : 0u));
        out.key.push_back(cyclic ? 0u : static_cast<std::uint32_t>(start));
        const auto add_sharpness = [&](float sharpness) {
            out.key.push_back(std::bit_cast<std::uint32_t>(sharpness));
            if (!Sdc::Crease::IsInfinite(sharpness))
                out.crease_depth = std::max(out.crease_depth, static_cast<int>(std::ceil(sharpness)));
        };
        add_sharpness(level.GetVertexSharpness(v));
        for (int f = 0; f < faces.size(); ++f) {
            const int k = cyclic ? (start + f) % faces.size() : f;
            const int g = faces[k], place = places[k];
            const auto edges = level.GetFaceEdges(g);
            out.key.push_back(from_corners ? 0u : static_cast<std::uint32_t>(place));
            add_sharpness(level.GetEdgeSharpness(edges[place]));
            add_sharpness(level.GetEdgeSharpness(edges[(place + edges.size() - 1) % edges.size()]));
            add_face(g, from_corners ? place : 0);
        }
    }
    return out;
}

}  // namespace

Neighbourhood neighbourhood(const Far::TopologyLevel& level, PatchRef patch, bool bilinear, int uv_set)
{
    return look_around(level, patch, bilinear, uv_set, false);
}

std::vector<std::uint32_t> tables_key(const Far::TopologyLevel& level, std::uint32_t face, bool bilinear, int uv_set)
{
    return look_around(level, {face, 0}, bilinear, uv_set, true).key;
}

std::size_t bytes_of(const Far::TopologyLevel& level) noexcept
{
    const auto faces = static_cast<std::size_t>(level.GetNumFaces()), edges = static_cast<std::size_t>(level.GetNumEdges());
    const auto vertices = static_cast<std::size_t>(level.GetNumVertices()),
               corners = static_cast<std::size_t>(level.GetNumFaceVertices());
    return 20 * corners + 34 * edges + 22 * vertices + 10 * faces;
}

std::size_t bytes_of(const Bfr::Surface<double>& surface) noexcept
{
    const auto controls = static_cast<std::size_t>(surface.GetNumControlPoints());
    const auto points = static_cast<std::size_t>(surface.GetNumPatchPoints());
    return sizeof surface + controls * 2 * sizeof(std::uint32_t) + (points - controls) * controls * sizeof(double);
}

}  // namespace occam::lod
