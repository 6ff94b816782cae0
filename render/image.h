// A picture of named layers of floats, as it is rendered, compared and kept in files.
//
// Values are scene-linear Rec.709, colours multiplied by coverage. Rows run from the top.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace occam::render {

struct Layer {
    std::string name;                   ///< "beauty", "depth", ...
    std::vector<std::string> channels;  ///< "R", "G", "B", "A"; "Z"; ...
    bool full_float = false;            ///< the layer is written with 32 bits whatever the others have
    std::vector<float> pixels;          ///< channels interleaved, row-major from the top left: channels * width * height

    std::size_t channel_count() const noexcept { return channels.size(); }
};

/// Holds an attribute of the file's header. Matrices follow OpenEXR: 16 floats, points are rows, and the translation
/// comes last.
struct Attribute {
    std::string name;
    std::variant<std::string, float, int, std::array<float, 16>, std::array<float, 8>> value;
};

enum class Tonemap : unsigned char {
    None,   ///< clamped linear values
    Srgb,   ///< the sRGB curve
    Aces,   ///< a filmic curve close to that of ACES (Narkowicz 2015), then the sRGB curve
    Filmic  ///< a toe and a long shoulder that keep the hue, white three stops above 1 (see display.cpp), then the sRGB
            ///< curve
};

struct TonemapRow {
    Tonemap value;
    std::string_view name;
};
inline constexpr TonemapRow kTonemaps[] = {
    {Tonemap::None, "none"}, {Tonemap::Srgb, "srgb"}, {Tonemap::Aces, "aces"}, {Tonemap::Filmic, "filmic"}};

struct WriteOptions {
    bool half = true;  ///< EXR layers in 16 bits, except those of Layer::full_float
    /// The stops by which display formats (PNG, JPEG, TIFF) are brighter than the scene; if none are given,
    /// automatic_exposure() decides. EXR and HDR files keep the scene's own values.
    std::optional<float> exposure_ev{};
    Tonemap tonemap = Tonemap::Filmic;  ///< curve of display formats
    /// A text that is kept in the file's head. It is an Error if it has a zero byte or is longer than the format keeps: HDR
    /// 32 lines of 64 bytes, JPEG 65,000 bytes, TIFF 65,536, EXR and PNG 64,000,000.
    std::string note{};
    /// The time for which the shutter was open. EXR files keep it (expTime).
    std::optional<float> exposure_seconds{};
};

/// Holds what the file of a picture says before its pixels.
struct PictureHead {
    int width = 0, height = 0;
    std::string note;  ///< WriteOptions::note; empty if there is none
};

class Image {
public:
    Image() = default;
    Image(int columns, int rows) : width(columns), height(rows), full_width(columns), full_height(rows) {}

    int width = 0, height = 0;
    int x0 = 0, y0 = 0;                   ///< where the pixels lie in the whole frame
    int full_width = 0, full_height = 0;  ///< the whole frame
    std::vector<Attribute> attributes;
    /// False for a debug view or a heat map of differences, whose values are shown as they are.
    bool is_light = true;

    /// Returns the layers in the order in which they were added; beauty is the first.
    const std::vector<Layer>& layers() const noexcept { return layers_; }
    const Layer* find(std::string_view name) const noexcept;  ///< null if there is none
    /// Adds a black layer (zeros). Invalidates references to layers. Throws Error if a side of the image is below 0, or the
    /// layer would have more values than can be counted.
    Layer& add_layer(std::string name, std::vector<std::string> channels, bool full_float = false);
    Layer& layer(std::size_t index) { return layers_[index]; }

    /// Returns the FNV-1a 64 hash of the beauty layer's R, G and B as little-endian float32, row by row from the top; grey
    /// is three times its value, and a picture without colours is the hash of nothing. Throws Error if the layer does not
    /// hold a value of each channel for each pixel.
    std::uint64_t checksum() const;

    /// Writes the picture. The format follows the extension: .exr .png .jpg .jpeg .tif .tiff .hdr; all but EXR keep
    /// beauty alone: its R, G and B, or its grey (Y, or a single channel beside A) as all three. No channel but A is alpha.
    /// The file is written beside its final name and then renamed, so that no reader ever sees half a file. Throws Error: of
    /// Kind::BadInput if check_writable() refuses the extension, else of Kind::Output.
    void write(const std::filesystem::path& file, const WriteOptions& options = {}) const;
    /// Throws Error if write() would refuse that name: its extension, its folder, or what exists there already.
    static void check_writable(const std::filesystem::path& file);

    /// has_layers() returns true if files of that extension hold layers beside beauty (EXR), and is_for_display() returns
    /// true if they hold colours as a screen shows them.
    static bool has_layers(const std::filesystem::path& file);
    static bool is_for_display(const std::filesystem::path& file);

    /// Reads the head, and as much as shows that the end of the picture is there. Throws Error if it is not.
    static PictureHead read_head(const std::filesystem::path& file);
    /// Reads the layers of a picture of any format that textures may have, and where they lie in the frame. Colours are made
    /// linear, and multiplied by alpha, as docs/files.md says. What else the head says is not read: there are no attributes,
    /// and is_light is true. Throws Error.
    static Image read(const std::filesystem::path& file);

private:
    std::vector<Layer> layers_;
};

}  // namespace occam::render
