#include "io/texture/decode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/srgb.h"
#include "io/texture/open_image.h"

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

constexpr ImageLimits kLimits = {kMaxTextureSide, kMaxTextureTexels, kMaxTextureTexels * 4};

}  // namespace

struct TextureSource::State {
    std::string name;
    TextureRole role = TextureRole::Color;
    int width = 0, height = 0;
    std::vector<Vec4f> pixels;  // linear texels; if empty, the image is encoded
    OpenImage image;
    PictureReader* input = nullptr;  // that of `image`

    void open(const Texture& texture);
    void read_rows(int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    template <class T>
    void read_rows_as(int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    [[noreturn]] void refuse(const std::string& what) const { throw Error(name, what); }
};

void TextureSource::State::open(const Texture& texture)
{
    std::error_code error;
    if (!texture.encoded && !std::filesystem::is_regular_file(texture.path, error)) refuse("no such image file");
    image = open_image(texture.path, texture.encoded.get(), name, kLimits);
    input = image.reader.get();
    width = input->spec().width, height = input->spec().height;
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
        if (std::max(width(), height()) > kMaxTextureSide || texture.pixels.size() > kMaxTextureTexels)
            state_->refuse("image is larger than is read: " + std::to_string(width()) + " x " + std::to_string(height()));
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
