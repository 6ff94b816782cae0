// What an image file says of itself in its first bytes: read before any library, which may allocate what is declared there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>

namespace occam {

/// Bytes of an image file, in memory (borrowed) or on disk.
class ImageBytes {
public:
    explicit ImageBytes(std::span<const std::byte> bytes) : bytes_(bytes), size_(bytes.size()) {}
    explicit ImageBytes(const std::filesystem::path& file);

    std::uintmax_t size() const noexcept { return size_; }
    /// Fills `to`; false if the file does not reach that far.
    bool read(std::uintmax_t at, std::span<unsigned char> to);

private:
    std::span<const std::byte> bytes_;
    std::ifstream stream_;
    std::uintmax_t size_ = 0;
};

/// The name of OpenImageIO's reader, by what the file begins with; empty: unknown.
std::string image_format(ImageBytes& bytes);

/// Does a chunk of a PNG reach past the end of the file, or the last one lack? (PNG, sec. 5.3.) libpng would jump out of
/// OpenImageIO's reader at the missing byte, past its destructors. False for other formats.
bool is_cut_off_png(ImageBytes& bytes);

struct ImageSize {
    std::uint32_t width, height;
};
/// The canvas of a GIF or WebP, whose readers allocate all of it when they open a file. None for other formats, or if the
/// header is cut off.
std::optional<ImageSize> declared_canvas(ImageBytes& bytes);

}  // namespace occam
