#include "io/texture/row_filter.h"

#include <algorithm>

namespace occam {

RowFilter::RowFilter(int width, int height, MipImage& to, Orientation orientation)
    : to_(to),
      orientation_(orientation),
      columns_(orientation.swaps_axes ? to.height() : to.width()),
      rows_(orientation.swaps_axes ? to.width() : to.height()),
      height_(height),
      sums_(static_cast<std::size_t>(columns_), Vec4f(0)),
      means_(sums_.size()),
      area_(static_cast<float>(double(width) / columns_ * (double(height) / rows_)))
{
    // The ends of texels are in units of 1 / columns_ texels of the image, which is exact in integers.
    const std::int64_t unit = columns_;
    for (std::int64_t x = 0; x < columns_; ++x) {
        const std::int64_t lo = x * width, hi = lo + width;
        for (std::int64_t i = lo / unit; i * unit < hi; ++i) {
            const std::int64_t overlap = std::min(hi, (i + 1) * unit) - std::max(lo, i * unit);
            taps_.push_back({static_cast<int>(i), static_cast<float>(overlap) / static_cast<float>(unit)});
        }
        ends_.push_back(taps_.size());
    }
}

void RowFilter::add(std::span<const Vec4f> row)
{
    // The same units are used along the rows; a row of the image may lie under two of the texture.
    const std::int64_t unit = rows_, lo = next_ * unit, hi = lo + unit, end = (std::int64_t(out_) + 1) * height_;
    const auto weight = [&](std::int64_t overlap) { return static_cast<float>(overlap) / static_cast<float>(unit); };
    ++next_;
    add_part(row, weight(std::min(hi, end) - lo));
    if (hi < end) return;
    write();
    if (hi > end) add_part(row, weight(hi - end));
}

void RowFilter::add_part(std::span<const Vec4f> row, float weight) noexcept
{
    std::size_t tap = 0;
    for (std::size_t x = 0; x < sums_.size(); ++x)
        for (; tap < ends_[x]; ++tap)
            sums_[x] += row[static_cast<std::size_t>(taps_[tap].texel)] * (taps_[tap].weight * weight);
}

void RowFilter::write()
{
    for (std::size_t x = 0; x < sums_.size(); ++x) {
        means_[orientation_.mirrors_columns ? sums_.size() - 1 - x : x] = sums_[x] / area_;
        sums_[x] = Vec4f(0);
    }
    const int place = orientation_.mirrors_rows ? rows_ - 1 - out_ : out_;
    if (orientation_.swaps_axes) to_.write_column(place, means_);
    else to_.write_row(place, means_);
    ++out_;
}

}  // namespace occam
