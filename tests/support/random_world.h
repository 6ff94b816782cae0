// A scene that random edits change, for tests of what is kept between frames.
#pragma once

#include <vector>

#include "tests/support/random_groups.h"
#include "tests/support/random_look.h"
#include "tests/support/random_parts.h"

namespace occam::test {

/// Makes edits of all kinds. What a step does depends on the seed and on the steps before it alone, so the same steps make
/// the same scene, with the same handles.
class RandomWorld {
public:
    explicit RandomWorld(std::uint64_t seed);

    /// Makes one edit. Returns what it was.
    const char* edit();
    Scene& scene() noexcept { return scene_; }
    /// Returns settings and a camera for a picture after the edits so far.
    Settings settings() const;
    Camera camera();

private:
    /// Returns a case for one more part, which neither is far away nor takes long to look through.
    RandomCase part_case() const;
    /// Returns the case whose settings and camera the picture has.
    RandomCase picture_case() const;
    void add_object();
    AddedPart* any_object(CaseRandom& random);
    const char* make_edit();
    const char* edit_object(CaseRandom& random, const AddedPart& object);
    const char* edit_nodes(CaseRandom& random, AddedPart& object);
    const char* edit_links(CaseRandom& random, const AddedPart& object);
    /// Drops the handles of objects, joints and copies that were removed with what is above them.
    void forget_removed();
    const char* edit_light(CaseRandom& random);
    const char* edit_shutter(CaseRandom& random);
    const char* edit_clips(CaseRandom& random, const AddedPart& object);

    std::uint64_t seed_, step_ = 0;
    Scene scene_;
    std::vector<AddedPart> objects_;
    std::vector<NodeId> copies_;
    std::vector<LightId> lights_;
    RandomGroups groups_;
};

}  // namespace occam::test
