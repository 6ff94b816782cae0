// Reads what an image file declares in its first bytes. This is done before any library runs, since a library may allocate
// as much as is declared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>

namespace occam {

/// Holds the bytes of an image file, in memory (borrowed) or on disk.
class ImageBytes {
public:
    explicit ImageBytes(std::span<const std::byte> bytes) : bytes_(bytes), size_(bytes.size()) {}
    explicit ImageBytes(const std::filesystem::path& file);

    std::uintmax_t size() const noexcept { return size_; }
    /// Fills `to`; returns false if the file does not reach that far.
    bool read(std::uintmax_t at, std::span<unsigned char> to);

private:
    std::span<const std::byte> bytes_;
    std::ifstream stream_;
    std::uintmax_t size_ = 0, next_ = 0;  // the stream is at `next_`; seeking drops the bytes that it has read ahead
};

/// Returns an integer of `count` bytes, at most four, the lowest first; bytes beyond the end count as 0.
std::uint32_t little_endian(ImageBytes& bytes, std::uintmax_t at, std::size_t count);

/// Returns the name of the codec's reader according to the first bytes of the file; empty if images of its format are not
/// read. A TGA has no mark: its header has to make sense.
std::string image_format(ImageBytes& bytes);

/// Names the formats that image_format() knows, for messages.
inline constexpr const char* kImageFormats = "PNG, JPEG, OpenEXR, Radiance HDR, TIFF, WebP, BMP, TGA, DDS, GIF, PNM or PFM";

/// Returns true if a chunk of a PNG reaches past the end of the file, or if the last chunk is missing (PNG, sec. 5.3). At
/// the missing byte libpng would jump out of OpenImageIO's reader, past its destructors. Returns false for other formats.
bool is_cut_off_png(ImageBytes& bytes);

/// Returns true if an attribute of the headers of an OpenEXR file reaches past the end of the file. The library allocates as
/// much as an attribute declares. Returns false for other formats.
bool is_cut_off_exr(ImageBytes& bytes);

/// Returns true if a BMP is compressed in another way than by run lengths of its own bits a pixel. OpenImageIO looks colours
/// up in a table even if the file has none, and takes other compressed bytes for pixels. Returns false for other formats.
bool has_foreign_compression_bmp(ImageBytes& bytes);

/// Returns true if a DDS is a cube map or a volume, or has pixels of a kind that its format does not have. OpenImageIO does
/// not come to an end with some of them. Returns false for other formats.
bool has_foreign_pixels_dds(ImageBytes& bytes);

/// Returns true if a TGA says that its colours are multiplied by its alpha. Returns false for other formats; so that they do
/// not look like a TGA, the caller has found the format by image_format().
bool has_multiplied_colors_tga(ImageBytes& bytes);

/// Returns true if a TGA says that the bits beside its colours are no alpha. The caller has found the format, as above.
bool has_no_alpha_tga(ImageBytes& bytes);

/// Returns true if the two channels of a DDS are red and green (BC5, also called ATI2), as of normal maps, and not grey and
/// alpha. Returns false for other formats.
bool has_two_colors_dds(ImageBytes& bytes);

/// Returns the place of the byte of a DDS that tells blocks whose colours are multiplied by alpha (DXT2, DXT4) from the same
/// ones whose colours are not, which is the next number; none if it holds no such blocks, or is of another format.
std::optional<std::size_t> place_of_multiplied_dds(ImageBytes& bytes);

struct ImageSize {
    std::uint32_t width, height;
};
/// Returns the size that a PNG, GIF, WebP or BMP declares, whose readers allocate for it when they open a file. Returns none
/// for other formats, or if the header is cut off.
std::optional<ImageSize> declared_canvas(ImageBytes& bytes);

}  // namespace occam
