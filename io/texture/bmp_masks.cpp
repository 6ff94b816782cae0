#include "io/texture/bmp_masks.h"

#include <algorithm>
#include <bit>
#include <span>

namespace occam {

namespace {

constexpr BmpMasks kUsualMasks = {0x00ff0000, 0x0000ff00, 0x000000ff, 0xff000000};
constexpr std::size_t kBmpPixelsAt = 10, kBmpHeaderAt = 14, kBmpBitsAt = 28, kBmpCompressionAt = 30, kBmpMasksAt = 54;

std::uint32_t little_endian_of(ImageBytes& bytes, std::uintmax_t at, std::size_t count)
{
    std::array<unsigned char, 4> word{};
    bytes.read(at, std::span(word).first(count));
    return word[0] | std::uint32_t(word[1]) << 8 | std::uint32_t(word[2]) << 16 | std::uint32_t(word[3]) << 24;
}

}  // namespace

std::optional<BmpMasks> masks_of_bmp(ImageBytes& bytes)
{
    constexpr std::uint32_t kOldestHeader = 12, kHeaderWithAlpha = 56, kByMasks = 3, kByMasksWithAlpha = 6, kMark = 0x4d42;
    const std::uint32_t header = little_endian_of(bytes, kBmpHeaderAt, 4),
                        compression = little_endian_of(bytes, kBmpCompressionAt, 4);
    if (little_endian_of(bytes, 0, 2) != kMark || header == kOldestHeader || little_endian_of(bytes, kBmpBitsAt, 2) != 32)
        return std::nullopt;
    BmpMasks masks = kUsualMasks;
    const bool is_by_masks = compression == kByMasks || compression == kByMasksWithAlpha;
    if (is_by_masks)
        for (std::size_t k = 0; k < 3; ++k) masks[k] = little_endian_of(bytes, kBmpMasksAt + 4 * k, 4);
    const bool may_have_alpha = is_by_masks && (header >= kHeaderWithAlpha || compression == kByMasksWithAlpha);
    masks[3] = may_have_alpha ? little_endian_of(bytes, kBmpMasksAt + 12, 4) : 0;
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
    const auto at = [&](std::size_t place) { return std::to_integer<std::size_t>(file[place]); };
    if (file.size() < kBmpMasksAt) return;
    std::size_t pixel = at(kBmpPixelsAt) | at(kBmpPixelsAt + 1) << 8 | at(kBmpPixelsAt + 2) << 16 |
                        at(kBmpPixelsAt + 3) << 24;
    const std::size_t header = at(kBmpHeaderAt) | at(kBmpHeaderAt + 1) << 8 | at(kBmpHeaderAt + 2) << 16 |
                               at(kBmpHeaderAt + 3) << 24;
    if (pixel < kBmpHeaderAt + header) return;  // what was read of the head stays as it is
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
