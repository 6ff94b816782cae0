#include "io/texture/decode.h"

#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/srgb.h"
#include "io/exr_file.h"
#include "io/picture_codec.h"
#include "io/texture/image_header.h"
#include "io/texture/image_metadata.h"

namespace occam {

namespace {

const std::array<float, 256>& srgb_table()
{
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t{};
        for (int i = 0; i < 256; ++i) t[static_cast<std::size_t>(i)] = linear_from_srgb(static_cast<float>(i) / 255.0f);
        return t;
    }();
    return table;
}

// The ratio is more texels for each byte of a file than any compression gives: deflate writes 1032 bytes for one, of up to
// eight texels each.
constexpr std::uintmax_t kMaxTexelsPerByte = 16384;
constexpr std::uintmax_t kAlwaysAllowedTexels = std::uintmax_t(1) << 24;

}  // namespace

struct TextureSource::State {
    std::string name;
    TextureRole role = TextureRole::Color;
    int width = 0, height = 0;
    std::vector<Vec4f> pixels;       // linear texels; if empty, the image is encoded
    std::vector<std::byte> encoded;  // kept while the reader refers to it
    std::unique_ptr<PictureReader> input;

    void open(const Texture& texture);
    void check_header(ImageBytes& bytes, const std::string& format);
    void open_memory(const std::string& format);
    void check_size(std::uintmax_t wide, std::uintmax_t high, std::uintmax_t file_bytes) const;
    void read_rows(int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    template <class T>
    void read_rows_as(int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    [[noreturn]] void refuse(const std::string& what) const { throw Error(name, what); }
};

// The size is checked before anything is allocated for the image.
void TextureSource::State::check_size(std::uintmax_t wide, std::uintmax_t high, std::uintmax_t file_bytes) const
{
    const std::string size = std::to_string(wide) + " x " + std::to_string(high);
    if (wide > kMaxTextureSide || high > kMaxTextureSide || wide * high > kMaxTextureTexels)
        refuse("image is larger than is read: " + size);
    if (wide * high > kAlwaysAllowedTexels && wide * high / kMaxTexelsPerByte > file_bytes)
        refuse("image declares far more than the file holds: " + size);
}

void TextureSource::State::check_header(ImageBytes& bytes, const std::string& format)
{
    if (is_cut_off_png(bytes) || is_cut_off_exr(bytes)) refuse("the image is cut off");
    if (const auto canvas = declared_canvas(bytes)) check_size(canvas->width, canvas->height, bytes.size());
    if (format != "openexr") return;
    if (const auto head = read_exr_head(bytes))
        check_size(static_cast<std::uintmax_t>(head->width), static_cast<std::uintmax_t>(head->height), bytes.size());
}

void TextureSource::State::open_memory(const std::string& format)
{
    std::string why;
    input = picture_codec().open(encoded, format, why);
    if (!input) refuse("image cannot be read: " + why);
}

void TextureSource::State::open(const Texture& texture)
{
    std::error_code error;
    if (!texture.encoded && !std::filesystem::is_regular_file(texture.path, error)) refuse("no such image file");
    ImageBytes bytes = texture.encoded ? ImageBytes(std::span(*texture.encoded)) : ImageBytes(texture.path);
    const std::uintmax_t file_bytes = bytes.size();
    const std::string format = image_format(bytes);
    check_header(bytes, format);
    if (texture.encoded && format.empty()) refuse("not an image format that is known");
    if (format == "png" || format == "jpeg" || format == "tiff") {
        std::vector<std::byte> whole(texture.encoded ? 0 : static_cast<std::size_t>(file_bytes));
        if (!bytes.read(0, {reinterpret_cast<unsigned char*>(whole.data()), whole.size()}))
            refuse("the image cannot be read");
        encoded = without_metadata(texture.encoded ? std::span(*texture.encoded) : std::span(std::as_const(whole)), format);
        open_memory(format);
    } else if (texture.encoded) {
        encoded = *texture.encoded;
        if (format == "openexr") input = open_exr(ImageBytes(std::span(std::as_const(encoded))));
        if (!input) open_memory(format);
    } else {
        std::string why;
        if (format == "openexr") input = open_exr(ImageBytes(texture.path));
        if (!input) input = picture_codec().open(texture.path, why);
        if (!input) refuse("image cannot be read: " + why);
    }
    const PictureSpec& spec = input->spec();
    if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1 || spec.channel_count() < 1) refuse("not a flat image");
    if (spec.is_deep) refuse("deep images are not read");
    width = spec.width, height = spec.height;
    check_size(static_cast<std::uintmax_t>(width), static_cast<std::uintmax_t>(height), file_bytes);
}

template <class T>
void TextureSource::State::read_rows_as(int y_begin, int y_end, std::vector<Vec4f>& texels) const
{
    const PictureSpec& spec = input->spec();
    const int channels = std::min(spec.channel_count(), 4);
    std::vector<T> values(std::size_t(y_end - y_begin) * std::size_t(width) * std::size_t(channels));
    if (!input->read_rows(y_begin, y_end, channels, values.data())) refuse("image cannot be decoded: " + input->error());

    const bool is_srgb = role == TextureRole::Color && !is_real(spec.type);
    const auto data = [](T x) { return std::is_integral_v<T> ? static_cast<float>(x) / 255.0f : static_cast<float>(x); };
    const auto color = [&](T x) {
        if constexpr (std::is_integral_v<T>) return is_srgb ? srgb_table()[x] : data(x);
        else return is_srgb ? linear_from_srgb(x) : x;
    };
    texels.resize(std::size_t(y_end - y_begin) * std::size_t(width));
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const T* v = &values[i * static_cast<std::size_t>(channels)];
        const bool is_grey = channels < 3;
        const float r = color(v[0]);
        texels[i] = {r, is_grey ? r : color(v[1]), is_grey ? r : color(v[2]),
                     channels == 2   ? data(v[1])
                     : channels == 4 ? data(v[3])
                                     : 1.0f};
    }
}

void TextureSource::State::read_rows(int y_begin, int y_end, std::vector<Vec4f>& texels) const
{
    if (!input) {
        const auto first = pixels.begin() + std::ptrdiff_t(y_begin) * width;
        texels.assign(first, first + std::ptrdiff_t(y_end - y_begin) * width);
    } else if (input->spec().type == SampleType::Byte) {
        read_rows_as<std::uint8_t>(y_begin, y_end, texels);
    } else {
        read_rows_as<float>(y_begin, y_end, texels);
    }
}

TextureSource::TextureSource(const Texture& texture) : state_(std::make_unique<State>())
{
    state_->name = texture.name.empty() ? texture.path.string() : texture.name;
    state_->role = texture.role;
    if (!texture.pixels.empty()) {
        state_->pixels = texture.pixels;
        state_->width = texture.width, state_->height = texture.height;
        state_->check_size(static_cast<std::uintmax_t>(width()), static_cast<std::uintmax_t>(height()),
                           texture.pixels.size());
    } else {
        state_->open(texture);
    }
}
TextureSource::~TextureSource() = default;
TextureSource::TextureSource(TextureSource&&) noexcept = default;

int TextureSource::width() const noexcept { return state_->width; }
int TextureSource::height() const noexcept { return state_->height; }

MipImage TextureSource::decode(int halvings) const
{
    constexpr int kRowsAtOnce = 64;
    const int block = 1 << halvings;
    MipImage image(std::max(1, width() >> halvings), std::max(1, height() >> halvings));
    // The loop reads whole rows of tiles, and whole rows of the result.
    const int tile = state_->input ? std::max(1, state_->input->spec().tile_height) : 1;
    const int rows = std::max({block, tile, kRowsAtOnce}) / std::max(block, tile) * std::max(block, tile);
    std::vector<Vec4f> texels, row(static_cast<std::size_t>(image.width()));
    for (int y = 0; y < height(); y += rows) {
        const int y_end = std::min(height(), y + rows);
        state_->read_rows(y, y_end, texels);
        // Texels that are left over at the right and lower edges, where the block does not divide the size, are ignored.
        for (int out = y >> halvings; out < image.height() && (out << halvings) < y_end; ++out) {
            const int from = (out << halvings) - y, to = std::min(from + block, y_end - y);
            for (int x = 0; x < image.width(); ++x) {
                Vec4f sum(0);
                int count = 0;
                for (int j = from; j < to; ++j)
                    for (int i = x << halvings; i < std::min(width(), (x + 1) << halvings); ++i, ++count)
                        sum += texels[std::size_t(j) * std::size_t(width()) + std::size_t(i)];
                row[static_cast<std::size_t>(x)] = sum / static_cast<float>(std::max(1, count));
            }
            image.write_row(out, row);
        }
    }
    image.build_levels();
    return image;
}

}  // namespace occam
