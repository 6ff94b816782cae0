#include "render/pass_budget.h"

#include <algorithm>
#include <string>

#include "base/error_without_file.h"
#include "render/settings.h"

namespace occam::render {

PassBudget::PassBudget(const Settings& settings) noexcept
{
    const PixelRect crop = crop_pixels(settings);
    const double samples = double(crop.width()) * crop.height() * settings.spp * std::max(1, settings.light_samples);
    most_ = std::max(kLeast, static_cast<std::uint64_t>(std::min(samples * kMostOfASample, 0x1p60)));
}

void PassBudget::refuse() const
{
    throw error_without_file(
        "too many surfaces that light passes lie one behind the other: the rays of the frame have passed " +
        std::to_string(most_) + " of them, which is the limit for its number of samples");
}

}  // namespace occam::render
