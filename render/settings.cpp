#include "render/settings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "base/error_without_file.h"
#include "base/machine_memory.h"
#include "base/processors.h"
#include "render/setting_rows.h"
#include "scenegraph/content_rules.h"

namespace occam::render {
namespace {

void require(bool holds, const char* setting, const std::string& rule)
{
    if (!holds) throw error_without_file(rule, setting);
}

// Returns a share of a side in pixels. A float that is meant to name a border between two pixels names that border, although
// it is rounded: crops from 0 to 0.1 and from 0.1 to 0.2 have no pixel in common, and as many columns.
double in_pixels(float share, int side) noexcept
{
    const double exact = double(share) * side, border = std::round(exact);
    return std::abs(exact - border) <= side * 0x1p-24 ? border : exact;
}

std::string crop_text(const Settings& s)
{
    char text[96];
    std::snprintf(text, sizeof text, "%.9g,%.9g,%.9g,%.9g", double(s.crop_x0), double(s.crop_x1), double(s.crop_y0),
                  double(s.crop_y1));
    return text;
}

}  // namespace

bool shows_cost(View view) noexcept
{
    return std::any_of(std::begin(kViews), std::end(kViews),
                       [&](const ViewRow& row) { return row.view == view && row.is_cost; });
}

Resources Resources::resolved() const
{
    Resources r = *this;
    using accel::TreeKind;
    require(tree == TreeKind::Auto || tree == TreeKind::Kd || tree == TreeKind::Bvh, "tree", "expected a kind of tree");
    require(threads >= 0, "threads", "expected 0 or more, not " + std::to_string(threads));
    require(workers_a_tree >= 0, "workers_a_tree", "expected 0 or more, not " + std::to_string(workers_a_tree));
    if (r.threads == 0) r.threads = processor_count();
    if (r.workers_a_tree == 0 || r.workers_a_tree > r.threads) r.workers_a_tree = r.threads;
    if (r.memory_bytes == 0) {
        // A quarter of the machine, but no more than few threads have a use for.
        const std::size_t most = std::max(std::size_t(3) << 30, static_cast<std::size_t>(r.threads) << 29);
        r.memory_bytes = std::clamp(machine_memory_bytes() / 4, std::size_t(256) << 20, most);
    }
    return r;
}

PixelRect crop_pixels(const Settings& s) noexcept
{
    const auto first = [](float share, int side) {
        return std::clamp(static_cast<int>(std::floor(in_pixels(share, side))), 0, side - 1);
    };
    const auto last = [](float share, int side) {
        return std::clamp(static_cast<int>(std::ceil(in_pixels(share, side))), 1, side);
    };
    PixelRect r{first(s.crop_x0, s.width), first(s.crop_y0, s.height), last(s.crop_x1, s.width), last(s.crop_y1, s.height)};
    r.x1 = std::max(r.x1, r.x0 + 1);
    r.y1 = std::max(r.y1, r.y0 + 1);
    return r;
}

void check(const Settings& s)
{
    const auto sides = "expected from 1 to " + std::to_string(kMaxSide) + " pixels a side, not " + std::to_string(s.width) +
                       'x' + std::to_string(s.height);
    require(s.width >= 1 && s.width <= kMaxSide && s.height >= 1 && s.height <= kMaxSide, "size", sides);
    const auto is_range = [](float a, float b) { return a >= 0 && a < b && b <= 1; };
    require(is_range(s.crop_x0, s.crop_x1) && is_range(s.crop_y0, s.crop_y1), "crop",
            "expected shares of the frame with 0 <= X0 < X1 <= 1 and 0 <= Y0 < Y1 <= 1, not " + crop_text(s));
    const PixelRect crop = crop_pixels(s);
    const std::int64_t pixels = std::int64_t(crop.width()) * crop.height();
    require(pixels <= kMaxPixels, "size",
            "expected at most " + std::to_string(kMaxPixels) + " pixels in one picture, not " + std::to_string(pixels));
    for (const SettingRow& row : kSettings) {
        const auto is_in_range = [&]<class T>(T Settings::*member) {
            if constexpr (std::is_enum_v<T>) return !name_of(s.*member).empty();
            else if constexpr (std::is_same_v<T, bool>) return true;
            else return double(s.*member) >= row.least && double(s.*member) <= row.most;
        };
        if (std::visit(is_in_range, row.member)) continue;
        const std::string range = range_of(row);
        throw error_without_file(
            range.empty() ? "expected one of the choices that it has" : "expected " + range + ", not " + text_of(row, s),
            std::string(row.name));
    }
    check(s.shutter);
    AovSet layers;
    for (const AovRow& row : kAovs) layers |= row.aov;
    require((s.aovs | layers) == layers, "aov", "expected layers that exist");
    require(!s.has(Aov::Motion) || s.shutter.is_open(), "aov", "motion needs a shutter that is open for some time");
}

}  // namespace occam::render
