#include "lod/bfr_source.h"

#include <opensubdiv/sdc/crease.h>

#include <set>
#include <unordered_map>
#include <vector>

#include "base/check.h"
#include "lod/corner_limits.h"
#include "lod/small_surface.h"
#include "lod/unsafe_faces.h"

namespace occam::lod {

using namespace OpenSubdiv;

void evaluate(const Bfr::Surface<double>& surface, double s, double t, LimitSource::Of of, LimitStencil& out)
{
    const auto n = static_cast<std::size_t>(surface.GetNumControlPoints());
    const double st[2] = {s, t};
    out.p.resize(n);
    if (of == LimitSource::Of::Point) {
        surface.EvaluateStencil(st, out.p.data());
        return;
    }
    out.du.resize(n);
    out.dv.resize(n);
    surface.EvaluateStencil(st, out.p.data(), out.du.data(), out.dv.data());
}

namespace {

class BfrSource : public LimitSource {
public:
    BfrSource(const SurfaceFactory& factory, PatchRef patch, std::span<const std::uint32_t> controls, int uv_set,
              ClassAccount* account)
        : account_(account),
          sub_(patch.sub),
          parameters_(factory.GetFaceParameterization(static_cast<int>(patch.face))),
          count_(controls.size())
    {
        const std::vector<int> own = make_surface(factory, static_cast<int>(patch.face), uv_set);
        Numbers number;
        for (std::uint32_t i = 0; i < controls.size(); ++i) number.emplace(controls[i], i);
        // Texture coordinates that collapse around a vertex of two faces leave points without an index (-1). Any index will
        // do for them.
        for (int index : own) {
            const auto known = number.find(static_cast<std::uint32_t>(index));
            number_.push_back(known == number.end() ? 0 : known->second);
        }
        set_corners(factory.GetMesh(), patch, uv_set, number);
    }

    // The surface at a corner takes about as much as the whole one.
    std::size_t bytes() const noexcept override
    {
        return sizeof *this + (account_ ? 1 : 2) * bytes_of(surface_) + (fans_ ? fans_->bytes() : 0);
    }

    void evaluate(double u, double v, Of of, LimitStencil& out) const override
    {
        LimitStencil own;
        if (corners_ && corners_->evaluate(u, v, of, own)) return renumber(own, number_at_corners_, 1, of, out);
        double uv[2] = {u, v};
        if (parameters_.HasSubFaces()) {
            // Sub-faces lie on a grid of unit tiles, each taking [0, 1/2] of its own.
            const double local[2] = {u, v};
            parameters_.ConvertNormalizedSubFaceToCoord(static_cast<int>(sub_), local, uv);
        }
        lod::evaluate(surface_, uv[0], uv[1], of, own);
        renumber(own, number_, parameters_.HasSubFaces() ? 0.5 : 1, of, out);
    }

private:
    using Numbers = std::unordered_map<std::uint32_t, std::uint32_t>;

    /// Makes the surface of a face, and returns its control points: vertices of the cage, or values of the UV set.
    std::vector<int> make_surface(const SurfaceFactory& factory, int face, int uv_set)
    {
        const Far::TopologyRefiner& refiner = factory.GetMesh();
        const bool has_own_mesh = refiner.GetSchemeType() == Sdc::SCHEME_CATMARK && joins_border(refiner.GetLevel(0), face);
        // In a mesh of the face's fans alone, their ends are joined, and the border is a crease.
        MeshPart part(refiner.GetLevel(0), rules_of(refiner), uv_set);
        if (has_own_mesh) {
            part.add_fans({face, 0});
            part.add_sharpness();
            fans_ = std::make_unique<const SmallSurface>(part.mesh);
            surface_ = uv_set < 0 ? fans_->surface(0) : fans_->uv_surface(0);
        } else {
            const bool is_valid = uv_set < 0 ? factory.InitVertexSurface(face, &surface_)
                                             : factory.InitFaceVaryingSurface(face, &surface_, uv_set);
            OCCAM_CHECK_EQ(is_valid, true);
        }
        std::vector<int> own(static_cast<std::size_t>(surface_.GetNumControlPoints()));
        surface_.GetControlPointIndices(own.data());
        if (!has_own_mesh) return own;
        const std::vector<int>& of_part = uv_set < 0 ? part.vertices : part.values;
        for (int& index : own)
            if (index >= 0) index = of_part[static_cast<std::size_t>(index)];
        return own;
    }
    /// Sets what is exact close to the corners, if Bfr is not.
    void set_corners(const Far::TopologyRefiner& refiner, PatchRef patch, int uv_set, const Numbers& number)
    {
        const Far::TopologyLevel& level = refiner.GetLevel(0);
        const int face = static_cast<int>(patch.face);
        if (surface_.IsRegular() || surface_.IsLinear() || refiner.GetSchemeType() != Sdc::SCHEME_CATMARK) return;
        const Numbers values = uv_set < 0 ? Numbers() : values_of_vertices(level, face, uv_set);
        const bool has_seam = uv_set >= 0 && values.empty();
        if (has_seam && !has_lasting_seams(level, face, uv_set)) return;
        corners_ = std::make_unique<const CornerLimits>(level, Sector{face, static_cast<int>(patch.sub)}, rules_of(refiner),
                                                        has_seam ? uv_set : -1, account_);
        for (const int at : corners_->controls()) {
            const auto control = static_cast<std::uint32_t>(at);
            number_at_corners_.push_back(number.at(uv_set < 0 || has_seam ? control : values.at(control)));
        }
    }
    static MeshRules rules_of(const Far::TopologyRefiner& refiner)
    {
        const Sdc::Options options = refiner.GetSchemeOptions();
        const bool has_corners = options.GetVtxBoundaryInterpolation() == Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER;
        MeshRules rules{has_corners ? BoundaryRule::EdgeAndCorner : BoundaryRule::EdgeOnly};
        for (const FaceVaryingRule rule :
             {FaceVaryingRule::CornersPlus1, FaceVaryingRule::CornersPlus2, FaceVaryingRule::CornersOnly,
              FaceVaryingRule::Boundaries, FaceVaryingRule::All, FaceVaryingRule::None})
            if (linear_interpolation(rule) == options.GetFVarLinearInterpolation()) rules.face_varying = rule;
        return rules;
    }
    /// Returns whether seams and borders around a face are treated alike in each step of subdivision, as those of a mesh
    /// that begins there, and by Bfr. Where a semi-sharp crease meets a seam, OpenSubdiv remembers how sharp it was; where
    /// faces that do not touch share a value of a vertex, Bfr takes it for several.
    static bool has_lasting_seams(const Far::TopologyLevel& level, int face, int uv_set)
    {
        const auto is_semi_sharp = [](float s) { return s > 0 && !Sdc::Crease::IsInfinite(s); };
        for (const int vertex : level.GetFaceVertices(face)) {
            if (level.IsVertexNonManifold(vertex) || is_semi_sharp(level.GetVertexSharpness(vertex))) return false;
            std::size_t parts = level.IsVertexBoundary(vertex) ? 1 : 0;
            for (const int edge : level.GetVertexEdges(vertex)) {
                if (is_semi_sharp(level.GetEdgeSharpness(edge))) return false;
                parts += !level.IsEdgeBoundary(edge) && !level.DoesEdgeFVarTopologyMatch(edge, uv_set);
            }
            std::set<int> values;
            const auto faces = level.GetVertexFaces(vertex);
            const auto places = level.GetVertexFaceLocalIndices(vertex);
            for (int f = 0; f < faces.size(); ++f) values.insert(level.GetFaceFVarValues(faces[f], uv_set)[places[f]]);
            if (values.size() < parts) return false;
        }
        return true;
    }
    /// Returns the texture coordinate of each vertex around a face; none if they have a seam or a border there. Without one
    /// they are refined as the vertices are, except at a vertex of several fans that is no corner: Bfr keeps its coordinate
    /// as it is, and there are none, either.
    static Numbers values_of_vertices(const Far::TopologyLevel& level, int face, int uv_set)
    {
        Numbers values;
        for (const int vertex : level.GetFaceVertices(face)) {
            if (level.IsVertexBoundary(vertex) || !level.DoesVertexFVarTopologyMatch(vertex, uv_set)) return {};
            if (level.IsVertexNonManifold(vertex) && !level.IsVertexInfSharp(vertex)) return {};
            for (const int f : level.GetVertexFaces(vertex)) {
                const auto vertices = level.GetFaceVertices(f), of_face = level.GetFaceFVarValues(f, uv_set);
                for (int i = 0; i < vertices.size(); ++i) {
                    const auto value = static_cast<std::uint32_t>(of_face[i]);
                    // In a small closed mesh a seam may be between two of these faces and yet at none of the corners.
                    if (values.emplace(static_cast<std::uint32_t>(vertices[i]), value).first->second != value) return {};
                }
            }
        }
        return values;
    }
    /// Writes weights by the numbers of the class's control points.
    /// scale   of the derivatives
    void renumber(const LimitStencil& from, std::span<const std::uint32_t> number, double scale, Of of,
                  LimitStencil& to) const
    {
        const auto one = [&](const std::vector<double>& weights, double factor, std::vector<double>& out) {
            out.assign(count_, 0);
            for (std::size_t i = 0; i < weights.size(); ++i) out[number[i]] += weights[i] * factor;
        };
        one(from.p, 1, to.p);
        if (of == Of::Point) return;
        one(from.du, scale, to.du);
        one(from.dv, scale, to.dv);
    }

    ClassAccount* account_;
    std::uint32_t sub_;
    Bfr::Parameterization parameters_;
    std::size_t count_;
    std::unique_ptr<const SmallSurface> fans_;  ///< null: the surface is one of the cage's
    Bfr::Surface<double> surface_;
    std::vector<std::uint32_t> number_;
    std::unique_ptr<const CornerLimits> corners_;  ///< null where Bfr is exact, and where creases meet seams
    std::vector<std::uint32_t> number_at_corners_;
};

}  // namespace

std::unique_ptr<const LimitSource> limit_source(const SurfaceFactory& factory, PatchRef patch,
                                                std::span<const std::uint32_t> controls, int uv_set, ClassAccount* account)
{
    return std::make_unique<BfrSource>(factory, patch, controls, uv_set, account);
}

}  // namespace occam::lod
