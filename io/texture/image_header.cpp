#include "io/texture/image_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

namespace occam {

std::uint32_t little_endian(ImageBytes& bytes, std::uintmax_t at, std::size_t count)
{
    std::array<unsigned char, 4> word{};
    bytes.read(at, std::span(word).first(count));
    return word[0] | std::uint32_t(word[1]) << 8 | std::uint32_t(word[2]) << 16 | std::uint32_t(word[3]) << 24;
}

namespace {

bool matches(ImageBytes& bytes, std::string_view magic, std::uintmax_t at = 0)
{
    std::array<unsigned char, 16> found{};
    const auto first = std::span(found).first(magic.size());
    return bytes.read(at, first) && std::memcmp(first.data(), magic.data(), magic.size()) == 0;
}

constexpr std::uint32_t kOldestBmpHeader = 12;  // its size; it knows no compression

// Moves `at` behind a name that ends with a null, and returns its length, or nothing if it is not whole.
std::optional<std::size_t> skip_name(ImageBytes& bytes, std::uintmax_t& at)
{
    constexpr std::size_t kLongestName = 255;
    for (std::size_t length = 0; length <= kLongestName; ++length) {
        unsigned char letter = 0;
        if (!bytes.read(at++, {&letter, 1})) return std::nullopt;
        if (letter == 0) return length;
    }
    return std::nullopt;
}

// Checks the header of a TGA (Truevision 1991, "TGA FILE HEADER"): kinds of colour map and image, and bits of a pixel.
bool is_tga(ImageBytes& bytes)
{
    constexpr std::array<unsigned char, 6> kImages = {1, 2, 3, 9, 10, 11};
    constexpr std::array<unsigned char, 5> kBits = {8, 15, 16, 24, 32};
    std::array<unsigned char, 18> head{};
    const auto has = [](const auto& list, unsigned char value) { return std::ranges::find(list, value) != list.end(); };
    return bytes.read(0, head) && head[1] <= 1 && has(kImages, head[2]) && has(kBits, head[16]);
}

constexpr std::string_view kPngMagic("\x89PNG\r\n\x1a\n", 8);
constexpr std::string_view kExrMagic("\x76\x2f\x31\x01");

// Returns whether an attribute of an OpenEXR header is as long as its type says (OpenEXR, "Predefined Attribute Types"). The
// library reads such types without a look at the length, and would take the next attribute from another place than we do.
bool has_length_of_type(ImageBytes& bytes, std::uintmax_t type_at, std::uintmax_t type_length, std::uintmax_t at,
                        std::uint32_t length)
{
    struct Fixed {
        std::string_view type;
        std::uint32_t length;
    };
    constexpr Fixed kFixed[] = {{"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
                                {"compression", 1}, {"double", 8},   {"envmap", 1},
                                {"float", 4},       {"int", 4},      {"keycode", 28},
                                {"lineOrder", 1},   {"m33f", 36},    {"m44f", 64},
                                {"m33d", 72},       {"m44d", 128},   {"rational", 8},
                                {"tiledesc", 9},    {"v2i", 8},      {"v2f", 8},
                                {"v2d", 16},        {"v3i", 12},     {"v3f", 12},
                                {"v3d", 24},        {"timecode", 8}, {"deepImageState", 1}};
    std::array<unsigned char, 16> letters{};
    if (type_length > letters.size()) return true;
    if (!bytes.read(type_at, std::span(letters).first(static_cast<std::size_t>(type_length)))) return false;
    const std::string_view type(reinterpret_cast<const char*>(letters.data()), static_cast<std::size_t>(type_length));
    for (const Fixed& fixed : kFixed)
        if (type == fixed.type) return length == fixed.length;
    if (type != "chlist") return true;
    // A name and 16 bytes for each channel, up to an empty name.
    constexpr std::uintmax_t kChannelBytes = 16;
    for (std::uintmax_t next = at;;) {
        const auto name = skip_name(bytes, next);
        if (!name || next > at + length) return false;
        if (*name == 0) return next == at + length;
        next += kChannelBytes;
    }
}

}  // namespace

ImageBytes::ImageBytes(const std::filesystem::path& file) : stream_(file, std::ios::binary)
{
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (!error) size_ = size;
}

bool ImageBytes::read(std::uintmax_t at, std::span<unsigned char> to)
{
    if (at > size_ || to.size() > size_ - at) return false;
    if (!stream_.is_open()) {
        if (bytes_.size() != size_) return false;
        if (!to.empty()) std::memcpy(to.data(), bytes_.data() + at, to.size());  // neither pointer may be null, even then
        return true;
    }
    if (at != next_) stream_.seekg(static_cast<std::streamoff>(at));
    next_ = at + to.size();
    return static_cast<bool>(stream_.read(reinterpret_cast<char*>(to.data()), static_cast<std::streamsize>(to.size())));
}

std::string image_format(ImageBytes& bytes)
{
    if (matches(bytes, kPngMagic)) return "png";
    if (matches(bytes, "\xff\xd8\xff")) return "jpeg";
    if (matches(bytes, kExrMagic)) return "openexr";
    if (matches(bytes, "RIFF") && matches(bytes, "WEBP", 8)) return "webp";
    if (matches(bytes, std::string_view("II*\0", 4)) || matches(bytes, std::string_view("MM\0*", 4))) return "tiff";
    if (matches(bytes, std::string_view("II+\0", 4)) || matches(bytes, std::string_view("MM\0+", 4))) return "tiff";
    if (matches(bytes, "#?RADIANCE") || matches(bytes, "#?RGBE")) return "hdr";
    if (matches(bytes, "GIF8")) return "gif";
    if (matches(bytes, "BM")) return "bmp";
    if (matches(bytes, "DDS ")) return "dds";
    for (const char* mark : {"P1", "P2", "P3", "P4", "P5", "P6", "PF", "Pf"})
        if (matches(bytes, mark)) return "pnm";
    return is_tga(bytes) ? "targa" : "";
}

bool is_cut_off_png(ImageBytes& bytes)
{
    if (!matches(bytes, kPngMagic)) return false;
    std::array<unsigned char, 8> word{};
    for (std::uintmax_t at = kPngMagic.size(); bytes.read(at, word);) {
        std::uintmax_t length = 0;
        for (int i = 0; i < 4; ++i) length = length << 8 | word[static_cast<std::size_t>(i)];
        constexpr std::uintmax_t kAround = 12;  // the bytes of length, name and checksum
        if (bytes.size() - at < kAround || length > bytes.size() - at - kAround) return true;
        if (std::memcmp(&word[4], "IEND", 4) == 0) return false;
        at += length + kAround;
    }
    return true;
}

bool is_cut_off_exr(ImageBytes& bytes)
{
    if (!matches(bytes, kExrMagic)) return false;
    // The headers of several parts end with an empty one (OpenEXR, "File Layout").
    constexpr std::uint32_t kHasParts = 0x1000;
    const bool has_parts = (little_endian(bytes, 4, 4) & kHasParts) != 0;
    bool is_empty = true;
    for (std::uintmax_t at = 8;;) {
        const auto name = skip_name(bytes, at);
        if (!name) return true;
        if (*name == 0 && (is_empty || !has_parts)) return false;
        is_empty = *name == 0;
        if (is_empty) continue;
        const std::uintmax_t type_at = at;
        std::array<unsigned char, 4> word{};
        const auto type = skip_name(bytes, at);
        if (!type || !bytes.read(at, word)) return true;
        const std::uint32_t length = little_endian(bytes, at, word.size());
        at += word.size();
        if (length > bytes.size() - at || !has_length_of_type(bytes, type_at, *type, at, length)) return true;
        at += length;
    }
}

bool has_foreign_compression_bmp(ImageBytes& bytes)
{
    if (!matches(bytes, "BM") || little_endian(bytes, 14, 4) == kOldestBmpHeader) return false;
    enum Compression { None = 0, Runs8 = 1, Runs4 = 2, Masks = 3, MasksWithAlpha = 6 };
    const std::uint32_t bits = little_endian(bytes, 28, 2), compression = little_endian(bytes, 30, 4);
    if (compression == Runs8) return bits != 8;
    if (compression == Runs4) return bits != 4;
    return compression != None && compression != Masks && compression != MasksWithAlpha;
}

bool has_foreign_pixels_dds(ImageBytes& bytes)
{
    if (!matches(bytes, "DDS ")) return false;
    // Microsoft, "DDS_HEADER" and "DDS_PIXELFORMAT".
    constexpr std::uint32_t kHasAlpha = 0x1, kAlphaOnly = 0x2, kFourCharacters = 0x4, kRgb = 0x40, kLuminance = 0x20000;
    constexpr std::uint32_t kCubeMapOrVolume = 0x200 | 0x200000;
    const std::uint32_t flags = little_endian(bytes, 80, 4), bits = little_endian(bytes, 88, 4);
    if (little_endian(bytes, 112, 4) & kCubeMapOrVolume) return true;
    if (flags & kFourCharacters) return false;
    if (!(flags & (kAlphaOnly | kRgb | kLuminance))) return true;
    // Red, green, blue and alpha have a mask each, whose lowest bit the library looks for.
    constexpr std::array<std::uint32_t, 4> kWhoHasIt = {kRgb | kLuminance, kRgb, kRgb, kHasAlpha | kAlphaOnly};
    for (std::size_t k = 0; k < kWhoHasIt.size(); ++k)
        if ((flags & kWhoHasIt[k]) && little_endian(bytes, 92 + 4 * k, 4) == 0) return true;
    return bits != 8 && bits != 16 && bits != 24 && bits != 32;
}

namespace {

// Returns what the extension area of a TGA says of its alpha, or nothing if there is none.
std::optional<std::uint32_t> kind_of_alpha_tga(ImageBytes& bytes)
{
    // The last bytes say where the extension area lies, which says how long it is and what the alpha is (Truevision 1991,
    // "TGA FILE FOOTER" and "EXTENSION AREA").
    constexpr std::string_view kMark = "TRUEVISION-XFILE";
    constexpr std::uint32_t kFooter = 26, kTypeOfAlpha = 494;
    const std::uintmax_t size = bytes.size();
    if (size < kFooter || !matches(bytes, kMark, size - 18)) return std::nullopt;
    const std::uintmax_t area = little_endian(bytes, size - kFooter, 4);
    if (area == 0 || little_endian(bytes, area, 2) <= kTypeOfAlpha) return std::nullopt;
    return little_endian(bytes, area + kTypeOfAlpha, 1);
}

}  // namespace

bool has_multiplied_colors_tga(ImageBytes& bytes)
{
    constexpr std::uint32_t kMultiplied = 4;
    return kind_of_alpha_tga(bytes) == kMultiplied;
}

bool has_no_alpha_tga(ImageBytes& bytes)
{
    constexpr std::uint32_t kDescriptor = 17, kBitsOfAlpha = 0x0f, kNone = 0, kToBeIgnored = 1;
    if ((little_endian(bytes, kDescriptor, 1) & kBitsOfAlpha) == 0) return true;
    const auto kind = kind_of_alpha_tga(bytes);
    return kind == kNone || kind == kToBeIgnored;
}

bool has_two_colors_dds(ImageBytes& bytes)
{
    constexpr std::uint32_t kFourCharacters = 0x4, kBc5 = 83;
    constexpr std::uintmax_t kName = 84, kFormat = 128;
    if (!matches(bytes, "DDS ") || !(little_endian(bytes, 80, 4) & kFourCharacters)) return false;
    if (matches(bytes, "ATI2", kName) || matches(bytes, "BC5U", kName)) return true;
    return matches(bytes, "DX10", kName) && little_endian(bytes, kFormat, 4) == kBc5;
}

std::optional<std::size_t> place_of_multiplied_dds(ImageBytes& bytes)
{
    constexpr std::uint32_t kFourCharacters = 0x4;
    constexpr std::size_t kName = 84;
    if (!matches(bytes, "DDS ") || !(little_endian(bytes, 80, 4) & kFourCharacters)) return std::nullopt;
    if (!matches(bytes, "DXT2", kName) && !matches(bytes, "DXT4", kName)) return std::nullopt;
    return kName + 3;
}

std::optional<ImageSize> declared_canvas(ImageBytes& bytes)
{
    if (matches(bytes, kPngMagic)) {
        std::array<unsigned char, 8> sides{};
        if (!bytes.read(16, sides)) return std::nullopt;
        const auto side = [&](std::size_t at) {
            return std::uint32_t(sides[at]) << 24 | std::uint32_t(sides[at + 1]) << 16 | std::uint32_t(sides[at + 2]) << 8 |
                   sides[at + 3];
        };
        return ImageSize{side(0), side(4)};
    }
    if (matches(bytes, "BM")) {
        // The oldest header has sizes of 16 bits, and a height below 0 counts from the top.
        if (little_endian(bytes, 14, 4) == kOldestBmpHeader)
            return ImageSize{little_endian(bytes, 18, 2), little_endian(bytes, 20, 2)};
        const std::uint32_t height = little_endian(bytes, 22, 4);
        return ImageSize{little_endian(bytes, 18, 4), std::min(height, 0u - height)};
    }
    if (matches(bytes, "GIF8")) return ImageSize{little_endian(bytes, 6, 2), little_endian(bytes, 8, 2)};
    if (!matches(bytes, "RIFF") || !matches(bytes, "WEBP", 8)) return std::nullopt;
    // This reads the WebP container: an extended header, or one of two bit streams (RFC 9649, sec. 2.5 to 2.7).
    if (matches(bytes, "VP8X", 12)) return ImageSize{little_endian(bytes, 24, 3) + 1, little_endian(bytes, 27, 3) + 1};
    if (matches(bytes, "VP8L", 12)) {
        const std::uint32_t bits = little_endian(bytes, 21, 4);
        return ImageSize{(bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1};
    }
    if (matches(bytes, "VP8 ", 12))
        return ImageSize{little_endian(bytes, 26, 2) & 0x3fff, little_endian(bytes, 28, 2) & 0x3fff};
    return std::nullopt;
}

}  // namespace occam
