#include "io/texture/image_length.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <span>

#include "io/texture/pnm_samples.h"

namespace occam {
namespace {

// What a file says of its picture; 0 by 0 if it says nothing.
struct Declared {
    std::uintmax_t width = 0, height = 0, samples = 1, bits = 8;  // samples of a texel, and bits of a sample
};

// Reads whole numbers; bytes beyond the end of the file count as 0.
class Numbers {
public:
    Numbers(ImageBytes& file, bool is_little) : file_(file), is_little_(is_little) {}

    std::uintmax_t at(std::uintmax_t place, std::size_t count)
    {
        std::array<unsigned char, 8> bytes{};
        file_.read(place, std::span(bytes).first(count));
        std::uintmax_t value = 0;
        for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[is_little_ ? count - 1 - i : i];
        return value;
    }

private:
    ImageBytes& file_;
    const bool is_little_;
};

// Follows the segments of a JPEG to its first frame (ITU T.81, annex B).
Declared declared_by_jpeg(ImageBytes& file)
{
    constexpr std::uintmax_t kFill = 0xff, kBare = 0x01, kFirstBare = 0xd0, kLastBare = 0xd8, kEnd = 0xd9, kScan = 0xda,
                             kFirstFrame = 0xc0, kLastFrame = 0xcf, kTables[] = {0xc4, 0xc8, 0xcc};
    constexpr int kMostSegments = 1 << 16;
    Numbers numbers(file, false);
    std::uintmax_t at = 2;
    for (int i = 0; i < kMostSegments && at < file.size() && numbers.at(at, 1) == kFill; ++i) {
        const std::uintmax_t marker = numbers.at(at + 1, 1);
        if (marker == kEnd || marker == kScan) break;
        if (marker >= kFirstFrame && marker <= kLastFrame && std::ranges::find(kTables, marker) == std::end(kTables))
            return {numbers.at(at + 7, 2), numbers.at(at + 5, 2), numbers.at(at + 9, 1), numbers.at(at + 4, 1)};
        const bool is_bare = marker == kBare || (marker >= kFirstBare && marker <= kLastBare);
        at += marker == kFill ? 1 : is_bare ? 2 : 2 + numbers.at(at + 2, 2);
    }
    return {};
}

// Reads the first directory of a TIFF or a BigTIFF (TIFF 6.0, sec. 2 and 8).
Declared declared_by_tiff(ImageBytes& file)
{
    constexpr std::uintmax_t kWidth = 256, kHeight = 257, kBitsPerSample = 258, kSamplesPerPixel = 277, kBig = 43;
    constexpr std::uintmax_t kMostEntries = 1 << 16;
    Numbers numbers(file, Numbers(file, true).at(0, 1) == 'I');
    const bool is_big = numbers.at(2, 2) == kBig;
    const std::size_t word = is_big ? 8 : 4, size_of_count = is_big ? 8 : 2, entry = 4 + 2 * word;
    const std::uintmax_t begin = numbers.at(word, word);
    if (begin >= file.size()) return {};
    const std::uintmax_t count = std::min(numbers.at(begin, size_of_count), kMostEntries);
    Declared declared{.bits = 1};
    for (std::uintmax_t i = 0, at = begin + size_of_count; i < count && at < file.size(); ++i, at += entry) {
        const std::uintmax_t tag = numbers.at(at, 2);
        std::uintmax_t* const to = tag == kWidth             ? &declared.width
                                   : tag == kHeight          ? &declared.height
                                   : tag == kSamplesPerPixel ? &declared.samples
                                   : tag == kBitsPerSample   ? &declared.bits
                                                             : nullptr;
        if (!to) continue;
        constexpr std::size_t kSizes[] = {0, 1, 0, 2, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8};  // of whole numbers, by type
        const std::uintmax_t type = numbers.at(at + 2, 2);
        const std::size_t bytes = type < std::size(kSizes) ? kSizes[type] : 0;
        if (bytes == 0) continue;
        const bool is_elsewhere = numbers.at(at + 4, word) > word / bytes;
        *to = numbers.at(is_elsewhere ? numbers.at(at + 4 + word, word) : at + 4 + word, bytes);
    }
    return declared;
}

Declared declared_by_pnm(ImageBytes& file)
{
    const auto head = read_head_of_few_values(file);
    return head ? Declared{head->width, head->height, static_cast<std::uintmax_t>(head->channels)} : Declared{};
}

Declared declared_by(ImageBytes& file, std::string_view format)
{
    if (format == "jpeg") return declared_by_jpeg(file);
    if (format == "tiff") return declared_by_tiff(file);
    if (format == "pnm") return declared_by_pnm(file);
    Numbers numbers(file, true);
    if (format == "targa") return {numbers.at(12, 2), numbers.at(14, 2)};
    if (format == "dds") return {numbers.at(16, 4), numbers.at(12, 4)};
    const auto canvas = declared_canvas(file);
    if (!canvas) return {};
    constexpr std::uintmax_t kMostSamples = 4, kMostBits = 16;  // of a PNG
    if (format == "png") return {canvas->width, canvas->height, kMostSamples, kMostBits};
    if (format == "bmp") return {canvas->width, canvas->height, kMostSamples};
    return {canvas->width, canvas->height};
}

// Returns how many times as long as its samples are a picture may get by the coding of its format. Codes of a JPEG have up
// to 27 bits for a sample, and bytes that look like markers are doubled. Each character of a text is a byte: up to four for
// a sample. Other codings add less than half to samples that they cannot make shorter: LZW of GIF and TIFF writes 12 bits
// for eight, and the others a byte for 64 or more.
std::uintmax_t longest_coding(std::string_view format) { return format == "jpeg" ? 8 : format == "pnm" ? 4 : 2; }

}  // namespace

std::uintmax_t most_bytes_of_file(ImageBytes& file, std::string_view format, const ImageLimits& limits)
{
    constexpr std::uintmax_t kMostBits = 64;
    const Declared declared = declared_by(file, format);
    const std::uintmax_t width = std::min(declared.width, limits.side), height = std::min(declared.height, limits.side);
    const std::uintmax_t texels = std::min(width * height, limits.texels),
                         samples = std::clamp<std::uintmax_t>(declared.samples, 1, limits.values);
    const std::uintmax_t values = texels < limits.values / samples ? texels * samples : limits.values;
    const std::uintmax_t bits = std::clamp<std::uintmax_t>(declared.bits, 1, kMostBits);
    return (values * bits / 8 + height) * longest_coding(format) + kMostBytesBesidePicture;
}

}  // namespace occam
