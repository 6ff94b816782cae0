// Reads and writes image files, through the codec of io/picture_codec.h; OpenEXR and PNG files are written through their own
// libraries.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <system_error>

#include "base/error.h"
#include "base/error_without_file.h"
#include "io/encoded_bytes.h"
#include "io/exr_file.h"
#include "io/extensions.h"
#include "io/hdr_note.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "io/picture_codec.h"
#include "io/png_file.h"
#include "io/texture/multiplied_color.h"
#include "io/texture/open_image.h"
#include "render/display.h"
#include "render/file_colors.h"
#include "render/layers.h"
#include "render/picture_formats.h"

namespace occam::render {
namespace {

namespace fs = std::filesystem;

constexpr float kHalfMax = 65504.0f;
constexpr float kRadianceMax = 0x1.fep126f;  ///< the exponent of a larger value would not fit into a byte
[[noreturn]] void refuse(const fs::path& file, const std::string& why)
{
    throw Error(file.string(), why, {}, Error::Kind::Output);
}

void add(std::vector<PictureAttribute>& attributes, std::string name, PictureAttribute::Value value)
{
    attributes.push_back({std::move(name), std::move(value)});
}

// Returns the spec of a picture with channels of one type: none, or the first three or four of red, green, blue and alpha.
PictureSpec base_spec(const Image& image, std::size_t channels, SampleType type)
{
    static constexpr const char* kNames[] = {"R", "G", "B", "A"};
    PictureSpec spec;
    spec.width = spec.full_width = image.width;
    spec.height = spec.full_height = image.height;
    spec.channels.assign(kNames, kNames + channels);
    if (channels == 4) spec.alpha_channel = 3;
    spec.type = type;
    return spec;
}

void check_size(const fs::path& file, const PictureSpec& spec, int width, int height, int channels)
{
    if (width != spec.width || height != spec.height || channels != spec.channel_count())
        refuse(file, "cannot be written: its head reads back as another picture's");
}

// Checks the header: encoders that write a wrong one, or none, are not trusted with the final name.
void check_header(const PictureCodec& codec, const OutputFile& out, const fs::path& file, const PictureSpec& spec)
{
    std::string why;
    const auto in = codec.open(out.temporary(), why);
    if (!in) refuse(file, "cannot be written: its head cannot be read back: " + why);
    const PictureSpec& found = in->spec();
    check_size(file, spec, found.width, found.height, found.channel_count());
}

// Does for OpenEXR what write_pixels() does for formats of the codec.
void write_exr_pixels(const fs::path& file, const PictureSpec& spec, std::span<const PictureAttribute> attributes,
                      const std::vector<float>& pixels)
{
    OutputFile target(file);
    EncodedBytes bytes(target);
    const std::string why = occam::write_exr(spec, attributes, pixels.data(), bytes);
    if (!why.empty()) refuse(file, "cannot be written: " + why);
    target.finish();
    ImageBytes written(target.temporary());
    const std::optional<ExrHead> found = read_exr_head(written);
    if (!found) refuse(file, "cannot be written: its head cannot be read back");
    check_size(file, spec, found->width, found->height, found->channel_count);
    target.publish();
}

// comments   what a Radiance file says in its head, as it has no attributes
void write_pixels(const fs::path& file, const PictureSpec& spec, std::span<const PictureAttribute> attributes,
                  const std::vector<float>& pixels, const std::string& comments = {})
{
    const PictureCodec& codec = picture_codec();  // loading it may take a second, in which there is no file yet
    OutputFile target(file);
    EncodedBytes bytes(target);
    HdrNoteBytes with_note(bytes, comments);
    PictureBytes& to = comments.empty() ? static_cast<PictureBytes&>(bytes) : with_note;
    const std::string why = codec.write(target.temporary(), spec, attributes, pixels.data(), to);
    if (!why.empty()) refuse(file, "cannot be written: " + why);
    target.finish();
    check_header(codec, target, file, spec);
    target.publish();
}

void write_exr(const Image& image, const fs::path& file, const WriteOptions& options)
{
    if (const std::string why = why_not_written(image.layers()); !why.empty()) refuse(file, "cannot be written: " + why);
    std::size_t channels = 0;
    for (const Layer& layer : image.layers()) channels += layer.channel_count();
    if (channels == 0) refuse(file, "there is no layer to write");
    PictureSpec spec = base_spec(image, 0, SampleType::Float);
    spec.x = image.x0;
    spec.y = image.y0;
    spec.full_width = image.full_width;
    spec.full_height = image.full_height;
    std::vector<PictureAttribute> attributes;
    if (!options.note.empty()) add(attributes, kExrNote, options.note);
    if (options.exposure_seconds) add(attributes, "expTime", *options.exposure_seconds);
    for (const Attribute& a : image.attributes) add(attributes, a.name, a.value);

    const std::size_t count = std::size_t(image.width) * std::size_t(image.height);
    std::vector<float> pixels(count * channels);
    std::size_t first = 0;
    for (const Layer& layer : image.layers()) {
        const bool half = options.half && !layer.full_float;
        const std::size_t n = layer.channel_count();
        for (const std::string& channel : layer.channels) {
            spec.channels.push_back(channel_in_file(layer, channel));
            spec.channel_types.push_back(half ? SampleType::Half : SampleType::Float);
        }
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t c = 0; c < n; ++c) {
                const float v = layer.pixels[i * n + c];
                // A bright light must not become infinite in half; infinity stays what it is.
                pixels[i * channels + first + c] = half && std::isfinite(v) ? std::clamp(v, -kHalfMax, kHalfMax) : v;
            }
        first += n;
    }
    write_exr_pixels(file, spec, attributes, pixels);
}

void write_hdr(const Image& image, const fs::path& file, const WriteOptions& options)
{
    const Layer& beauty = *image.find("beauty");
    const ColorChannels colors = color_channels(beauty).value();
    const std::size_t n = beauty.channel_count();
    std::vector<float> pixels;
    for (std::size_t i = 0; i < beauty.pixels.size(); i += n)
        for (const std::size_t c : colors.rgb)
            pixels.push_back(std::min(std::max(0.0f, beauty.pixels[i + c]), kRadianceMax));
    write_pixels(file, base_spec(image, 3, SampleType::Float), {}, pixels, options.note);
}

// Says what a file of a display format holds.
struct DisplayFile {
    SampleType type = SampleType::Byte;
    bool has_alpha = true;
    bool names_color_space = true;
    const char* compression = "";
};

void write_with_codec(const Image& image, const fs::path& file, const WriteOptions& options, const DisplayFile& of_format)
{
    DisplayImage shown = display_image(image, options, of_format.type == SampleType::Word ? 65535 : 255);
    if (!of_format.has_alpha && shown.channels == 4) {  // the picture is laid over black
        std::vector<float> opaque;
        for (std::size_t i = 0; i < shown.pixels.size(); i += 4)
            for (std::size_t c = 0; c < 3; ++c) opaque.push_back(shown.pixels[i + c] * shown.pixels[i + 3]);
        shown = {3, std::move(opaque)};
    }
    std::vector<PictureAttribute> attributes;
    add(attributes, "oiio:UnassociatedAlpha", 1);
    if (options.tonemap == Tonemap::None || of_format.names_color_space)
        add(attributes, "oiio:ColorSpace", std::string(options.tonemap == Tonemap::None ? "Linear" : "sRGB"));
    if (*of_format.compression) add(attributes, "compression", std::string(of_format.compression));
    if (!options.note.empty()) add(attributes, kNote, options.note);
    const PictureSpec spec = base_spec(image, static_cast<std::size_t>(shown.channels), of_format.type);
    write_pixels(file, spec, attributes, shown.pixels);
}

void write_png(const Image& image, const fs::path& file, const WriteOptions& options)
{
    const DisplayImage shown = display_image(image, options);
    const PngPicture picture{image.width, image.height, shown.channels, options.tonemap != Tonemap::None, options.note};
    OutputFile target(file);
    EncodedBytes bytes(target);
    const std::string why = occam::write_png(picture, shown.pixels.data(), bytes);
    if (!why.empty()) refuse(file, "cannot be written: " + why);
    target.finish();
    ImageBytes written(target.temporary());
    const std::optional<PngPicture> found = read_png_head(written);
    if (!found) refuse(file, "cannot be written: its head cannot be read back");
    check_size(file, base_spec(image, static_cast<std::size_t>(shown.channels), SampleType::Byte), found->width,
               found->height, found->channels);
    target.publish();
}
void write_jpeg(const Image& image, const fs::path& file, const WriteOptions& options)
{
    write_with_codec(image, file, options, {.has_alpha = false, .compression = "jpeg:95"});
}
// For sRGB, OpenImageIO adds a second directory to a TIFF, which needs to read from the stream and is written broken. A TIFF
// of integers is taken for sRGB anyway.
void write_tiff(const Image& image, const fs::path& file, const WriteOptions& options)
{
    write_with_codec(image, file, options, {.type = SampleType::Word, .names_color_space = false});
}

using namespace std::string_view_literals;

constexpr PictureFormat kFormats[] = {
    {.extensions = ".exr",
     .name = "OpenEXR",
     .contents = "all layers (`--aov`), scene-linear, 16 or 32 bits a channel (`--exr`), standard attributes",
     .holds_layers = true,
     .needs_codec = false,
     .write = write_exr},
    {.extensions = ".hdr",
     .name = "Radiance HDR",
     .contents = "the picture, scene-linear",
     .longest_note = kMostHdrNoteLines * kHdrNoteLine,
     .note_line = kHdrNoteLine,
     .write = write_hdr},
    {.extensions = ".png",
     .name = "PNG",
     .contents = "the picture as a screen shows it, 8 bits, with alpha where it is transparent",
     .is_for_display = true,
     .needs_codec = false,
     .largest_side = 1'000'000,
     .write = write_png},
    {.extensions = ".jpg .jpeg",
     .name = "JPEG",
     .contents = "the same picture over black",
     .is_for_display = true,
     .codec_name = "jpeg",
     .end_mark = "\xff\xd9"sv,
     .largest_side = 65500,
     .longest_note = 65'000,  // a segment of a JPEG holds 65,533 bytes, of which other metadata take some 100
     .write = write_jpeg},
    {.extensions = ".tif .tiff",
     .name = "TIFF",
     .contents = "the same picture as PNG, with 16 bits",
     .is_for_display = true,
     .longest_note = 65'536,  // OpenImageIO reads no more
     .write = write_tiff},
};

// Splits "normal_geometric.X" into layer and channel; a channel without a prefix is beauty's.
std::pair<std::string, std::string> split_channel(const std::string& name)
{
    const std::size_t dot = name.rfind('.');
    if (dot == std::string::npos) return {"beauty", name};
    return {name.substr(0, dot), name.substr(dot + 1)};
}

// Makes the colours of a layer linear and multiplies them by its alpha, as far as the file has them otherwise.
// power           of the encoding; 1: the values are linear, 0: they are sRGB
// is_multiplied   whether the values are multiplied by alpha already
void decode_colors(Layer& layer, float power, bool is_multiplied)
{
    if (is_multiplied && power == 1) return;
    const std::size_t n = layer.channel_count();
    const auto found = std::find(layer.channels.begin(), layer.channels.end(), "A");
    const auto alpha = static_cast<std::size_t>(found - layer.channels.begin());  // n if there is none
    for (std::size_t i = 0; i < layer.pixels.size(); i += n)
        for (std::size_t c = 0; c < n; ++c) {
            float& value = layer.pixels[i + c];
            if (c == alpha) continue;
            if (is_multiplied && alpha < n) value = color_without_alpha(value, layer.pixels[i + alpha], true);
            else if (power != 1) value = power == 0 ? linear_from_srgb(value) : std::pow(value, power);
            if (alpha < n) value *= layer.pixels[i + alpha];
        }
}

// Adds the layers of the picture in a file, without their values.
void add_layers(const PictureSpec& spec, Image& image)
{
    for (std::size_t first = 0, end = 0; first < spec.channels.size(); first = end) {
        const std::string name = split_channel(spec.channels[first]).first;
        std::vector<std::string> names;
        for (; end < spec.channels.size() && split_channel(spec.channels[end]).first == name; ++end)
            names.push_back(split_channel(spec.channels[end]).second);
        image.add_layer(name, std::move(names), spec.channel_type(first) == SampleType::Float);
    }
}

// Reads the values of all layers, in the order of the file. One layer is read into its place. The values of several are
// taken apart some rows at a time, since all of them would take as much memory as the picture.
bool read_values(PictureReader& in, Image& image)
{
    const PictureSpec& spec = in.spec();
    if (image.layers().size() == 1) return in.read_rows(0, spec.height, spec.channel_count(), image.layer(0).pixels.data());
    constexpr int kLeastRows = 256;  // no OpenEXR file without tiles has more rows that are compressed together
    const int tile = std::max(spec.tile_height, 1), at_once = (kLeastRows + tile - 1) / tile * tile;
    const std::size_t width = std::size_t(spec.width), channels = spec.channels.size();
    std::vector<float> values(width * std::size_t(std::min(at_once, spec.height)) * channels);
    for (int y = 0, end = 0; y < spec.height; y = end) {
        end = std::min(y + at_once, spec.height);
        if (!in.read_rows(y, end, spec.channel_count(), values.data())) return false;
        const float* from = values.data();
        for (std::size_t l = 0; l < image.layers().size(); ++l) {
            const std::size_t n = image.layer(l).channel_count();
            float* const to = &image.layer(l).pixels[std::size_t(y) * width * n];
            for (std::size_t i = 0; i < std::size_t(end - y) * width; ++i) std::copy_n(from + i * channels, n, to + i * n);
            from += n;
        }
    }
    return true;
}

// Returns the pixels of a layer in a file, in the order in which the picture has them.
std::vector<float> put_in_order(std::vector<float> pixels, const PictureSpec& spec, Orientation orientation)
{
    if (!orientation.mirrors_rows && !orientation.mirrors_columns && !orientation.swaps_axes) return pixels;
    const auto columns = std::size_t(spec.width), rows = std::size_t(spec.height);
    const std::size_t channels = pixels.size() / (columns * rows);
    std::vector<float> ordered(pixels.size());
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < columns; ++column) {
            const std::size_t along_rows = orientation.mirrors_rows ? rows - 1 - row : row,
                              along_columns = orientation.mirrors_columns ? columns - 1 - column : column;
            const std::size_t to = orientation.swaps_axes ? along_columns * rows + along_rows
                                                          : along_rows * columns + along_columns;
            std::copy_n(&pixels[(row * columns + column) * channels], channels, &ordered[to * channels]);
        }
    return ordered;
}

}  // namespace

std::span<const PictureFormat> picture_formats() noexcept { return kFormats; }

const PictureFormat* picture_format_of(const fs::path& file) { return find_by_extension(picture_formats(), file); }

const PictureFormat& required_picture_format(const fs::path& file)
{
    if (file.empty()) throw error_without_file("the name of the file is empty", {}, Error::Kind::Output);
    if (file.filename().empty()) refuse(file, "is the name of a folder, not of a file");
    if (const PictureFormat* const format = picture_format_of(file)) return *format;
    throw Error(file.string(),
                "has no extension of a format that can be written: " + extensions_of(picture_formats(), true));
}

void Image::check_writable(const fs::path& file)
{
    const PictureFormat& format = required_picture_format(file);
    check_output(file);
    if (format.needs_codec) check_picture_codec();
}

void Image::write(const fs::path& file, const WriteOptions& options) const
{
    check_writable(file);
    check_contents(file, *this, options);
    picture_format_of(file)->write(*this, file, options);
}

bool Image::has_layers(const fs::path& file)
{
    const PictureFormat* format = picture_format_of(file);
    return format && format->holds_layers;
}

bool Image::is_for_display(const fs::path& file)
{
    const PictureFormat* format = picture_format_of(file);
    return format && format->is_for_display;
}

Image Image::read(const fs::path& file)
{
    if (const std::string why = why_unreadable(file); !why.empty()) throw Error(file.string(), why);
    const OpenImage opened = open_image(file, nullptr, file.string(), kReadLimits);
    PictureReader* const in = opened.reader.get();
    PictureSpec spec = in->spec();
    if (spec.channel_count() > kMaxReadChannels) throw Error(file.string(), "is too large a picture to read");
    if (opened.orientation.swaps_axes) {
        std::swap(spec.width, spec.height), std::swap(spec.full_width, spec.full_height);
        std::swap(spec.x, spec.y), std::swap(spec.full_x, spec.full_y);
    }
    Image image(spec.width, spec.height);
    image.x0 = spec.x - spec.full_x;
    image.y0 = spec.y - spec.full_y;
    image.full_width = spec.full_width;
    image.full_height = spec.full_height;
    add_layers(spec, image);
    if (!read_values(*in, image)) throw Error(file.string(), "cannot be read: " + in->error());
    ImageBytes bytes(file);
    const float power = is_real(spec.type) ? 1 : in->format() == "png" ? png_power(bytes) : 0;
    for (std::size_t l = 0; l < image.layers().size(); ++l) {
        Layer& layer = image.layer(l);
        layer.pixels = put_in_order(std::move(layer.pixels), in->spec(), opened.orientation);
        decode_colors(layer, power, opened.has_multiplied_colors);
    }
    return image;
}

}  // namespace occam::render
