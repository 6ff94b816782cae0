#include "io/texture/bmp_masks.h"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

namespace occam {

namespace {

constexpr BmpMasks kUsualMasks = {0x00ff0000, 0x0000ff00, 0x000000ff, 0xff000000};
constexpr std::size_t kBmpPixelsAt = 10, kBmpHeaderAt = 14, kBmpBitsAt = 28, kBmpCompressionAt = 30, kBmpMasksAt = 54;

}  // namespace

std::optional<BmpMasks> masks_of_bmp(ImageBytes& bytes)
{
    constexpr std::uint32_t kOldestHeader = 12, kHeaderWithAlpha = 56, kByMasks = 3, kByMasksWithAlpha = 6, kMark = 0x4d42;
    const std::uint32_t header = little_endian(bytes, kBmpHeaderAt, 4),
                        compression = little_endian(bytes, kBmpCompressionAt, 4);
    if (little_endian(bytes, 0, 2) != kMark || header == kOldestHeader || little_endian(bytes, kBmpBitsAt, 2) != 32)
        return std::nullopt;
    BmpMasks masks = kUsualMasks;
    const bool is_by_masks = compression == kByMasks || compression == kByMasksWithAlpha;
    if (is_by_masks)
        for (std::size_t k = 0; k < 3; ++k) masks[k] = little_endian(bytes, kBmpMasksAt + 4 * k, 4);
    const bool may_have_alpha = is_by_masks && (header >= kHeaderWithAlpha || compression == kByMasksWithAlpha);
    masks[3] = may_have_alpha ? little_endian(bytes, kBmpMasksAt + 12, 4) : 0;
    return masks;
}

bool are_usual(const BmpMasks& masks) noexcept
{
    return std::equal(kUsualMasks.begin(), kUsualMasks.begin() + 3, masks.begin()) &&
           (masks[3] == 0 || masks[3] == kUsualMasks[3]);
}

bool are_bytes(const BmpMasks& masks) noexcept
{
    std::uint32_t all = 0;
    for (std::size_t k = 0; k < masks.size(); ++k) {
        if (k == 3 && masks[k] == 0) continue;
        if (std::ranges::find(kUsualMasks, masks[k]) == kUsualMasks.end() || (all & masks[k])) return false;
        all |= masks[k];
    }
    return true;
}

void put_in_usual_order(std::vector<std::byte>& file, const BmpMasks& masks)
{
    if (file.size() < kBmpMasksAt) return;
    ImageBytes bytes(std::span(std::as_const(file)));
    std::size_t pixel = little_endian(bytes, kBmpPixelsAt, 4);
    if (pixel < kBmpHeaderAt + std::size_t(little_endian(bytes, kBmpHeaderAt, 4))) return;  // the head is not changed
    std::array<std::size_t, 4> to{}, from{};
    for (std::size_t k = 0; k < 4; ++k) {
        to[k] = static_cast<std::size_t>(std::countr_zero(kUsualMasks[k])) / 8;
        from[k] = masks[k] == 0 ? to[k] : static_cast<std::size_t>(std::countr_zero(masks[k])) / 8;
    }
    const std::size_t parts = masks[3] == 0 ? 3 : 4;
    for (; pixel + 4 <= file.size(); pixel += 4) {
        std::array<std::byte, 4> old{};
        std::copy_n(&file[pixel], 4, old.begin());
        for (std::size_t k = 0; k < parts; ++k) file[pixel + to[k]] = old[from[k]];
    }
}

}  // namespace occam
