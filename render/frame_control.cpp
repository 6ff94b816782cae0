#include "render/frame_control.h"

namespace occam::render {

FrameControl::Progress FrameControl::progress() const noexcept
{
    Progress p;
    p.stage = stage_.load();
    const std::size_t all = tiles_, done = tiles_done_;
    if (p.stage == Stage::Done) return {p.stage, 1, 0};
    if (p.stage != Stage::Rendering || all == 0) return p;
    p.fraction = double(done) / double(all);
    const double spent = std::chrono::duration<double>(Clock::now() - start_.load()).count();
    if (done > 0) p.seconds_left = spent * (1 - p.fraction) / p.fraction;
    return p;
}

void FrameControl::start_tiles(std::size_t count) noexcept
{
    tiles_ = count;
    start_ = Clock::now();
    enter(Stage::Rendering);
}

}  // namespace occam::render
