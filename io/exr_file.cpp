// This source file and texture/tiled_file.cpp use OpenEXR.
#include "io/exr_file.h"

#include <Iex.h>
#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfVersion.h>
#include <ImfXdr.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

#include "base/overloaded.h"
#include "io/exr_streams.h"

namespace occam {
namespace {

using Imath::Box2i;
using Imath::V2i;

Imf::PixelType pixel_type(const PictureSpec& spec, std::size_t channel)
{
    return spec.channel_type(channel) == SampleType::Half ? Imf::HALF : Imf::FLOAT;
}

Box2i window(int x, int y, int width, int height) { return {V2i(x, y), V2i(x + width - 1, y + height - 1)}; }

void insert(Imf::Header& header, const PictureAttribute& a)
{
    const auto put = [&](const Imf::Attribute& value) { header.insert(a.name, value); };
    std::visit(Overloaded{[&](const std::string& text) { put(Imf::StringAttribute(text)); },
                          [&](float number) { put(Imf::FloatAttribute(number)); },
                          [&](int number) { put(Imf::IntAttribute(number)); },
                          [&](const std::array<float, 16>& given) {
                              Imath::M44f matrix;
                              std::ranges::copy(given, matrix.getValue());
                              put(Imf::M44fAttribute(matrix));
                          },
                          [&](const std::array<float, 8>& c) {
                              put(Imf::ChromaticitiesAttribute(
                                  Imf::Chromaticities({c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]})));
                          }},
               a.value);
}

Imf::Header header_of(const PictureSpec& spec, std::span<const PictureAttribute> attributes)
{
    Imf::Header header(window(spec.full_x, spec.full_y, spec.full_width, spec.full_height),
                       window(spec.x, spec.y, spec.width, spec.height), 1, {0, 0}, 1, Imf::INCREASING_Y,
                       Imf::ZIP_COMPRESSION);
    for (const PictureAttribute& a : attributes) insert(header, a);
    for (std::size_t c = 0; c < spec.channels.size(); ++c)
        header.channels().insert(spec.channels[c], Imf::Channel(pixel_type(spec, c)));
    return header;
}

// The library takes values only in the type of their channel, so those of halves are converted, some rows at a time.
void write_rows(Imf::OutputFile& file, const PictureSpec& spec, const float* pixels)
{
    constexpr int kRowsAtOnce = 64;
    const std::size_t channels = spec.channels.size(), row = static_cast<std::size_t>(spec.width) * channels;
    std::vector<half> halves(row * static_cast<std::size_t>(std::min(kRowsAtOnce, spec.height)));
    for (int y = 0; y < spec.height; y += kRowsAtOnce) {
        const int rows = std::min(kRowsAtOnce, spec.height - y);
        const float* const first = pixels + row * static_cast<std::size_t>(y);
        Imf::FrameBuffer buffer;
        for (std::size_t c = 0; c < channels; ++c) {
            const Imf::PixelType type = pixel_type(spec, c);
            const std::size_t bytes = type == Imf::HALF ? sizeof(half) : sizeof(float);
            if (type == Imf::HALF)
                for (std::size_t i = c; i < row * static_cast<std::size_t>(rows); i += channels) halves[i] = half(first[i]);
            const void* const from = type == Imf::HALF ? static_cast<const void*>(&halves[c]) : first + c;
            buffer.insert(spec.channels[c], Imf::Slice::Make(type, from, V2i(spec.x, spec.y + y), spec.width, rows,
                                                             channels * bytes, row * bytes));
        }
        file.setFrameBuffer(buffer);
        file.writePixels(rows);
    }
}

struct VersionedHeader {
    Imf::Header header;
    int version = 0;
};

// Reads and checks the first header. Throws if it is not valid.
VersionedHeader first_header(ImageBytes& file)
{
    if (is_cut_off_exr(file)) throw Iex::InputExc("the file is cut off");
    ExrInput input(file);
    int magic = 0;
    VersionedHeader first;
    Imf::Xdr::read<Imf::StreamIO>(input, magic);
    Imf::Xdr::read<Imf::StreamIO>(input, first.version);
    if (magic != Imf::MAGIC || Imf::getVersion(first.version) != Imf::EXR_VERSION ||
        !Imf::supportsFlags(Imf::getFlags(first.version)))
        throw Iex::InputExc("the file is of another format or version");
    first.header.readFrom(input, first.version);
    first.header.sanityCheck(Imf::isTiled(first.version), Imf::isMultiPart(first.version));
    return first;
}

int channel_count(const Imf::ChannelList& channels)
{
    int count = 0;
    for (auto c = channels.begin(); c != channels.end(); ++c) ++count;
    return count;
}

// Returns the names of the channels of a plain picture in the order in which a PictureReader has them; none for others.
std::vector<std::string> plain_channels(const Imf::ChannelList& channels)
{
    for (auto c = channels.begin(); c != channels.end(); ++c) {
        const Imf::Channel& channel = c.channel();
        if (channel.type == Imf::UINT || channel.xSampling != 1 || channel.ySampling != 1) return {};
    }
    const std::vector<std::string> known[] = {{"R", "G", "B"}, {"R", "G", "B", "A"}, {"Y"}};
    const int count = channel_count(channels);
    for (const std::vector<std::string>& names : known)
        if (static_cast<int>(names.size()) == count &&
            std::ranges::all_of(names, [&](const std::string& name) { return channels.findChannel(name) != nullptr; }))
            return names;
    return {};
}

bool is_plain(const VersionedHeader& first)
{
    if (Imf::isMultiPart(first.version) || Imf::isNonImage(first.version)) return false;
    if (plain_channels(first.header.channels()).empty()) return false;
    if (!Imf::isTiled(first.version)) return true;
    // The library keeps a whole row of tiles.
    constexpr unsigned kMostTileSide = 256;
    const Imf::TileDescription& tiles = first.header.tileDescription();
    return tiles.mode != Imf::RIPMAP_LEVELS && std::max(tiles.xSize, tiles.ySize) <= kMostTileSide;
}

PictureSpec spec_of(const Imf::Header& header, int version)
{
    PictureSpec spec;
    const Box2i &data = header.dataWindow(), &display = header.displayWindow();
    spec.x = data.min.x, spec.y = data.min.y;
    spec.width = data.max.x - data.min.x + 1, spec.height = data.max.y - data.min.y + 1;
    spec.full_x = display.min.x, spec.full_y = display.min.y;
    spec.full_width = display.max.x - display.min.x + 1, spec.full_height = display.max.y - display.min.y + 1;
    if (Imf::isTiled(version)) {
        spec.tile_width = static_cast<int>(header.tileDescription().xSize);
        spec.tile_height = static_cast<int>(header.tileDescription().ySize);
        const Imf::TileDescription& tiles = header.tileDescription();
        spec.has_levels = tiles.mode == Imf::MIPMAP_LEVELS && tiles.roundingMode == Imf::ROUND_DOWN;
    }
    spec.channels = plain_channels(header.channels());
    spec.type = SampleType::Half;
    for (const std::string& name : spec.channels) {
        spec.channel_types.push_back(header.channels()[name].type == Imf::HALF ? SampleType::Half : SampleType::Float);
        if (spec.channel_types.back() == SampleType::Float) spec.type = SampleType::Float;
    }
    if (spec.channels.size() == 4) spec.alpha_channel = 3;
    return spec;
}

class ExrReader final : public PictureReader {
public:
    explicit ExrReader(ImageBytes&& bytes)
        : bytes_(std::move(bytes)),
          input_(bytes_),
          file_(input_, no_threads()),
          spec_(spec_of(file_.header(), file_.version()))
    {
    }

    const PictureSpec& spec() const noexcept override { return spec_; }
    std::string format() const override { return "openexr"; }
    std::string text_attribute(const std::string& name) const override
    {
        const auto* const found = file_.header().findTypedAttribute<Imf::StringAttribute>(name);
        return found ? found->value() : std::string();
    }
    bool read_rows(int, int, int, std::uint8_t*) override
    {
        error_ = "the values of OpenEXR pictures are not bytes";
        return false;
    }
    bool read_rows(int y_begin, int y_end, int channels, float* to) override
    {
        const std::size_t stride = static_cast<std::size_t>(channels) * sizeof(float);
        try {
            Imf::FrameBuffer buffer;
            for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
                buffer.insert(spec_.channels.at(c),
                              Imf::Slice::Make(Imf::FLOAT, to + c, V2i(spec_.x, spec_.y + y_begin), spec_.width,
                                               y_end - y_begin, stride, stride * static_cast<std::size_t>(spec_.width)));
            file_.setFrameBuffer(buffer);
            file_.readPixels(spec_.y + y_begin, spec_.y + y_end - 1);
            return true;
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            error_ = error.what();
            return false;
        }
    }
    std::string error() const override { return error_; }

private:
    ImageBytes bytes_;
    ExrInput input_;
    Imf::InputFile file_;
    PictureSpec spec_;
    std::string error_;
};

}  // namespace

std::string write_exr(const PictureSpec& spec, std::span<const PictureAttribute> attributes, const float* pixels,
                      PictureBytes& to)
{
    try {
        ExrOutput output(to);
        Imf::OutputFile file(output, header_of(spec, attributes), no_threads());
        write_rows(file, spec, pixels);
        return {};
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        return error.what();
    }
}

std::optional<ExrHead> read_exr_head(ImageBytes& file, const char* attribute)
{
    try {
        const VersionedHeader first = first_header(file);
        const Box2i& data = first.header.dataWindow();
        const auto* const text = first.header.findTypedAttribute<Imf::StringAttribute>(attribute);
        ExrHead head{.width = data.max.x - data.min.x + 1,
                     .height = data.max.y - data.min.y + 1,
                     .channel_count = channel_count(first.header.channels()),
                     .text = text ? text->value() : std::string()};
        if (Imf::isTiled(first.version)) {
            head.tile_width = first.header.tileDescription().xSize;
            head.tile_height = first.header.tileDescription().ySize;
        }
        return head;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        return {};
    }
}

bool has_last_row(ImageBytes file)
{
    try {
        const int version = first_header(file).version;
        if (Imf::isMultiPart(version) || Imf::isTiled(version) || Imf::isNonImage(version)) return true;
        ExrInput input(file);
        Imf::InputFile part(input, no_threads());
        const Imf::ChannelList& channels = part.header().channels();
        if (channels.begin() == channels.end()) return true;
        if (!part.isComplete()) return false;
        const Box2i& data = part.header().dataWindow();
        const int width = data.max.x - data.min.x + 1;
        std::vector<float> row(static_cast<std::size_t>(width));
        Imf::FrameBuffer buffer;
        const auto first = channels.begin();
        const int x_sampling = first.channel().xSampling, y_sampling = first.channel().ySampling;
        const Box2i last_row(V2i(data.min.x, data.max.y), data.max);
        buffer.insert(first.name(), Imf::Slice::Make(Imf::FLOAT, row.data(), last_row, 0, 0, x_sampling, y_sampling));
        part.setFrameBuffer(buffer);
        part.readPixels(data.max.y, data.max.y);
        return true;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        return false;
    }
}

std::unique_ptr<PictureReader> open_exr(ImageBytes file)
{
    try {
        if (!is_plain(first_header(file))) return nullptr;
        return std::make_unique<ExrReader>(std::move(file));
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        return nullptr;
    }
}

}  // namespace occam
