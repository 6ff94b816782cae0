#include "io/texture/decode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/srgb.h"
#include "io/texture/multiplied_color.h"
#include "io/texture/open_image.h"
#include "io/texture/row_filter.h"
#include "io/texture/tiled_file.h"

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

constexpr ImageLimits kLimits = {kMaxTextureSide, kMaxTextureTexels, kMaxTextureTexels * 4, kMaxTextureTexels * 4};

// Says which channels of an image are the colours of a texel and its alpha; -1: there is none.
struct ChannelPlaces {
    int color[3] = {0, 0, 0}, alpha = -1;

    int count() const { return 1 + std::max({color[0], color[1], color[2], alpha}); }
    std::ptrdiff_t missing() const { return std::count(color, color + 3, -1); }
};

// The name of a channel of an OpenEXR file: that of its layer, if it has one, and after the last point its own.
struct ChannelName {
    explicit ChannelName(std::string_view whole)
        : layer(whole.substr(0, whole.rfind('.') == std::string_view::npos ? 0 : whole.rfind('.'))),
          own(whole.substr(whole.rfind('.') + 1))
    {
    }
    std::string_view layer, own;
};

// Returns the places that the letters of a set have in the layer that has the most of them: of several the one without a
// name, or else the first. A file may have very many layers, so the channels are looked at once.
ChannelPlaces places_by_name(const PictureSpec& spec, std::string_view letters)
{
    std::vector<ChannelPlaces> layers{{{-1, -1, -1}, -1}};
    std::map<std::string_view, std::size_t> number_of;
    number_of.emplace(std::string_view(), 0);
    for (int c = 0; c < spec.channel_count(); ++c) {
        const ChannelName name(spec.channels[static_cast<std::size_t>(c)]);
        const auto [known, is_new] = number_of.try_emplace(name.layer, layers.size());
        if (is_new) layers.push_back({{-1, -1, -1}, -1});
        const std::size_t letter = name.own.size() == 1 ? letters.find(name.own) : std::string_view::npos;
        if (letter == std::string_view::npos) continue;
        int& place = layers[known->second].color[letter];
        if (place < 0) place = c;
    }
    return *std::ranges::min_element(layers, {}, &ChannelPlaces::missing);
}

// Returns the place of the alpha of a layer: its own, or else that of the file as a whole, whose name has no layer.
int alpha_of_layer(const PictureSpec& spec, std::string_view layer)
{
    int of_file = -1;
    for (int c = 0; c < spec.channel_count(); ++c) {
        const ChannelName name(spec.channels[static_cast<std::size_t>(c)]);
        if (name.own != "A" && c != spec.alpha_channel) continue;
        if (name.layer == layer) return c;
        if (name.layer.empty() && of_file < 0) of_file = c;
    }
    return of_file;
}

// OpenEXR files say what their channels are by names: two or more of R, G and B are these colours, wherever they stand, and
// X, Y and Z together are a vector. Else of the first four channels three are colours in their order, and fewer are grey. A
// depth is no colour, and neither is an alpha.
ChannelPlaces places_in_exr(const PictureSpec& spec)
{
    const auto layer_of = [&](int channel) { return ChannelName(spec.channels[static_cast<std::size_t>(channel)]).layer; };
    for (const std::string_view letters : {"RGB", "XYZ"}) {
        ChannelPlaces places = places_by_name(spec, letters);
        if (places.missing() > (letters == "RGB" ? 1 : 0)) continue;
        places.alpha = alpha_of_layer(spec, layer_of(std::max(places.color[0], places.color[1])));
        return places;
    }
    ChannelPlaces places;
    int found = 0;
    for (int c = 0; c < std::min(spec.channel_count(), 4) && found < 3; ++c) {
        const std::string_view own = ChannelName(spec.channels[static_cast<std::size_t>(c)]).own;
        if (own != "A" && c != spec.alpha_channel && (found == 0 || own != "Z")) places.color[found++] = c;
    }
    if (found < 3) std::fill_n(places.color + 1, 2, places.color[0]);
    places.alpha = alpha_of_layer(spec, layer_of(places.color[0]));
    return places;
}

// In other formats than OpenEXR the order of the channels says what they are.
ChannelPlaces places_of(const OpenImage& image)
{
    const PictureSpec& spec = image.reader->spec();
    if (image.reader->format() == "openexr") return places_in_exr(spec);
    const int count = std::min(spec.channel_count(), 4);
    if (count == 2 && image.has_two_colors) return {{0, 1, -1}, -1};
    if (count < 3) return {{0, 0, 0}, count == 2 ? 1 : -1};
    return {{0, 1, 2}, count == 4 ? 3 : -1};
}

// Returns the third part of a unit vector whose parts are stored as values from 0 to 1, as a normal map has them.
float third_part(float x, float y)
{
    const float a = 2 * x - 1, b = 2 * y - 1;
    return 0.5f + 0.5f * std::sqrt(std::max(0.0f, 1 - a * a - b * b));
}

}  // namespace

struct TextureSource::State {
    std::string name;
    TextureRole role = TextureRole::Color;
    int width = 0, height = 0;
    std::span<const Vec4f> pixels;  // linear texels of the texture; if empty, the image is encoded
    OpenImage image;
    PictureReader* input = nullptr;  // that of `image`
    int left = 0, top = 0;           // where the rows of `input` begin in the texture; they may reach beyond it
    ChannelPlaces places;
    bool is_tiled_file = false, has_other_role = false;

    void open(const Texture& texture, DecodeBudget* budget);
    void place(const PictureSpec& spec, std::uintmax_t file_bytes);
    int data_width() const { return input ? input->spec().width : width; }
    int data_height() const { return input ? input->spec().height : height; }
    void read_rows(int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    template <class T>
    void read_rows_as(int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    [[noreturn]] void refuse(const std::string& what) const { throw Error(name, what); }
    void check_size() const
    {
        if (std::max(width, height) > kMaxTextureSide || std::size_t(width) * std::size_t(height) > kMaxTextureTexels)
            refuse("image is larger than is read: " + std::to_string(width) + " x " + std::to_string(height));
    }
};

void TextureSource::State::open(const Texture& texture, DecodeBudget* budget)
{
    std::error_code error;
    if (!texture.encoded && !std::filesystem::is_regular_file(texture.path, error)) refuse("no such image file");
    image = open_image(texture.path, texture.encoded.get(), name, kLimits, budget);
    input = image.reader.get();
    places = places_of(image);
    for (const int c : {places.color[0], places.color[1], places.color[2], places.alpha})
        if (c >= 0 && input->format() == "openexr" &&
            input->spec().channel_type(static_cast<std::size_t>(c)) == SampleType::OtherInteger)
            refuse("channels of whole numbers (UINT) are not read as colours");
    width = input->spec().width, height = input->spec().height;
    if (image.orientation.swaps_axes) std::swap(width, height);
    if (input->format() != "openexr") return;
    const bool is_tiled = TiledFile::is_one(*input);
    is_tiled_file = is_tiled && !texture.encoded;
    has_other_role = is_tiled && TiledFile::role_of(*input) != role;
    place(input->spec(), texture.encoded ? texture.encoded->size() : std::filesystem::file_size(texture.path, error));
}

// The picture of an OpenEXR file is its display window, of which the file may hold a part, or more. A window of which it
// holds nothing says nothing.
void TextureSource::State::place(const PictureSpec& spec, std::uintmax_t file_bytes)
{
    const std::int64_t x = std::int64_t(spec.x) - spec.full_x, y = std::int64_t(spec.y) - spec.full_y;
    if (spec.full_width <= 0 || spec.full_height <= 0) return;
    if (x >= spec.full_width || y >= spec.full_height || x + spec.width <= 0 || y + spec.height <= 0) return;
    left = static_cast<int>(x), top = static_cast<int>(y);
    width = spec.full_width, height = spec.full_height;
    check_size();
    const std::uintmax_t texels = std::uintmax_t(width) * std::uintmax_t(height);
    if (declares_too_much(texels, file_bytes)) refuse("the display window is far larger than the file");
}

template <class T>
void TextureSource::State::read_rows_as(int y_begin, int y_end, std::vector<Vec4f>& texels) const
{
    const PictureSpec& spec = input->spec();
    const int channels = places.count();
    std::vector<T> values(std::size_t(y_end - y_begin) * std::size_t(spec.width) * std::size_t(channels));
    if (!input->read_rows(y_begin, y_end, channels, values.data())) refuse("image cannot be decoded: " + input->error());

    const bool is_srgb = role == TextureRole::Color && !is_real(spec.type);
    const auto data = [](T x) { return std::is_integral_v<T> ? static_cast<float>(x) / 255.0f : static_cast<float>(x); };
    const auto color = [&](T x) {
        if constexpr (std::is_integral_v<T>) return is_srgb ? srgb_table()[x] : data(x);
        else return is_srgb ? linear_from_srgb(x) : x;
    };
    const bool divides = role == TextureRole::Color && image.has_multiplied_colors && places.alpha >= 0;
    const auto color_at = [&](const T* v, int place) {
        if (place < 0) return 0.0f;
        return divides && place != places.alpha ? color_without_alpha(data(v[place]), data(v[places.alpha]), is_srgb)
                                                : color(v[place]);
    };
    const auto [r, g, b] = places.color;
    texels.resize(std::size_t(y_end - y_begin) * std::size_t(spec.width));
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const T* v = &values[i * static_cast<std::size_t>(channels)];
        texels[i] = {color_at(v, r), color_at(v, g), color_at(v, b), places.alpha < 0 ? 1.0f : data(v[places.alpha])};
        if (image.has_two_colors && role == TextureRole::Data) texels[i].z = third_part(texels[i].x, texels[i].y);
    }
}

// Reads rows of the data, which begin at `top`.
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

TextureSource::TextureSource(const Texture& texture, DecodeBudget* budget) : state_(std::make_unique<State>())
{
    state_->name = texture.name.empty() ? texture.path.string() : texture.name;
    state_->role = texture.role;
    if (!texture.pixels.empty()) {
        state_->pixels = texture.pixels;
        state_->width = texture.width, state_->height = texture.height;
        state_->check_size();
    } else {
        state_->open(texture, budget);
    }
}
TextureSource::~TextureSource() = default;
TextureSource::TextureSource(TextureSource&&) noexcept = default;

int TextureSource::width() const noexcept { return state_->width; }
int TextureSource::height() const noexcept { return state_->height; }
bool TextureSource::is_tiled_file() const noexcept { return state_->is_tiled_file; }
std::uintmax_t TextureSource::bytes_to_decode() const noexcept
{
    if (!state_->input) return 0;
    const PictureSpec& spec = state_->input->spec();
    std::uintmax_t bytes = 0;
    for (std::size_t i = 0; i < spec.channels.size(); ++i) bytes += most_bytes(spec.channel_type(i));
    constexpr std::uintmax_t kLeastBytes = 4;
    const auto area = [](int wide, int high) {
        return static_cast<std::uintmax_t>(wide) * static_cast<std::uintmax_t>(high);
    };
    return std::max(bytes, kLeastBytes) * std::max(area(width(), height()), area(spec.width, spec.height));
}
bool TextureSource::has_alpha() const noexcept { return !state_->input || state_->places.alpha >= 0; }
bool TextureSource::has_texels_of_another_role() const noexcept { return state_->has_other_role; }

MipImage TextureSource::decode(int halvings, bool multiplies_by_alpha) const
{
    constexpr int kValuesAtOnce = 256;  // of a column: images of many channels are read in fewer rows
    const State& s = *state_;
    MipImage image(std::max(1, width() >> halvings), std::max(1, height() >> halvings));
    const bool swaps_axes = s.image.orientation.swaps_axes;
    const int columns = swaps_axes ? height() : width(), lines = swaps_axes ? width() : height();  // as the file has them
    RowFilter filter(columns, lines, image, s.image.orientation);
    const int tile = s.input ? std::max(1, s.input->spec().tile_height) : 1;
    const int at_once = std::clamp(kValuesAtOnce / s.places.count(), 1, 64);
    const int rows = std::max(tile, at_once) / tile * tile;  // whole rows of tiles
    const Vec4f nothing(0, 0, 0, s.places.alpha < 0 ? 1 : 0);
    std::vector<Vec4f> texels, row(static_cast<std::size_t>(columns), nothing);
    for (int y = 0; y < s.top; ++y) filter.add(row);
    const int first = std::max(0, s.left), end = std::min(columns, s.left + s.data_width());
    for (int y = 0; y < s.data_height(); y += rows) {
        const int y_end = std::min(s.data_height(), y + rows);
        s.read_rows(y, y_end, texels);
        for (int j = y; j < y_end; ++j) {
            if (s.top + j < 0 || s.top + j >= lines) continue;
            const Vec4f* const from = &texels[std::size_t(j - y) * std::size_t(s.data_width())];
            std::copy(from + (first - s.left), from + (end - s.left), row.begin() + first);
            if (multiplies_by_alpha)
                for (int x = first; x < end; ++x) row[std::size_t(x)] *= Vec4f(Vec3f(row[std::size_t(x)].w), 1);
            filter.add(row);
        }
    }
    std::fill(row.begin(), row.end(), nothing);
    for (int y = s.top + s.data_height(); y < lines; ++y) filter.add(row);
    image.build_levels();
    return image;
}

}  // namespace occam
