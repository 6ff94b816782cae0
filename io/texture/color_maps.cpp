#include "io/texture/color_maps.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace occam {

namespace {

constexpr std::size_t kColors = 256;  // as many numbers as a byte may hold

// Returns the byte at a place of a file as a number; 0 beyond the end.
std::size_t byte_at(std::span<const std::byte> file, std::size_t at) noexcept
{
    return at < file.size() ? std::to_integer<std::size_t>(file[at]) : 0;
}

// The parts of a TGA's header that describe pixels and colours (Truevision 1991, "TGA FILE HEADER").
struct TgaHead {
    static constexpr std::size_t kSize = 18, kFirst = 3, kLength = 5;

    explicit TgaHead(ImageBytes& file)
    {
        std::array<unsigned char, kSize> head{};
        if (!file.read(0, head)) return;
        colors_at = kSize + head[0];
        first = head[kFirst] | std::size_t(head[kFirst + 1]) << 8;
        length = head[kLength] | std::size_t(head[kLength + 1]) << 8;
        color_bits = head[7];
        pixel_bits = head[16];
        has_numbers = (head[2] == 1 || head[2] == 9) && head[1] == 1;
    }
    std::size_t color_bytes() const noexcept { return (color_bits + 7) / 8; }

    std::size_t colors_at = 0, first = 0, length = 0, color_bits = 0, pixel_bits = 0;
    bool has_numbers = false;
};

std::vector<std::byte> with_whole_tga_map(std::span<const std::byte> file)
{
    ImageBytes bytes_of_file(file);
    const TgaHead head(bytes_of_file);
    std::vector<std::byte> out(file.begin(), file.end());
    const std::size_t bytes = head.color_bytes(), given = head.length * bytes;
    if (!head.has_numbers || head.colors_at > file.size() || given > file.size() - head.colors_at) return out;
    // The footer leads to places of the file that move, and to nothing but descriptions.
    constexpr std::string_view kTgaMark("TRUEVISION-XFILE.\0", 18);
    constexpr std::size_t kFooter = 26;
    if (out.size() >= kFooter && std::memcmp(&out[out.size() - kTgaMark.size()], kTgaMark.data(), kTgaMark.size()) == 0)
        out.resize(out.size() - kFooter);
    if (head.colors_at + given > out.size()) return out;
    // The map holds the colours from `first` on; the library would add `first` to the numbers instead.
    std::vector<std::byte> map(kColors * bytes);
    for (std::size_t i = 0; i < head.length && head.first + i < kColors; ++i)
        std::copy_n(&out[head.colors_at + i * bytes], bytes, &map[(head.first + i) * bytes]);
    const auto begin = out.begin() + std::ptrdiff_t(head.colors_at);
    out.insert(out.erase(begin, begin + std::ptrdiff_t(given)), map.begin(), map.end());
    out[TgaHead::kFirst] = out[TgaHead::kFirst + 1] = std::byte{0};
    out[TgaHead::kLength] = std::byte{kColors & 0xff};
    out[TgaHead::kLength + 1] = std::byte{kColors >> 8};
    return out;
}

// Copies a GIF (CompuServe 1990, sec. 18 to 22) up to the colours of its first picture.
class GifCopier {
public:
    explicit GifCopier(std::span<const std::byte> file) : file_(file) {}

    std::vector<std::byte> copy()
    {
        constexpr std::size_t kScreen = 13, kPicture = 10;
        constexpr std::size_t kExtension = 0x21, kSeparator = 0x2c;
        pass(kScreen - 3);
        pass_map(2);
        while (byte_at(file_, at_) == kExtension) {
            pass(2);
            while (at_ < file_.size() && byte_at(file_, at_) != 0) pass(1 + byte_at(file_, at_));
            pass(1);
        }
        if (byte_at(file_, at_) == kSeparator) {
            pass(kPicture - 1);
            pass_map(0);
        }
        pass(file_.size());
        return std::move(out_);
    }

private:
    void pass(std::size_t bytes)
    {
        const auto part = file_.subspan(at_, std::min(bytes, file_.size() - at_));
        out_.insert(out_.end(), part.begin(), part.end());
        at_ += part.size();
    }
    /// Passes a byte that says whether a map follows and how large it is, `between` further bytes, and the map, made whole.
    void pass_map(std::size_t between)
    {
        constexpr std::size_t kHasMap = 0x80, kSize = 0x07, kLargest = 7;
        const std::size_t fields = byte_at(file_, at_), given = std::size_t(3) << ((fields & kSize) + 1);
        if (!(fields & kHasMap) || file_.size() - at_ < 1 + between + given) return pass(1 + between);
        out_.push_back(static_cast<std::byte>(fields | kLargest));
        ++at_;
        pass(between);
        pass(given);
        out_.insert(out_.end(), 3 * kColors - given, std::byte{0});
    }

    std::span<const std::byte> file_;
    std::vector<std::byte> out_;
    std::size_t at_ = 0;
};

}  // namespace

bool has_color_numbers(ImageBytes& bytes, std::string_view format)
{
    return format == "gif" || (format == "targa" && TgaHead(bytes).has_numbers);
}

bool has_foreign_color_map_tga(ImageBytes& bytes)
{
    const TgaHead head(bytes);
    if (!head.has_numbers) return false;
    return head.pixel_bits != 8 ||
           (head.color_bits != 15 && head.color_bits != 16 && head.color_bits != 24 && head.color_bits != 32);
}

std::vector<std::byte> with_whole_color_map(std::span<const std::byte> file, std::string_view format)
{
    if (format == "targa") return with_whole_tga_map(file);
    if (format == "gif") return GifCopier(file).copy();
    return {file.begin(), file.end()};
}

}  // namespace occam
