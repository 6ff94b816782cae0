#include "io/texture/jpeg_head.h"

#include <algorithm>

namespace occam {

std::optional<JpegHead> jpeg_head(std::span<const std::byte> file)
{
    const auto number = [&](std::size_t at, std::size_t count) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < count; ++i)
            value = value << 8 | (at + i < file.size() ? std::to_integer<std::uint32_t>(file[at + i]) : 0);
        return value;
    };
    constexpr std::uint32_t kScan = 0xda, kFirstFrame = 0xc0, kLastFrame = 0xcf, kTables[] = {0xc4, 0xc8, 0xcc};
    JpegHead head;
    bool has_frame = false;
    for (std::size_t at = 0; at + 1 < file.size();) {
        const std::uint32_t marker = number(at + 1, 1);
        // Codes of a scan, fill bytes, and markers without a segment are passed byte by byte.
        const bool has_segment = number(at, 1) == 0xff && marker >= kFirstFrame && marker < 0xff &&
                                 !(marker >= 0xd0 && marker <= 0xd9);
        if (!has_segment) {
            ++at;
            continue;
        }
        if (marker <= kLastFrame && std::ranges::find(kTables, marker) == std::end(kTables)) {
            has_frame = true;
            head.height = std::max(head.height, number(at + 5, 2));
            head.width = std::max(head.width, number(at + 7, 2));
        }
        head.scans += marker == kScan;
        at += 2 + std::max(number(at + 2, 2), 2u);
    }
    return has_frame ? std::optional(head) : std::nullopt;
}

}  // namespace occam
