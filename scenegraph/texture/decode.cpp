#include "scenegraph/texture/decode.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <span>

#include "scenegraph/base/error.h"
#include "scenegraph/base/srgb.h"

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

// The name of the reader of OpenImageIO, by what the file begins with; a declared type may be wrong. Empty: unknown.
std::string format_of(const std::vector<std::byte>& bytes)
{
    const auto starts_with = [&](const char* magic, std::size_t size, std::size_t at = 0) {
        return bytes.size() >= at + size && std::memcmp(bytes.data() + at, magic, size) == 0;
    };
    if (starts_with("\x89PNG", 4)) return "png";
    if (starts_with("\xff\xd8\xff", 3)) return "jpeg";
    if (starts_with("\x76\x2f\x31\x01", 4)) return "openexr";
    if (starts_with("RIFF", 4) && starts_with("WEBP", 4, 8)) return "webp";
    if (starts_with("II*\0", 4) || starts_with("MM\0*", 4)) return "tiff";
    if (starts_with("#?RADIANCE", 10)) return "hdr";
    if (starts_with("GIF8", 4)) return "gif";
    if (starts_with("BM", 2)) return "bmp";
    return {};
}

constexpr std::array<unsigned char, 8> kPngMagic = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

// Does a chunk of a PNG reach past the end of the file, or the last one lack? (PNG, sec. 5.3.) libpng would jump out of
// OpenImageIO's reader at the missing byte, past its destructors. read(at, to) fills 8 bytes, or says that they are not there.
template <class Read>
bool is_cut_off_png(std::uintmax_t size, Read&& read)
{
    std::array<unsigned char, 8> word{};
    if (!read(0, word) || word != kPngMagic) return false;
    for (std::uintmax_t at = word.size(); read(at, word);) {
        std::uintmax_t length = 0;
        for (int i = 0; i < 4; ++i) length = length << 8 | word[static_cast<std::size_t>(i)];
        constexpr std::uintmax_t kAround = 12;  // length, name, checksum
        if (size - at < kAround || length > size - at - kAround) return true;
        if (std::memcmp(&word[4], "IEND", 4) == 0) return false;
        at += length + kAround;
    }
    return true;
}
bool is_cut_off_png(std::span<const std::byte> bytes)
{
    return is_cut_off_png(bytes.size(), [&](std::uintmax_t at, std::array<unsigned char, 8>& to) {
        if (bytes.size() < to.size() || at > bytes.size() - to.size()) return false;
        std::memcpy(to.data(), bytes.data() + at, to.size());
        return true;
    });
}
bool is_cut_off_png(const std::filesystem::path& path)
{
    std::ifstream stream(path, std::ios::binary);
    std::error_code error;
    return is_cut_off_png(std::filesystem::file_size(path, error), [&](std::uintmax_t at, std::array<unsigned char, 8>& to) {
        return stream.seekg(static_cast<std::streamoff>(at)) && stream.read(reinterpret_cast<char*>(to.data()), to.size());
    });
}

}  // namespace

struct TextureSource::State {
    std::string name;
    TextureRole role = TextureRole::Color;
    int width = 0, height = 0;
    std::vector<Vec4f> pixels;                              // linear already; or
    std::shared_ptr<const std::vector<std::byte>> encoded;  // kept while the reader looks into it
    std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
    std::unique_ptr<OIIO::ImageInput> input;

    void open(const Texture& texture);
    void read_rows(int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    template <class T>
    void read_rows_as(OIIO::TypeDesc type, int y_begin, int y_end, std::vector<Vec4f>& texels) const;
    [[noreturn]] void refuse(const std::string& what) const { throw Error(name, what); }
};

void TextureSource::State::open(const Texture& texture)
{
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;
    if (texture.encoded) {
        encoded = texture.encoded;
        const std::string format = format_of(*encoded);
        if (format.empty()) refuse("not an image format that is known");
        if (is_cut_off_png(*encoded)) refuse("the image is cut off");
        memory = std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<std::byte*>(encoded->data()), encoded->size());
        // The reader takes the bytes from this attribute: ImageInput::open(name, config, proxy) closes the proxy again.
        OIIO::Filesystem::IOProxy* proxy = memory.get();
        config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
        input = OIIO::ImageInput::create(format);
        OIIO::ImageSpec opened;
        if (input && !input->open("memory." + format, opened, config)) {
            const std::string why = input->geterror();
            input.reset();
            refuse("image cannot be read: " + why);
        }
    } else {
        std::error_code error;
        if (!std::filesystem::is_regular_file(texture.path, error)) refuse("no such image file");
        if (is_cut_off_png(texture.path)) refuse("the image is cut off");
        input = OIIO::ImageInput::open(texture.path.string(), &config);
    }
    if (!input) refuse("image cannot be read: " + OIIO::geterror());
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1 || spec.nchannels < 1) refuse("not a flat image");
    if (spec.deep) refuse("deep images are not read");
    width = spec.width, height = spec.height;
}

template <class T>
void TextureSource::State::read_rows_as(OIIO::TypeDesc type, int y_begin, int y_end, std::vector<Vec4f>& texels) const
{
    const OIIO::ImageSpec& spec = input->spec();
    const int channels = std::min(spec.nchannels, 4);
    std::vector<T> values(std::size_t(y_end - y_begin) * std::size_t(width) * std::size_t(channels));
    const int y0 = spec.y + y_begin, y1 = spec.y + y_end;
    const bool ok = spec.tile_width > 0
                        ? input->read_tiles(0, 0, spec.x, spec.x + width, y0, y1, 0, 1, 0, channels, type, values.data())
                        : input->read_scanlines(0, 0, y0, y1, 0, 0, channels, type, values.data());
    if (!ok) refuse("image cannot be decoded: " + input->geterror());

    const bool is_integer = spec.format.basetype != OIIO::TypeDesc::FLOAT && spec.format.basetype != OIIO::TypeDesc::HALF &&
                            spec.format.basetype != OIIO::TypeDesc::DOUBLE;
    const bool is_srgb = role == TextureRole::Color && is_integer;
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
    } else if (input->spec().format == OIIO::TypeDesc::UINT8) {
        read_rows_as<std::uint8_t>(OIIO::TypeDesc::UINT8, y_begin, y_end, texels);
    } else {
        read_rows_as<float>(OIIO::TypeDesc::FLOAT, y_begin, y_end, texels);
    }
}

TextureSource::TextureSource(const Texture& texture) : state_(std::make_unique<State>())
{
    state_->name = texture.name.empty() ? texture.path.string() : texture.name;
    state_->role = texture.role;
    if (!texture.pixels.empty()) {
        state_->pixels = texture.pixels;
        state_->width = texture.width, state_->height = texture.height;
    } else {
        state_->open(texture);
    }
    if (width() > kMaxTextureSide || height() > kMaxTextureSide ||
        std::size_t(width()) * std::size_t(height()) > kMaxTextureTexels)
        state_->refuse("image is larger than is read: " + std::to_string(width()) + " x " + std::to_string(height()));
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
    // Whole rows of tiles, and whole rows of the result.
    const int tile = state_->input && state_->input->spec().tile_width > 0 ? state_->input->spec().tile_height : 1;
    const int rows = std::max({block, tile, kRowsAtOnce}) / std::max(block, tile) * std::max(block, tile);
    std::vector<Vec4f> texels, row(static_cast<std::size_t>(image.width()));
    for (int y = 0; y < height(); y += rows) {
        const int y_end = std::min(height(), y + rows);
        state_->read_rows(y, y_end, texels);
        // What is left over at the right and lower edges of a size that the block does not divide is not seen.
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
