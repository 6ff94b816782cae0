// Tests of first hits beside closed forms: rays and boxes in double, each box in its own axes. They need no data.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "tests/support/reference_compare.h"

namespace occam::test {
namespace {

constexpr int kWidth = 160, kHeight = 120;

struct Box {
    Mat4d world_from_box{1};  ///< places the cube from -1 to 1
    bool is_cage = false;     ///< whether it is a bilinear cage instead of triangles
};

Cage box_cage(bool is_cage)
{
    Cage cage;
    cage.scheme = is_cage ? Scheme::Bilinear : Scheme::Triangles;
    for (int k = 0; k < 8; ++k) cage.positions.push_back({k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1});
    constexpr std::uint32_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                            {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : kFaces) {
        if (is_cage) cage.face_sizes.push_back(4);
        if (is_cage) cage.face_vertices.insert(cage.face_vertices.end(), {f[0], f[1], f[2], f[3]});
        else cage.face_vertices.insert(cage.face_vertices.end(), {f[0], f[1], f[2], f[0], f[2], f[3]});
    }
    return cage;
}

/// Writes the first hit of a ray into a pixel; the direction has a camera z of -1, so that distances are depths.
void trace(const std::vector<Box>& boxes, Vec3d origin, Vec3d direction, float* depth, float* normal)
{
    double nearest = std::numeric_limits<double>::infinity();
    for (const Box& box : boxes) {
        const Mat4d inverse = glm::inverse(box.world_from_box);
        const Vec3d o = Vec3d(inverse * Vec4d(origin, 1)), d = Vec3d(inverse * Vec4d(direction, 0));
        double enter = 0, leave = std::numeric_limits<double>::infinity();
        int axis = -1;
        for (int k = 0; k < 3; ++k) {
            const double a = (-1 - o[k]) / d[k], b = (1 - o[k]) / d[k];
            if (std::min(a, b) > enter) enter = std::min(a, b), axis = k;
            leave = std::min(leave, std::max(a, b));
        }
        if (axis < 0 || enter > leave || enter >= nearest) continue;
        nearest = enter;
        Vec3d n(0);
        n[axis] = d[axis] > 0 ? -1 : 1;
        const Vec3f turned(glm::normalize(Vec3d(glm::transpose(inverse) * Vec4d(n, 0))));
        for (int k = 0; k < 3; ++k) normal[k] = turned[k];
    }
    *depth = static_cast<float>(nearest);
}

ReferencePicture expected(const std::vector<Box>& boxes, const Camera& camera)
{
    ReferencePicture picture;
    picture.width = kWidth;
    picture.height = kHeight;
    picture.depth.resize(picture.pixel_count());
    picture.normal_geometric.resize(3 * picture.pixel_count());
    const double half = camera.lens.orthographic ? camera.lens.height * 0.5 : std::tan(camera.lens.fov * 0.5);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const std::size_t pixel = std::size_t(y) * kWidth + std::size_t(x);
            const double px = (2 * (x + 0.5) / kWidth - 1) * half * kWidth / kHeight,
                         py = (1 - 2 * (y + 0.5) / kHeight) * half;
            const Vec4d from = camera.lens.orthographic ? Vec4d(px, py, 0, 1) : Vec4d(0, 0, 0, 1);
            const Vec4d to = camera.lens.orthographic ? Vec4d(0, 0, -1, 0) : Vec4d(px, py, -1, 0);
            trace(boxes, Vec3d(camera.world_from_camera * from), Vec3d(camera.world_from_camera * to), &picture.depth[pixel],
                  &picture.normal_geometric[3 * pixel]);
        }
    return picture;
}

ReferencePicture rendered(const std::vector<Box>& boxes, const Camera& camera)
{
    Scene scene;
    const CageId cages[] = {scene.add(box_cage(false)), scene.add(box_cage(true))};
    for (const Box& box : boxes) {
        NodeDesc desc;
        desc.matrix = box.world_from_box;
        desc.cages = {cages[box.is_cage]};
        scene.add_node(scene.root(), desc);
    }
    Settings settings{.width = kWidth, .height = kHeight, .spp = 1, .jitter = false, .view = View::Normal};
    settings.aovs = Aov::Depth | Aov::NormalGeometric;
    const Image image = Renderer({.threads = 2}).render(scene, camera, settings);
    ReferencePicture picture;
    picture.width = kWidth;
    picture.height = kHeight;
    picture.depth = image.find("depth")->pixels;
    picture.normal_geometric = image.find("normal_geometric")->pixels;
    return picture;
}

// Returns a rotated box, a stretched and mirrored one, a small one near the eye and a large one behind, as meshes and cages.
std::vector<Box> boxes_about(Vec3d middle)
{
    const auto box = [&](Vec3d at, Vec4d turn, Vec3d scale, bool is_cage) {
        Trs place;
        place.translation = middle + at;
        place.rotation = glm::normalize(turn);
        place.scale = scale;
        return Box{place.matrix(), is_cage};
    };
    return {box({0, 0, 0}, {0.2, 0.4, 0.1, 0.8}, Vec3d(1), false),
            box({2.5, 0.4, -0.7}, {-0.3, 0.1, 0.5, 0.7}, {0.6, -1.3, 0.8}, true),
            box({-2.4, -0.3, 0.9}, {0.1, -0.6, 0.2, 0.9}, {0.9, 0.5, 1.4}, true),
            box({0.4, 1.3, 2.5}, {0.5, 0.2, 0.3, 0.6}, Vec3d(0.2), false),
            box({0, -4, -9}, {0, 0.1, 0, 1}, {30, 1, 4}, false)};
}

class ClosedForms : public testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(ClosedForms, OfBoxesAreMet)
{
    const auto [offset, is_orthographic] = GetParam();
    const Vec3d middle(offset, -0.3 * offset, 0.7 * offset);
    Camera camera = Camera::look_at(middle + Vec3d(1, 2, 9), middle, {0, 1, 0}, 0.7f);
    camera.lens.orthographic = is_orthographic;
    camera.lens.height = 7;
    const std::vector<Box> boxes = boxes_about(middle);
    // Positions of hits are exact to some ulps of the distance; directions of rays are floats.
    const ReferenceLimits limits{.depth_relative = 2e-6, .normal_geometric_degrees = 0.01};
    const ReferenceShares shares = compare(rendered(boxes, camera), expected(boxes, camera), limits);
    EXPECT_GT(shares.interior, 3000u);
    EXPECT_LE(shares.coverage_mismatch, 0.0005) << "pixels whose centre lies on a silhouette to an ulp";
    EXPECT_GE(shares.depth.value_or(0), 0.9995);
    EXPECT_GE(shares.normal_geometric.value_or(0), 0.9995);
}

INSTANTIATE_TEST_SUITE_P(Cameras, ClosedForms, testing::Combine(testing::Values(0.0, 1000.0, 1e5), testing::Bool()),
                         [](const auto& test) {
                             return std::string(std::get<1>(test.param) ? "Orthographic" : "Perspective") + "At" +
                                    std::to_string(int(std::get<0>(test.param)));
                         });

}  // namespace
}  // namespace occam::test
