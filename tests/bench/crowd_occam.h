// The crowd as an application of Occam renders it: edits between frames, and one renderer for all of them.
#pragma once

#include "api/include/occam/occam.h"
#include "tests/bench/crowd.h"

namespace occam::bench {

class OccamCrowd {
public:
    /// crowd   borrowed
    explicit OccamCrowd(const Crowd& crowd, const Resources& resources = {});

    /// Edits the scene for a frame and renders it; returns the wall seconds of both.
    double render(int frame, const Recipe& recipe, int pixels = kCrowdPixels);
    double edit_seconds() const { return edit_seconds_; }
    const FrameStats& stats() const { return renderer_.stats(); }
    /// Uses these settings from now on; what is kept from frame to frame is made anew.
    void use(const Resources& resources) { renderer_ = Renderer(resources); }

private:
    const Crowd& crowd_;
    Scene scene_;
    Camera camera_;
    Renderer renderer_;
    std::vector<CageId> cages_;
    std::vector<Vec3f> positions_;
    double edit_seconds_ = 0;
};

}  // namespace occam::bench
