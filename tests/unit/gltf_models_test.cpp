// Tests with models whose authors made them to show at a glance whether a renderer follows glTF, judged as their labels say.
// Their pictures were looked at once. The tests check what makes them right: equal swatches, arrows at their marks, colours
// by position.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>

#include "render/cryptomatte.h"
#include "tests/support/shared_data.h"

namespace occam::test {
namespace {

// Holds the unlit base colour of a model seen straight on, along -z or from behind along +z, with pixels of the size kPixel.
class Plate {
public:
    static constexpr double kPixel = 0.02;

    Plate(const char* file, bool from_behind = false, bool back_faces = true) : sign_(from_behind ? -1 : 1)
    {
        if (shared_data().empty()) return;
        Scene scene = load(shared_data() / "data/gltf" / file);
        const Box3d bounds = scene.bounds();
        middle_ = (bounds.lo + bounds.hi) * 0.5;
        Settings settings{.spp = 4, .integrator = IntegratorKind::Ao, .ao_distance = 1e-3f, .back_faces = back_faces};
        settings.width = int(bounds.extent().x / kPixel) + 2;
        settings.height = int(bounds.extent().y / kPixel) + 2;
        settings.aovs = Aov::Albedo | Aov::CryptomatteObject;
        Camera camera = Camera::look_at(middle_ + Vec3d(0, 0, sign_ * 20), middle_, {0, 1, 0}, 1);
        camera.lens.orthographic = true;
        camera.lens.height = float(settings.height * kPixel);
        image_ = Renderer({.threads = 2}).render(scene, camera, settings);
    }
    bool is_there() const { return image_.width > 0; }

    /// Returns the base colour at a place of the model.
    Vec3f at(double x, double y) const
    {
        const float* p = &image_.find("albedo")->pixels[4 * pixel(x, y)];
        return {p[0], p[1], p[2]};
    }
    Vec3f mean(Vec2d lo, Vec2d hi) const
    {
        Vec3f sum(0);
        int count = 0;
        for (double y = lo.y; y < hi.y; y += kPixel)
            for (double x = lo.x; x < hi.x; x += kPixel, ++count) sum += at(x, y);
        return sum / float(count);
    }
    /// Returns the share of the pixel that shows a node.
    float coverage(const char* node, double x, double y) const
    {
        for (const char* layer : {"CryptoObject00", "CryptoObject01", "CryptoObject02"}) {
            const float* p = &image_.find(layer)->pixels[4 * pixel(x, y)];
            for (int rank : {0, 2})
                if (p[rank] == render::matte_id(node)) return p[rank + 1];
        }
        return 0;
    }

private:
    std::size_t pixel(double x, double y) const
    {
        const int column = int(image_.width * 0.5 + sign_ * (x - middle_.x) / kPixel);
        const int row = int(image_.height * 0.5 - (y - middle_.y) / kPixel);
        return std::size_t(std::clamp(row, 0, image_.height - 1)) * std::size_t(image_.width) +
               std::size_t(std::clamp(column, 0, image_.width - 1));
    }

    double sign_;
    Vec3d middle_{0};
    Image image_;
};

float brightness(Vec3f c) { return (c.x + c.y + c.z) / 3; }

#define PLATE(name, ...)           \
    const Plate name(__VA_ARGS__); \
    if (!name.is_there()) GTEST_SKIP() << "the shared folder is absent: its models are not tested"

// Returns how much the tested square in a row of TextureSettingsTest differs from the one beside it that shows what it
// should be. The file's coordinates of the two differ by up to a twelfth of a side, in size too. So the best of some shifts
// is taken, and differences at edges remain.
double row_difference(const Plate& plate, double top)
{
    double least = 1;
    for (double dx = -0.04; dx < 0.05; dx += 0.02)
        for (double dy = -0.04; dy < 0.05; dy += 0.02) {
            double difference = 0;
            int count = 0;
            for (double y = top - 0.81; y < top - 0.09; y += Plate::kPixel)
                for (double x = 0.1; x < 0.82; x += Plate::kPixel, ++count) {
                    const Vec3f d = glm::abs(plate.at(x, y) - plate.at(x + dx + 2.146, y + dy));
                    difference += double(std::max({d.x, d.y, d.z}));
                }
            least = std::min(least, difference / count);
        }
    return least;
}

TEST(GltfModels, TextureSettingsRowsEqualTheirSamples)
{
    PLATE(plate, "features/TextureSettingsTest/TextureSettingsTest.gltf", false, false);
    for (const double top : {2.995, 1.97, 0.917, -0.12, -1.154, -2.191, -3.228, -4.265})
        EXPECT_LT(row_difference(plate, top), 0.08) << "row from " << top;
}

TEST(GltfModels, BothSidesOfASingleSidedSquareAreSeenUnlessItIsAskedFor)
{
    PLATE(plate, "features/TextureSettingsTest/TextureSettingsTest.gltf");
    EXPECT_GT(row_difference(plate, 2.995), 0.16) << "a red cross before the green check mark";
}

// Shifted textures show the check mark in the swatch's own colour; rotated and scaled arrows have their tips at the check
// marks.
TEST(GltfModels, TransformedTexturesPointWhereTheyShould)
{
    PLATE(plate, "features/ManyTextureTransforms/TextureTransformTest.gltf");
    const auto corner = [&](double x) { return plate.at(x - 0.45, 0.55 + 0.45); };
    EXPECT_GT(corner(-1.1).y, 3 * corner(-1.1).x);
    EXPECT_GT(corner(-1.1).y, 3 * corner(-1.1).z);
    EXPECT_GT(corner(0).z, 3 * corner(0).y);
    EXPECT_GT(corner(1.1).z, 3 * corner(1.1).x);
    EXPECT_GT(corner(1.1).y, 3 * corner(1.1).x);
    const auto darkest_near = [&](Vec2d mark, double from, double to) {
        float least = 1;
        for (double angle = 0; angle < 6.28; angle += 0.02)
            for (double r = from; r < to; r += Plate::kPixel / 2)
                least = std::min(least, brightness(plate.at(mark.x + r * std::cos(angle), mark.y + r * std::sin(angle))));
        return least;
    };
    struct Mark {
        const char* name;
        Vec2d at;
        bool is_right;
    };
    const Mark marks[] = {{"rotation, correct", {-1.179, -1.066}, true},
                          {"rotation, not supported", {-0.822, -0.828}, false},
                          {"scale, correct", {0.0185, -0.5685}, true},
                          {"scale, not supported", {0.278, -0.828}, false},
                          {"all, correct", {1.03, -0.8}, true}};
    for (const Mark& mark : marks) {
        const float darkest = darkest_near(mark.at, 0.11, 0.16);
        if (mark.is_right) EXPECT_LT(darkest, 0.05f) << mark.name;
        else EXPECT_GT(darkest, 0.2f) << mark.name;
    }
}

// The model is seen from behind, as its author intends. Checkers lead into the outer corners.
TEST(GltfModels, TextureCoordinatesPutEachColourIntoItsCorner)
{
    PLATE(plate, "features/TextureCoordinateTest/TextureCoordinateTest.gltf", true);
    struct Corner {
        Vec2d at;
        Vec3f color;
    };
    const Corner corners[] = {
        {{0.7, 0.7}, {1, 1, 0}}, {{-0.7, 0.7}, {1, 0, 0}}, {{0.7, -0.7}, {0, 0, 1}}, {{-0.7, -0.7}, {0, 1, 0}}};
    for (const Corner& c : corners) {
        const Vec3f found = plate.at(c.at.x, c.at.y);
        for (int i : {0, 1, 2})
            EXPECT_EQ(found[i] > 0.45f, c.color[i] > 0.5f) << c.at.x << ' ' << c.at.y << ' ' << i << ' ' << found[i];
        const Vec2d end = c.at + glm::sign(c.at) * 0.44;
        EXPECT_LT(brightness(plate.mean(end - 0.05, end + 0.05)), 0.85f * brightness(found)) << c.at.x << ' ' << c.at.y;
    }
}

// Colours change linearly, in linear light, from corner to corner of the box's front.
TEST(GltfModels, VertexColoursAreLinearBetweenCorners)
{
    PLATE(plate, "features/BoxVertexColors/BoxVertexColors.glb");
    constexpr double kRim = 0.48, kOff = 0.4;
    const Vec3f corners[] = {plate.at(kRim, kOff), plate.at(kRim, -kOff), plate.at(-kRim, kOff), plate.at(-kRim, -kOff)};
    for (int i : {0, 1, 2}) {
        EXPECT_NEAR(plate.at(kRim, 0)[i], (corners[0][i] + corners[1][i]) / 2, 0.02f);
        EXPECT_NEAR(plate.at(-kRim, 0)[i], (corners[2][i] + corners[3][i]) / 2, 0.02f);
    }
    EXPECT_GT(corners[0].x, 2 * corners[0].y) << "red at the upper right";
    EXPECT_GT(corners[1].z, 2 * corners[1].x) << "blue at the lower right";
    EXPECT_GT(corners[2].y, 2 * corners[2].z) << "green at the upper left";
}

// Alpha grows downwards from 0 to 1. Masks end at the height of the green arrow beside them; at those heights the blended
// pane covers as much as the marks say.
TEST(GltfModels, AlphaIsCutAndBlendedAtTheMarks)
{
    PLATE(plate, "static/AlphaBlendModeTest/AlphaBlendModeTest.glb");
    struct Pane {
        const char* name;
        double x;
        float cutoff;
    };
    const auto end_of = [&](const Pane& pane) {
        double y = 0.3;
        while (y < 2 && plate.coverage(pane.name, pane.x, y) > 0.5f) y += Plate::kPixel / 2;
        return y;
    };
    const Pane panes[] = {{"TestCutoff25", 0, 0.25f}, {"TestCutoffDefault", 1.5, 0.5f}, {"TestCutoff75", 3, 0.75f}};
    for (const Pane& pane : panes) {
        const Vec3f arrow = plate.at(pane.x + 0.56, end_of(pane));
        EXPECT_GT(arrow.y, 2 * arrow.x) << pane.name;
    }
    const double top = end_of(panes[0]), middle = end_of(panes[1]), low = end_of(panes[2]);
    EXPECT_NEAR(top - middle, middle - low, 2 * Plate::kPixel);
    EXPECT_GT(top - low, 0.5);
    for (const auto& [y, alpha] : {std::pair(top, 0.25f), std::pair(middle, 0.5f), std::pair(low, 0.75f)}) {
        float covered = 0;
        for (int i = -10; i <= 10; ++i) covered += plate.coverage("TestBlend", -1.5 + 0.02 * i, y) / 21;
        EXPECT_NEAR(covered, alpha, 0.03f);
    }
    EXPECT_EQ(plate.coverage("TestOpaque", -3, 1.8), 1) << "opaque, whatever its alpha";
}

}  // namespace
}  // namespace occam::test
