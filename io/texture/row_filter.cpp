#include "io/texture/row_filter.h"

#include <algorithm>

namespace occam {

RowFilter::RowFilter(int width, int height, MipImage& to)
    : to_(to),
      height_(height),
      sums_(static_cast<std::size_t>(to.width()), Vec4f(0)),
      means_(sums_.size()),
      area_(static_cast<float>(double(width) / to.width() * (double(height) / to.height())))
{
    // The ends of texels are in units of 1 / to.width() texels of the image, which is exact in integers.
    const std::int64_t unit = to.width();
    for (std::int64_t x = 0; x < to.width(); ++x) {
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
    const std::int64_t unit = to_.height(), lo = next_ * unit, hi = lo + unit, end = (std::int64_t(out_) + 1) * height_;
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
        means_[mirrors_columns_ ? sums_.size() - 1 - x : x] = sums_[x] / area_;
        sums_[x] = Vec4f(0);
    }
    to_.write_row(mirrors_rows_ ? to_.height() - 1 - out_ : out_, means_);
    ++out_;
}

}  // namespace occam
