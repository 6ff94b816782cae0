// Tests of what a query says about the instances that a ray hits.
#include <gtest/gtest.h>

#include "occam/occam.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

// A crowd shows one thing by instances, and is shown again as a whole.
TEST(Query, NamesTheInnermostInstanceThatWasHit)
{
    const auto at = [](double x, double y) { return Trs{.translation = {x, y, 0}}; };
    Scene scene;
    const CageId square = scene.add(test::unit_square());
    const NodeId thing = scene.add_node(scene.root(), {});
    const NodeId part = scene.add_node(thing, {.cages = {square}});
    const NodeId one = scene.add_node(scene.root(), {.place = at(2, 0), .instance_of = thing});
    const NodeId crowd = scene.add_node(scene.root(), {.place = at(0, 2)});
    const NodeId within = scene.add_node(crowd, {.place = at(2, 0), .instance_of = thing});
    const NodeId direct = scene.add_node(crowd, {.place = at(4, 0), .cages = {square}});
    const NodeId again = scene.add_node(scene.root(), {.place = at(0, 4), .instance_of = crowd});
    const Query query(scene, Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.8f));
    struct Case {
        double x, y;
        NodeId node, instance;
    };
    for (const Case& c : {Case{0.5, 0.5, part, {}},
                          {2.5, 0.5, part, one},
                          {2.5, 2.5, part, within},
                          {4.5, 2.5, direct, {}},
                          {2.5, 4.5, part, within},
                          {4.5, 4.5, direct, again}}) {
        const QueryRay ray{{c.x, c.y, 3}, {0, 0, -1}};
        const auto hit = query.closest(ray);
        ASSERT_TRUE(hit) << c.x << ' ' << c.y;
        EXPECT_EQ(hit->node, c.node) << c.x << ' ' << c.y;
        EXPECT_EQ(hit->instance, c.instance) << c.x << ' ' << c.y;
        FirstHit found;
        query.first_hits({&ray, 1}, {&found, 1});
        EXPECT_EQ(found.instance, c.instance) << c.x << ' ' << c.y;
    }
}

}  // namespace
}  // namespace occam
