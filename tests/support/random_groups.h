// The groups, crowds and on-demand cages of a random world (random_world.h).
#pragma once

#include <vector>

#include "tests/support/case_random.h"

namespace occam::test {

/// Returns a place within the picture of a random world.
Trs random_place(CaseRandom& random);

/// Makes and edits groups of instances, which may show groups that were made before them; crowds, whose children are many
/// enough for a tree of their own (scenegraph/child_boxes.h); and nodes with a cage that is made when a ray asks for it.
class RandomGroups {
public:
    /// Makes one edit. Returns what it was.
    /// shown   a node that an instance may show
    const char* edit(Scene& scene, CaseRandom& random, NodeId shown);

private:
    const char* add(Scene& scene, CaseRandom& random, NodeId shown);
    const char* add_crowd(Scene& scene, CaseRandom& random, NodeId shown);
    const char* add_on_demand(Scene& scene, CaseRandom& random);
    const char* edit_crowd(Scene& scene, CaseRandom& random, NodeId shown);

    std::vector<NodeId> groups_, crowd_, demanded_;
    NodeId crowd_parent_;
};

}  // namespace occam::test
