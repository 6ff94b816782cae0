// Tests of the values of clips, and of what pose() and copy() do to nodes.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "scenegraph/scene.h"

namespace occam {
namespace {

using Path = Channel::Path;
using Interpolation = Channel::Interpolation;

Channel channel(Path path, Interpolation interpolation, std::vector<float> times, std::vector<float> values, int width)
{
    return {{}, path, interpolation, std::move(times), std::move(values), width};
}

std::vector<double> at(const Channel& c, double seconds)
{
    std::vector<double> values(static_cast<std::size_t>(c.width));
    evaluate(c, seconds, values);
    return values;
}

TEST(Clips, StepHoldsAndLinearMixesAndBothAreClampedAtTheirEnds)
{
    const std::vector<float> keys{1, 2, 4}, values{0, 10, 100, 2, 30, 200, 4, 40, 400};
    const Channel step = channel(Path::Translation, Interpolation::Step, keys, values, 3);
    EXPECT_EQ(at(step, 0), (std::vector<double>{0, 10, 100}));
    EXPECT_EQ(at(step, 1.999), (std::vector<double>{0, 10, 100}));
    EXPECT_EQ(at(step, 2), (std::vector<double>{2, 30, 200}));
    EXPECT_EQ(at(step, 9), (std::vector<double>{4, 40, 400}));
    const Channel linear = channel(Path::Translation, Interpolation::Linear, keys, values, 3);
    EXPECT_EQ(at(linear, 1.5), (std::vector<double>{1, 20, 150}));
    EXPECT_EQ(at(linear, 3.5), (std::vector<double>{3.5, 37.5, 350}));
    EXPECT_EQ(at(linear, -1), (std::vector<double>{0, 10, 100}));
    EXPECT_EQ(at(linear, 4), (std::vector<double>{4, 40, 400}));
}

// A cubic is its own Hermite interpolant, so keys with the cubic's values and slopes give the cubic back. Products of floats
// of few bits are exact in double, but sums are rounded; 1e-14 allows for a few hundred roundings.
TEST(Clips, CubicSplinesOfACubicAreThatCubic)
{
    const auto f = [](double t) { return 2 * t * t * t - 3 * t * t + 0.5 * t + 1; };
    const auto slope = [](double t) { return 6 * t * t - 6 * t + 0.5; };
    Channel c = channel(Path::Weights, Interpolation::CubicSpline, {-1, 0.5f, 3}, {}, 1);
    for (float t : c.times)
        for (double v : {slope(t), f(t), slope(t)}) c.values.push_back(float(v));
    for (double t = -1; t <= 3; t += 0.0625) EXPECT_NEAR(at(c, t)[0], f(t), 1e-13) << t;
    EXPECT_EQ(at(c, -5)[0], f(-1));
}

// A series of up to some fifty terms is rounded at each of them; 1e-14 allows for that.
TEST(Clips, RotationsTurnAtConstantSpeedTheShorterWay)
{
    for (const double angle : {1e-5, 1e-3, 0.5, 1.0, 2.0, 3.0, 3.14}) {
        const Vec4d a(0, 0, 0, 1), b(0, std::sin(angle / 2), 0, std::cos(angle / 2));
        for (const double sign : {1.0, -1.0})
            for (double t = 0; t <= 1; t += 0.125) {
                const Vec4d q = slerp(a, b * sign, t), wanted(0, std::sin(t * angle / 2), 0, std::cos(t * angle / 2));
                EXPECT_NEAR(std::abs(glm::dot(q, wanted)), 1, 1e-13) << angle << ' ' << t;
                EXPECT_LT(glm::length(q - wanted), 1e-14) << angle << ' ' << t;
            }
    }
    const Vec4d q = slerp({1, 0, 0, 0}, {-1, 0, 0, 0}, 0.5);
    EXPECT_EQ(q, Vec4d(1, 0, 0, 0)) << "the same rotation twice";
}

// A turntable that takes a minute turns by 10^-6 of a radian in the shutter of a motion layer, and by 3 * 10^-8 between two
// keys of a camera.
TEST(Clips, RotationsThatTakeLongTurnEvenlyInTheShortestTime)
{
    const Vec4d a(0, 0, 0, 1), b(0, std::sin(0.75), 0, std::cos(0.75));
    constexpr double kStep = 1e-8;
    for (double t = 0.1; t < 0.9; t += 0.03) {
        const double turned = glm::length(slerp(a, b, t + kStep) - slerp(a, b, t));
        EXPECT_NEAR(turned / kStep, 0.75, 1e-6) << t;
    }
}

TEST(Clips, RepeatOverTheirRange)
{
    const TimeRange range{1, 3};
    EXPECT_EQ(looped(range, 1.5), 1.5);
    EXPECT_EQ(looped(range, 3), 1);
    EXPECT_EQ(looped(range, 8), 2);
    EXPECT_EQ(looped(range, 0.5), 2.5);
    EXPECT_EQ(looped({2, 2}, 17), 2);
    EXPECT_EQ(looped(range, NAN), 1);
}

struct Walkers {
    Scene scene;
    NodeId hip, leg;
    ClipId walk, wave;

    Walkers()
    {
        NodeDesc desc;
        desc.place.translation = {0, 5, 0};
        hip = scene.add_node(scene.root(), desc);
        desc.place = {.translation = {1, 0, 0}, .scale = Vec3d(2)};
        leg = scene.add_node(hip, desc);
        walk = add("walk", hip, Path::Translation, {0, 0, 0, 8, 0, 0});
        wave = add("wave", leg, Path::Translation, {0, 0, 0, 0, 4, 0});
    }
    ClipId add(const char* name, NodeId target, Path path, std::vector<float> values)
    {
        Channel c = channel(path, Interpolation::Linear, {0, 1}, std::move(values), 3);
        c.target = target;
        return scene.add(Clip{name, {c}});
    }
    Vec3d translation(NodeId id) const { return scene.node(id).place.translation; }
};

TEST(Pose, MovesWhatTheClipNamesAndLetsGoOfWhatTheLastOneMoved)
{
    Walkers w;
    w.scene.pose(w.walk, 0.5);
    EXPECT_EQ(w.translation(w.hip), Vec3d(4, 0, 0));
    EXPECT_EQ(w.translation(w.leg), Vec3d(1, 0, 0));
    EXPECT_EQ(w.scene.world_from_node(w.leg)[3], Vec4d(5, 0, 0, 1));
    w.scene.pose(w.wave, 1);
    EXPECT_EQ(w.translation(w.hip), Vec3d(0, 5, 0)) << "back where it was";
    EXPECT_EQ(w.translation(w.leg), Vec3d(0, 4, 0));
    EXPECT_EQ(w.scene.node(w.leg).place.scale, Vec3d(2)) << "no channel of it";
    w.scene.pose({});
    EXPECT_EQ(w.translation(w.leg), Vec3d(1, 0, 0));
}

TEST(Pose, GoesBackToWhatTheApplicationSetMeanwhile)
{
    Walkers w;
    w.scene.pose(w.walk, 0.5);
    w.scene.set_transform(w.hip, Trs{.translation = {7, 7, 7}});
    w.scene.pose(w.walk, 1);
    EXPECT_EQ(w.translation(w.hip), Vec3d(8, 0, 0));
    w.scene.pose({});
    EXPECT_EQ(w.translation(w.hip), Vec3d(7, 7, 7));
}

TEST(Pose, LetsGoOfThePropertiesThatTheNextClipDoesNotMove)
{
    Walkers w;
    w.scene.set_morph_weights(w.hip, {0.25f});
    Channel c = channel(Path::Weights, Interpolation::Linear, {0, 1}, {0, 1}, 1);
    c.target = w.hip;
    const ClipId grow = w.scene.add(Clip{"grow", {c}});
    const auto weights = [&] { return w.scene.node(w.hip).morph_weights; };
    w.scene.pose(w.walk, 1);
    w.scene.pose(grow, 1);
    EXPECT_EQ(w.translation(w.hip), Vec3d(0, 5, 0));
    EXPECT_EQ(weights(), std::vector<float>{1});
    w.scene.pose(w.walk, 1);
    EXPECT_EQ(w.translation(w.hip), Vec3d(8, 0, 0));
    EXPECT_EQ(weights(), std::vector<float>{0.25f});
    const ClipAt both[] = {{w.walk, 0.5}, {grow, 0.5}};
    w.scene.pose(both);
    w.scene.pose({});
    EXPECT_EQ(w.translation(w.hip), Vec3d(0, 5, 0));
    EXPECT_EQ(weights(), std::vector<float>{0.25f});
}

// The clips of a body may be those of the scene, and those of its face the ones that came with it.
TEST(Pose, OfOneLeavesThePropertiesThatOnlyAnotherMoves)
{
    Scene part;
    const NodeId in_part = part.add_node(part.root(), {.name = "head", .morph_weights = {0.25f}});
    Channel blinks = channel(Path::Weights, Interpolation::Step, {0}, {0.75f}, 1);
    blinks.target = in_part;
    part.add(Clip{"blink", {blinks}});
    Scene scene;
    const AddedScene added = scene.add(std::move(part), scene.root());
    const NodeId head = scene.find_node("head");
    Channel walks = channel(Path::Translation, Interpolation::Step, {0}, {5, 0, 0}, 3);
    walks.target = head;
    const ClipId walk = scene.add(Clip{"walk", {walks}});
    const ClipAt blink[] = {{added.clips[0], 0}};
    const auto expect = [&](double x, float weight, const char* when) {
        EXPECT_EQ(scene.node(head).parent_from_node[3].x, x) << when;
        EXPECT_EQ(scene.node(head).morph_weights, std::vector<float>{weight}) << when;
    };
    scene.pose(walk, 0);
    expect(5, 0.25f, "the scene is posed");
    scene.pose(blink, added.node);
    expect(5, 0.75f, "the part is posed");
    scene.pose(walk, 0);
    expect(5, 0.75f, "the scene is posed again");
    scene.pose({}, added.node);
    expect(5, 0.25f, "the part lets go");
    scene.pose(blink, added.node);
    scene.pose({});
    expect(0, 0.75f, "the scene lets go");
    scene.pose({}, added.node);
    expect(0, 0.25f, "all let go");
}

TEST(Pose, MixesClipsThatMoveTheSameProperty)
{
    Walkers w;
    const ClipId rise = w.add("rise", w.hip, Path::Translation, {0, 0, 0, 0, 8, 0});
    const ClipAt mix[] = {{w.walk, 1, 3}, {rise, 1, 1}, {w.wave, 1, 0.5}};
    w.scene.pose(mix);
    EXPECT_EQ(w.translation(w.hip), Vec3d(6, 2, 0));
    EXPECT_EQ(w.translation(w.leg), Vec3d(0, 4, 0)) << "alone, its share does not matter";
    const ClipAt none[] = {{w.walk, 1, 0}};
    w.scene.pose(none);
    EXPECT_EQ(w.translation(w.hip), Vec3d(0, 5, 0));
}

TEST(Pose, OfACopyLeavesTheOthersAlone)
{
    Walkers w;
    w.scene.pose(w.walk, 0.5);
    const NodeId copy = w.scene.copy(w.hip, w.scene.root());
    EXPECT_EQ(w.translation(copy), Vec3d(0, 5, 0)) << "the pose of the moment is not copied";
    const ClipAt both[] = {{w.walk, 1, 1}, {w.wave, 0.5, 1}};
    w.scene.pose(both, copy);
    EXPECT_EQ(w.translation(copy), Vec3d(8, 0, 0));
    EXPECT_EQ(w.translation(w.scene.node(copy).children.at(0)), Vec3d(0, 2, 0));
    EXPECT_EQ(w.translation(w.hip), Vec3d(4, 0, 0));
    EXPECT_EQ(w.translation(w.leg), Vec3d(1, 0, 0));
    w.scene.remove(copy);
    EXPECT_THROW(w.scene.pose(both, copy), Error);
    EXPECT_THROW(w.scene.pose(both, w.hip), Error) << "no copy";
    EXPECT_THROW(w.scene.copy(w.hip, w.leg), Error) << "into itself";
}

TEST(Pose, OfACopyOfACopyIsItsOwn)
{
    Walkers w;
    const auto leg_of = [&](NodeId copy) { return w.scene.node(copy).children.at(0); };
    const NodeId first = w.scene.copy(w.hip, w.scene.root()), second = w.scene.copy(first, w.scene.root());
    const ClipAt both[] = {{w.walk, 1, 1}, {w.wave, 0.5, 1}};
    w.scene.pose(both, second);
    EXPECT_EQ(w.translation(second), Vec3d(8, 0, 0));
    EXPECT_EQ(w.translation(leg_of(second)), Vec3d(0, 2, 0));
    EXPECT_EQ(w.translation(first), Vec3d(0, 5, 0));
    EXPECT_EQ(w.translation(w.hip), Vec3d(0, 5, 0));
    const ClipId of_copy = w.add("of the copy", first, Path::Translation, {0, 0, 0, 0, 0, 3});
    w.scene.remove(w.hip);
    const NodeId third = w.scene.copy(second, w.scene.root());
    w.scene.pose(both, third);
    EXPECT_EQ(w.translation(leg_of(third)), Vec3d(0, 2, 0)) << "also when the original is gone";
    const ClipAt at{of_copy, 1};
    w.scene.pose({&at, 1}, second);
    EXPECT_EQ(w.translation(second), Vec3d(0, 0, 3));
}

// A crowd holds an original and a copy of it; in a copy of the crowd, clips move what the original became.
TEST(Pose, OfACopyMovesTheCounterpartOfTheOriginal)
{
    Walkers w;
    const NodeId crowd = w.scene.add_node(w.scene.root(), {});
    const NodeId walker = w.scene.add_node(crowd, {});
    const ClipId go = w.add("go", walker, Path::Translation, {0, 0, 0, 1, 0, 0});
    w.scene.copy(walker, crowd);
    const NodeId copy = w.scene.copy(crowd, w.scene.root());
    const ClipAt at{go, 1};
    w.scene.pose({&at, 1}, copy);
    EXPECT_EQ(w.translation(w.scene.node(copy).children.at(0)), Vec3d(1, 0, 0));
    EXPECT_EQ(w.translation(w.scene.node(copy).children.at(1)), Vec3d(0));
    EXPECT_EQ(w.translation(walker), Vec3d(0));
}

TEST(Pose, SameMomentMarksNothing)
{
    Walkers w;
    w.scene.pose(w.walk, 0.5);
    w.scene.refit();
    w.scene.pose(w.walk, 0.5);
    EXPECT_FALSE(w.scene.node(w.scene.root()).dirty);
    w.scene.pose(w.walk, 0.6);
    EXPECT_TRUE(w.scene.node(w.scene.root()).dirty);
}

TEST(Pose, RefusesWhatIsNoMoment)
{
    Walkers w;
    EXPECT_THROW(w.scene.pose(ClipId(), 0), Error);
    EXPECT_THROW(w.scene.pose(w.walk, NAN), Error);
    const ClipAt negative[] = {{w.walk, 0, -1}};
    EXPECT_THROW(w.scene.pose(negative), Error);
    const Scene::FrameLock lock(w.scene);
    EXPECT_THROW(w.scene.pose(w.walk, 0), Error);
}

// Blender writes a clip for each object; a character has several clips for the same joints.
TEST(Clips, ThoseThatMoveOtherNodesPlayTogether)
{
    Scene scene;
    const NodeId left = scene.add_node(scene.root(), {}), right = scene.add_node(scene.root(), {});
    const auto clip = [&](const std::string& name, const std::vector<NodeId>& targets) {
        Clip c{name, {}};
        for (const NodeId target : targets) {
            c.channels.push_back(channel(Path::Translation, Interpolation::Linear, {0, 1}, {0, 0, 0, 1, 0, 0}, 3));
            c.channels.back().target = target;
        }
        return scene.add(std::move(c));
    };
    EXPECT_TRUE(scene.clips_together().empty());
    const ClipId walk = clip("walk", {left});
    clip("run", {left});
    const ClipId door = clip("door", {right});
    clip("both", {left, right});
    clip("nothing", {});
    EXPECT_EQ(scene.clips_together(), (std::vector<ClipId>{walk, door}));
}

// The matrix that a node was given is what it rests at where a clip moves only a part of it.
TEST(Pose, AMatrixIsTheRestOfWhatAClipLeavesOut)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    Mat4d placed(1);  // a quarter turn about y, twice as long along x, mirrored along z
    placed[0] = {0, 0, -2, 0};
    placed[2] = {-1, 0, 0, 0};
    placed[3] = {5, 6, 7, 1};
    const auto clip_with = [&](Path path, std::vector<float> value) {
        const int width = static_cast<int>(value.size());
        Channel c = channel(path, Interpolation::Step, {0}, std::move(value), width);
        c.target = node;
        return scene.add(Clip{"", {c}});
    };
    const ClipId moves = clip_with(Path::Translation, {1, 2, 3}), turns = clip_with(Path::Rotation, {0, 0, 0, 1});
    scene.pose(moves, 0);  // an earlier pose has no say
    scene.set_transform(node, placed);
    scene.pose(turns, 0);
    EXPECT_EQ(Vec3d(scene.node(node).parent_from_node[3]), Vec3d(5, 6, 7));
    scene.pose(moves, 0);
    const Mat4d moved = scene.node(node).parent_from_node;
    EXPECT_EQ(Vec3d(moved[3]), Vec3d(1, 2, 3));
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(moved[c][r], placed[c][r], 1e-15) << c << ' ' << r;
    scene.pose({}, NodeId());
    EXPECT_EQ(scene.node(node).parent_from_node, placed);
}

// Flat things, such as shadows, and things of any size keep their place and direction where a clip moves one property.
TEST(Pose, FlatMatricesAndThoseOfAnySizeAreDecomposedWithoutALoss)
{
    const double half = std::sqrt(0.5);
    const Mat3d turn(Vec3d(half, 0, -half), Vec3d(0, 1, 0), Vec3d(half, 0, half));
    for (const Vec3d scale : {Vec3d(1, 0, 1), Vec3d(0, 1, 1), Vec3d(1, 1, 0), Vec3d(0, 0, 2), Vec3d(0, 3, 0), Vec3d(2, 0, 0),
                              Vec3d(0), Vec3d(1, -2, 3), Vec3d(1e160), Vec3d(1e-170), Vec3d(1e200, 1, 1e-200)}) {
        Mat4d matrix(1);
        for (int axis = 0; axis < 3; ++axis) matrix[axis] = Vec4d(turn[axis] * scale[axis], 0);
        matrix[3] = Vec4d(1, 2, 3, 1);
        const Mat4d again = decomposed(matrix).matrix();
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row) {
                const double size = column < 3 ? std::max(std::abs(scale[column]), 1e-300) : 1.0;
                EXPECT_NEAR(again[column][row] / size, matrix[column][row] / size, 1e-12)
                    << scale.x << ' ' << scale.y << ' ' << scale.z << ", " << column << ' ' << row;
            }
    }
}

TEST(Pose, WeightsAndValuesOfAnySizeGiveNumbersOrAreRefused)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    Channel goes = channel(Path::Translation, Interpolation::Step, {0}, {1, 2, 3}, 3);
    goes.target = node;
    const ClipId one = scene.add(Clip{"", {goes}});
    const NodeId other = scene.add_node(scene.root(), {});
    goes.target = other;
    const ClipId light = scene.add(Clip{"", {goes}});
    const ClipAt all[] = {{one, 0, 1e308}, {one, 0, 1e308}, {light, 0, 1e-300}};
    scene.pose(all);
    for (const NodeId id : {node, other})
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(scene.node(id).place.translation[c], c + 1, 1e-12);
    const Vec3d before = scene.node(node).place.translation;

    Channel swells = channel(Path::Weights, Interpolation::CubicSpline, {0, 1}, {0, 3e38f, 3e38f, -3e38f, 3e38f, 0}, 1);
    swells.target = node;
    const ClipId large = scene.add(Clip{"", {swells}});
    EXPECT_THROW(scene.pose(large, 0.5), Error);
    EXPECT_TRUE(scene.node(node).morph_weights.empty());
    EXPECT_EQ(scene.node(node).place.translation, before) << "nothing has changed";
}

}  // namespace
}  // namespace occam
