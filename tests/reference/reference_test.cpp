// Tests that compare Occam's pictures with those of other software: first hits, normals, base colour, texture coordinates
// (shared/reference).
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <span>

#include "occam/occam.h"
#include "tests/support/campaign.h"
#include "tests/support/reference_cases.h"

namespace occam::test {
namespace {

bool says_boundary_rule(const std::filesystem::path& file)
{
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("t interpolateboundary")) return true;
    return false;
}

// Cuts texture coordinates as the reference does. They have seams there that no file asks for, because Blender never joins
// the coordinates of faces that wind oppositely in their plane. So both programs interpolate over the same topology.
void cut_uvs_by_winding(Cage& cage)
{
    for (UvSet& set : cage.uv_sets) {
        if (set.indices.empty()) set.indices = cage.face_vertices;
        const std::vector<Vec2f> values = set.values;
        set.values.insert(set.values.end(), values.begin(), values.end());
        std::size_t first = 0;
        for (const std::uint32_t size : cage.face_sizes) {
            const std::span corners(set.indices.data() + first, size);
            double area = 0;  // twice the area, with v upwards
            for (std::size_t i = 0; i < size; ++i) {
                const Vec2d a(values[corners[i]]), b(values[corners[(i + 1) % size]]);
                area -= a.x * b.y - a.y * b.x;
            }
            if (area <= 0)
                for (std::uint32_t& index : corners) index += static_cast<std::uint32_t>(values.size());
            first += size;
        }
    }
}

Scene load_case(const ReferenceCase& c)
{
    Scene scene = load(c.model, {.subdivide = c.is_subdivision ? Subdivide::On : Subdivide::Auto});
    if (c.clip >= 0) scene.pose(scene.clips().at(static_cast<std::size_t>(c.clip)), c.seconds);
    if (!c.is_subdivision) return scene;
    const bool has_rule = says_boundary_rule(c.model);
    std::vector<CageId> cages;
    scene.for_each_placement(
        [&](NodeId, const Node& node, const Mat4d&) { cages.insert(cages.end(), node.cages.begin(), node.cages.end()); });
    for (const CageId id : cages) {
        Cage cage = scene.cage(id).cage;
        if (!has_rule) cage.boundary = c.boundary;
        cut_uvs_by_winding(cage);
        scene.replace(id, std::move(cage));
    }
    return scene;
}

ReferencePicture render_case(const ReferenceCase& c)
{
    Scene scene = load_case(c);
    Renderer renderer;
    // A debug view needs no light. Texels are filtered for one ray as wide as the pixel, so base colour has its own, finer
    // frame.
    Settings settings{.width = c.width, .height = c.height, .spp = 1, .jitter = false, .view = View::Normal};
    for (Aov aov : {Aov::Depth, Aov::Normal, Aov::NormalGeometric, Aov::Uv}) settings.aovs |= aov;
    const Image first = renderer.render(scene, c.camera, settings);

    ReferencePicture picture;
    picture.width = first.width;
    picture.height = first.height;
    picture.depth = first.find("depth")->pixels;
    picture.normal_geometric = first.find("normal_geometric")->pixels;
    picture.normal_shading = first.find("normal")->pixels;
    picture.uv = first.find("uv")->pixels;
    // The reference counts v upwards.
    for (std::size_t i = 1; i < picture.uv.size(); i += 2) picture.uv[i] = 1 - picture.uv[i];
    if (c.files.contains("albedo")) {
        settings.spp = is_long() ? 64 : 16;
        settings.jitter = true;
        settings.aovs = Aov::Albedo;
        picture.albedo = renderer.render(scene, c.camera, settings).find("albedo")->pixels;
    }
    return picture;
}

void expect_share(const char* what, std::optional<double> share, std::optional<double> least)
{
    if (!least) return;
    ASSERT_TRUE(share) << what << ": the reference has no such picture, or no pixel to compare";
    testing::Test::RecordProperty(what, std::to_string(*share));
    EXPECT_GE(*share, *least) << "share of the interior pixels that agree in " << what;
}

/// Returns all cases of the shared data. Without it there is a single case without a name, so that the report says in one
/// line what is missing.
std::vector<ReferenceCase> cases_or_none()
{
    std::vector<ReferenceCase> cases = reference_cases();
    if (cases.empty()) cases.emplace_back();
    return cases;
}

class ReferencePictures : public testing::TestWithParam<ReferenceCase> {};

TEST_P(ReferencePictures, AreMatched)
{
    const ReferenceCase& c = GetParam();
    if (c.id.empty()) GTEST_SKIP() << "the shared folder is absent: pictures of other software are not compared";
    const ReferenceShares shares = compare(render_case(c), read_reference(c), c.limits);
    EXPECT_GT(shares.interior, 0u);

    RecordProperty("coverage_mismatch", std::to_string(shares.coverage_mismatch));
    EXPECT_LE(shares.coverage_mismatch, c.least.coverage_mismatch);
    expect_share("depth", shares.depth, c.least.depth);
    expect_share("normal_geometric", shares.normal_geometric, c.least.normal_geometric);
    expect_share("normal_shading", shares.normal_shading, c.least.normal_shading);
    expect_share("uv", shares.uv, c.least.uv);
    expect_share("albedo", shares.albedo, c.least.albedo);
    if (c.least.albedo_mean_absolute) {
        RecordProperty("albedo_mean_absolute", std::to_string(shares.albedo_mean_absolute.value_or(NAN)));
        EXPECT_LE(shares.albedo_mean_absolute.value_or(INFINITY), *c.least.albedo_mean_absolute);
    }
}

INSTANTIATE_TEST_SUITE_P(Shared, ReferencePictures, testing::ValuesIn(cases_or_none()), [](const auto& test) {
    return test.param.id.empty() ? std::string("None") : reference_test_name(test.param);
});

TEST(ReferenceData, HoldsCasesOfEveryKind)
{
    const std::vector<ReferenceCase> cases = reference_cases();
    if (cases.empty()) GTEST_SKIP() << "no shared/reference: set OCCAM_SHARED, or put the folder beside the repository";
    EXPECT_TRUE(std::ranges::any_of(cases, [](const ReferenceCase& c) { return c.is_subdivision; }));
    EXPECT_TRUE(std::ranges::any_of(cases, [](const ReferenceCase& c) { return c.clip >= 0; }));
}

}  // namespace
}  // namespace occam::test
