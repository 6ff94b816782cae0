// Tests of shutters and motions that nobody means: each is a clear error or a picture, and never a hang.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>
#include <limits>
#include <string_view>

#include "tests/support/campaign.h"
#include "tests/support/command_test.h"
#include "tests/support/refined_cages.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

class HostileShutter : public CommandTest {
protected:
    // A triangle that slides along x.
    void SetUp() override
    {
        CommandTest::SetUp();
        const float numbers[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0, /* times */ 0, 1, /* places */ 0, 0, 0, 2, 0, 0};
        std::ofstream(folder / "m.bin", std::ios::binary).write(reinterpret_cast<const char*>(numbers), sizeof numbers);
        std::ofstream(folder / "m.gltf") << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"animations": [{"samplers": [{"input": 1, "output": 2}],
  "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
"buffers": [{"uri": "m.bin", "byteLength": 68}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
{"buffer": 0, "byteOffset": 44, "byteLength": 24}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
{"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
{"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}]})";
    }
    Outcome render(const std::vector<std::string>& more, const char* scene = "m.gltf", const char* picture = "a.exr") const
    {
        std::vector<std::string> all{"render", scene, "-o", picture, "--size", "16x12", "--spp", "2"};
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    }
};

// Boxes of surfaces that move are padded for the rounding where the cage is largest. In the first half of this shutter all
// boxes of the cage would be padding, and each ray would meet all of them.
TEST(HostileMotion, CagesAreLeftOutOfSegmentsInWhichTheyAreTiny)
{
    for (const double size : {4e4, 1e6, 1e9, 1e16, 1e38, 1e200})
        for (const TreeKind tree : {TreeKind::Bvh, TreeKind::Kd}) {
            Scene scene;
            const CageId cage = scene.add(creased_cube(1));
            const NodeId grows = place(scene, cage, Vec3d(0)), still = place(scene, cage, Vec3d(4, 0, 0));
            scene.record_shutter(2, [&](double tau) {
                Trs place;
                if (tau > 0.75) place.scale = Vec3d(size);
                scene.set_transform(grows, place);
            });
            Renderer renderer({.threads = 1, .tree = tree});
            renderer.render(scene, Camera::look_at({0, 0, 8}, Vec3d(0), {0, 1, 0}, 0.8f),
                            {.width = 12, .height = 8, .spp = 1});
            EXPECT_EQ(renderer.stats().warnings.size(), size > 1e16 ? 1u : 0u) << size;
            if (size > 1e16) continue;  // the rest has vanished
            const Query query(scene, Camera::look_at({0, 0, 8}, Vec3d(0), {0, 1, 0}, 0.8f), 48);
            const auto seen = [&](Vec3d from, float time) {
                const auto hit = query.closest(QueryRay{.origin = from, .direction = {0, 0, -1}, .time = time});
                return hit ? hit->node : NodeId();
            };
            EXPECT_EQ(seen({0.1, 0.2, 8}, 0.25f) == grows, size < 0x1p17) << size;
            EXPECT_EQ(seen({0.1, 0.2, 8}, 0.75f), grows) << size << ": from within";
            EXPECT_EQ(seen({0.1, 0.2, 8}, 0.5f), grows) << size << ": where the segment begins in which it grows";
            EXPECT_EQ(seen({4.1, 0.2, 8}, 0.25f), still) << size;
        }
}

// Returns a ball of 6 * 4^levels quads around the origin.
Cage ball(int levels)
{
    Cage cage = creased_cube(0);
    for (int i = 0; i < levels; ++i) cage = refined(cage, true);
    return cage;
}

// Makes a picture from within or from outside of a cage that has its own size in the first half of the shutter and grows to
// another one in the second half.
void expect_picture_of_growth(const Cage& cage, Vec3d to, int segments, Vec3d eye)
{
    Scene scene;
    const NodeId grows = place(scene, scene.add(cage), Vec3d(0));
    scene.record_shutter(segments, [&](double tau) {
        scene.set_transform(grows, {.scale = glm::mix(Vec3d(1), to, std::max(0.0, 2 * tau - 1))});
    });
    Renderer renderer({.threads = 1, .memory_bytes = std::size_t(64) << 20});
    renderer.render(scene, Camera::look_at(eye, {0, 0, -9}, {0, 1, 0}, 0.8f), {.width = 24, .height = 16, .spp = 1});
    EXPECT_LT(renderer.stats().built.micropolygons, 5'000'000u) << to.x << ", " << to.y << ", " << segments << ", " << eye.z;
}

// In the half in which it is small such a cage had the micropolygons of its largest size, or each ray met all of them: the
// pictures took a minute, or were refused after gigabytes.
TEST(HostileMotion, CagesThatGrowMuchAreNoMoreWorkThanOthers)
{
    const Cage cage = ball(3);
    EveryNth some(3);
    for (const Vec3d to : {Vec3d(1e3), Vec3d(1e5), Vec3d(1e7), Vec3d(1e20), Vec3d(1, 1e7, 1)})
        for (const int segments : {2, 8})
            for (const double eye : {0.1, 4.0})
                if (some.takes()) expect_picture_of_growth(cage, to, segments, {0, 0, eye});
    expect_picture_of_growth(cage, Vec3d(1e7), 32, {0, 0, 4});
}

TEST_F(HostileShutter, OptionsThatAreNoShuttersAreRefusedInOneLine)
{
    const auto expect_refused = [&](const Outcome& o, const std::string& what) {
        EXPECT_EQ(o.exit_code, kBadInput) << what;
        EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << what << ": " << o.err;
        EXPECT_FALSE(fs::exists(folder / "a.exr")) << what;
    };
    for (const char* bad : {"0.25,-0.25", "nan,1", "0,nan", "0,inf", "-inf,0", "0", "", ",", "0,1,2", "a,b", "0;1",
                            "1e300,2e300", "0,2e6", "-1e7,0", "0, ,1"})
        expect_refused(render({"--frame", "3", "--shutter", bad}), std::string("--shutter ") + bad);
    for (const char* bad : {"0", "3", "-1", "33", "64", "5000", "1e99", "nan", "x", ""})
        expect_refused(render({"--frame", "3", "--shutter", "0,1", "--shutter-segments", bad}),
                       std::string("segments ") + bad);
    expect_refused(render({"--frame", "3", "--shutter-segments", "4"}), "segments without a shutter");
    expect_refused(render({"--shutter", "0,1"}), "a shutter without a time");
    expect_refused(render({"--time", "0", "--shutter", "0,1"}, "triangle.obj"), "a scene without an animation");
    expect_refused(render({"--frame", "3", "--aov", "motion"}), "motion without a shutter");
    expect_refused(render({"--frame", "3", "--aov", "motion", "--shutter", "0.5,0.5"}), "motion in a shutter of one moment");
}

TEST_F(HostileShutter, ExtremeShuttersMakeAPicture)
{
    for (const char* shutter : {"0,1e-300", "-1e6,1e6", "0,1e6", "-0.5,-0.25", "1e5,1e5"})
        EXPECT_EQ(render({"--frame", "3", "--shutter", shutter}).exit_code, kDone) << shutter;
    EXPECT_EQ(render({"--frame", "3", "--fps", "1e-9", "--shutter", "-1e6,1e6"}).exit_code, kDone);
    EXPECT_EQ(render({"--time", "1e300", "--shutter", "0,1"}).exit_code, kDone);
    EXPECT_EQ(render({"--frame", "3", "--shutter", "-8,8", "--shutter-segments", "32", "--aov", "motion"}).exit_code, kDone);
}

struct HostileMove {
    const char* name;
    std::function<Mat4d(double tau)> at;
};

Mat4d scaled(Vec3d by)
{
    Mat4d m(1);
    for (int c = 0; c < 3; ++c) m[c] *= by[c];
    return m;
}

Mat4d shifted(Vec3d by)
{
    Mat4d m(1);
    m[3] = Vec4d(by, 1);
    return m;
}

// Returns motions that no chord follows.
std::vector<HostileMove> hostile_moves()
{
    return {
        {"collapses to a point", [](double tau) { return scaled(Vec3d(1 - tau)); }},
        {"flattens",
         [](double tau) {
             return scaled({1, 1 - tau, 1});
         }},
        {"turns inside out", [](double tau) { return scaled(Vec3d(1 - 2 * tau)); }},
        {"is nothing all the time",
         [](double tau) {
             return scaled(Vec3d(0)) * shifted({tau, 0, 0});
         }},
        {"teleports",
         [](double tau) {
             return shifted({tau < 0.5 ? 0.0 : 1e6, 0, 0});
         }},
        {"flies to the end of the world",
         [](double tau) {
             return shifted({tau * 1e11, tau * 1e11, 0});
         }},
        {"grows tenfold", [](double tau) { return scaled(Vec3d(1 + tau * 9)); }},
        {"grows a thousand times", [](double tau) { return scaled(Vec3d(1 + tau * 999)); }},
        {"grows 10^9 times", [](double tau) { return scaled(Vec3d(1 + tau * 1e9)); }},
        {"grows beyond measure", [](double tau) { return scaled(Vec3d(1 + tau * 1e15)); }},
        {"grows 10^9 times in one direction",
         [](double tau) {
             return scaled({1, 1 + tau * 1e9, 1});
         }},
        {"turns a hundred times",
         [](double tau) {
             Mat4d m(1);
             m[0] = Vec4d(std::cos(628 * tau), std::sin(628 * tau), 0, 0);
             m[1] = Vec4d(-std::sin(628 * tau), std::cos(628 * tau), 0, 0);
             return m;
         }},
        {"has tiny numbers",
         [](double tau) {
             return shifted({tau * 1e-300, 0, 0});
         }},
    };
}

/// Returns how much of the picture is no background.
double seen_part(const Image& image)
{
    const std::vector<float>& pixels = image.layers()[0].pixels;
    double sum = 0;
    for (std::size_t i = 3; i < pixels.size(); i += 4) sum += double(pixels[i]);
    return 4 * sum / double(pixels.size());
}

// Each of these motions makes a picture of finite numbers, within the memory of a small scene.
TEST(HostileMotion, MakesAPictureOfFiniteNumbers)
{
    // By default each motion is tested with one number of segments, in turns. "teleports" needs several, so it is
    // tested with both.
    int usual = 4;
    for (const HostileMove& motion : hostile_moves()) {
        usual = 5 - usual;
        for (const int segments : {1, 4}) {
            if (segments != usual && !is_long() && motion.name != std::string_view("teleports")) continue;
            Scene scene;
            const NodeId node = place(scene, scene.add(torus()), {0, 0, 0});
            const NodeId other = place(scene, scene.add(spindle(5)), {0, 0, -1});
            place(scene, scene.add(prism(5)), {-1.6, 0, 0}, 0.5);  // stands in view, whatever the others do
            scene.record_shutter(segments, [&](double tau) {
                scene.set_transform(node, motion.at(tau));
                scene.set_transform(other, motion.at(1 - tau));
            });
            const Camera camera = Camera::look_at({0, 1, 6}, {0, 0, 0}, {0, 1, 0}, 0.7f);
            Settings settings{.width = 16, .height = 12, .spp = 4, .aovs = Aov::Motion};
            settings.shutter = {0, 0.5};
            settings.background = false;
            Renderer renderer({.threads = 1, .memory_bytes = std::size_t(256) << 20});
            const Image image = renderer.render(scene, camera, settings);
            // The film makes black of samples that are not finite, so only their count tells of them.
            EXPECT_EQ(renderer.stats().image.samples_not_finite, 0u) << motion.name;
            EXPECT_GT(seen_part(image), 0.01) << motion.name;
            for (const Layer& layer : image.layers())
                for (const float value : layer.pixels)
                    ASSERT_TRUE(std::isfinite(value)) << motion.name << ", " << layer.name;
        }
    }
}

}  // namespace
}  // namespace occam::test
