#include "render/frame_control.h"

#include <algorithm>

#include "base/stopwatch.h"

namespace occam::render {

FrameControl::Progress FrameControl::progress() const noexcept
{
    Progress p;
    p.stage = stage_.load();
    const std::size_t all = samples_, before = done_before_;
    const std::size_t done = std::min<std::size_t>(all, done_ + unfinished_);
    const bool is_done = p.stage == Stage::Done;
    if (is_done) p.seconds_left = 0;
    if ((p.stage != Stage::Rendering && !is_done) || all == 0) return p;
    p.fraction = double(done) / double(all);
    if (is_done) return p;
    const double spent = seconds_since(start_.load());
    if (done > before) p.seconds_left = spent * double(all - done) / double(done - before);
    return p;
}

void FrameControl::start_samples(std::size_t samples, std::size_t done) noexcept
{
    samples_ = samples;
    done_ = done;
    done_before_ = done;
    start_ = Clock::now();
    enter(Stage::Rendering);
}

}  // namespace occam::render
