#include "io/texture/image_metadata.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

namespace occam {

namespace {

class Copier {
public:
    explicit Copier(std::span<const std::byte> file) : file_(file) { out_.reserve(file.size()); }

    std::size_t left() const noexcept { return file_.size() - at_; }
    /// Returns the byte `ahead` of the current position; 0 beyond the end.
    std::uint32_t byte(std::size_t ahead) const noexcept
    {
        return ahead < left() ? std::to_integer<std::uint32_t>(file_[at_ + ahead]) : 0;
    }
    std::uint32_t big_endian(std::size_t ahead, std::size_t count) const noexcept
    {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < count; ++i) value = value << 8 | byte(ahead + i);
        return value;
    }
    void skip(std::size_t bytes) noexcept { at_ += std::min(bytes, left()); }
    void copy(std::size_t bytes)
    {
        const auto part = file_.subspan(at_, std::min(bytes, left()));
        out_.insert(out_.end(), part.begin(), part.end());
        skip(bytes);
    }
    std::vector<std::byte> take() { return std::move(out_); }

private:
    std::span<const std::byte> file_;
    std::vector<std::byte> out_;
    std::size_t at_ = 0;
};

// Keeps the critical chunks, which an upper-case first letter marks (PNG, sec. 5.4), and tRNS, the only other one that
// changes texels.
std::vector<std::byte> without_png_metadata(std::span<const std::byte> file)
{
    constexpr std::uint32_t kLowerCase = 0x20, kTransparency = 0x74524e53;
    constexpr std::size_t kMagic = 8, kAround = 12;
    Copier copier(file);
    copier.copy(kMagic);
    while (copier.left() > 0) {
        const std::size_t size = kAround + copier.big_endian(0, 4);
        if ((copier.byte(4) & kLowerCase) != 0 && copier.big_endian(4, 4) != kTransparency) copier.skip(size);
        else copier.copy(size);
    }
    return copier.take();
}

// Leaves out application segments and comments before the first scan (JPEG: ITU T.81, annex B), except those of JFIF and
// Adobe, which say what the components are.
std::vector<std::byte> without_jpeg_metadata(std::span<const std::byte> file)
{
    constexpr std::uint32_t kApp0 = 0xe0, kApp14 = 0xee, kApp15 = 0xef, kComment = 0xfe, kScan = 0xda;
    Copier copier(file);
    copier.copy(2);
    while (copier.left() > 4 && copier.byte(0) == 0xff && copier.byte(1) != kScan) {
        const std::uint32_t marker = copier.byte(1);
        const bool is_bare = marker == 0xff || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
        const std::size_t size = marker == 0xff ? 1 : is_bare ? 2 : 2 + copier.big_endian(2, 2);
        const bool describes = (marker > kApp0 && marker <= kApp15 && marker != kApp14) || marker == kComment;
        if (describes) copier.skip(size);
        else copier.copy(size);
    }
    copier.copy(copier.left());
    return copier.take();
}

// Gives descriptive entries of the first directory a tag number that no reader knows (TIFF 6.0, sec. 2).
std::vector<std::byte> without_tiff_metadata(std::span<const std::byte> file)
{
    constexpr std::array<std::uint32_t, 6> kDescribing = {700, 33723, 34377, 34665, 34675, 37724};
    constexpr std::size_t kEntry = 12;
    std::vector<std::byte> out(file.begin(), file.end());
    const bool is_little = out.size() > 8 && out[0] == std::byte('I');
    const auto number = [&](std::size_t at, std::size_t count) {
        std::size_t value = 0;
        for (std::size_t i = 0; i < count; ++i)
            value = value << 8 | std::to_integer<std::size_t>(out[at + (is_little ? count - 1 - i : i)]);
        return value;
    };
    if (out.size() < 10) return out;
    const std::size_t directory = number(4, 4);
    if (directory > out.size() - 2) return out;
    const std::size_t entries = std::min(number(directory, 2), (out.size() - directory - 2) / kEntry);
    for (std::size_t e = 0; e < entries; ++e) {
        const std::size_t at = directory + 2 + e * kEntry;
        if (std::find(kDescribing.begin(), kDescribing.end(), number(at, 2)) != kDescribing.end())
            out[at] = out[at + 1] = std::byte{0xfd};
    }
    return out;
}

}  // namespace

std::vector<std::byte> without_metadata(std::span<const std::byte> file, std::string_view format)
{
    if (format == "png") return without_png_metadata(file);
    if (format == "jpeg") return without_jpeg_metadata(file);
    if (format == "tiff") return without_tiff_metadata(file);
    return {file.begin(), file.end()};
}

}  // namespace occam
