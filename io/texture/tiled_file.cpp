#include "io/texture/tiled_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfTiledInputFile.h>
#include <ImfTiledOutputFile.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <span>
#include <utility>

#include "base/error.h"
#include "io/encoded_bytes.h"
#include "io/exr_file.h"
#include "io/exr_streams.h"
#include "io/texture/image_header.h"

namespace occam {
namespace {

constexpr const char *kAttribute = "occam_texture", *kVersion = "1";
constexpr const char *kRoleAttribute = "occam_texture_role", *kColor = "color", *kData = "data";
constexpr const char* kChannels[] = {"R", "G", "B", "A"};

std::atomic<int> files_open = 0;

// Returns how many files stay open after a tile was read: a process may open a thousand or so, and others need some.
int most_open()
{
    static const int most = [] {
        rlimit limit{};
        const bool is_known = getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
        return is_known ? static_cast<int>(std::min<rlim_t>(limit.rlim_cur / 4, 256)) : 256;
    }();
    return most;
}

// What MipImage::write_row() makes of numbers that are not finite.
void make_finite(std::span<std::uint16_t> halves) noexcept
{
    for (std::uint16_t& h : halves)
        if ((h & 0x7c00u) == 0x7c00u) h = (h & 0x3ffu) != 0 ? 0 : static_cast<std::uint16_t>((h & 0x8000u) | 0x7bffu);
}

std::atomic<std::uint64_t> next_number = 0;

// The library adds the place of a tile in its level to the addresses, unless they count from each tile's own corner.
Imf::FrameBuffer buffer_of(TextureTile& tile)
{
    constexpr std::size_t kTexel = 4 * sizeof(std::uint16_t);
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < 4; ++c)
        buffer.insert(kChannels[c], Imf::Slice(Imf::HALF, reinterpret_cast<char*>(tile.at(0, 0) + c), kTexel,
                                               kTexel * std::size_t(tile.width), 1, 1, 0, true, true));
    return buffer;
}

void write_levels(const MipImage& image, TextureRole role, PictureBytes& to)
{
    Imf::Header header(image.width(), image.height());
    header.compression() = Imf::ZIP_COMPRESSION;
    header.setTileDescription({TextureTile::kSide, TextureTile::kSide, Imf::MIPMAP_LEVELS, Imf::ROUND_DOWN});
    for (const char* name : kChannels) header.channels().insert(name, Imf::Channel(Imf::HALF));
    header.insert(kAttribute, Imf::StringAttribute(kVersion));
    header.insert(kRoleAttribute, Imf::StringAttribute(role == TextureRole::Data ? kData : kColor));
    ExrOutput output(to);
    Imf::TiledOutputFile file(output, header, no_threads());
    for (int level = 0; level < file.numLevels(); ++level)
        for (int row = 0; row < file.numYTiles(level); ++row)
            for (int column = 0; column < file.numXTiles(level); ++column) {
                const int x0 = column * TextureTile::kSide, y0 = row * TextureTile::kSide;
                const int width = std::min(TextureTile::kSide, file.levelWidth(level) - x0),
                          height = std::min(TextureTile::kSide, file.levelHeight(level) - y0);
                TextureTile tile(width, height);
                for (int y = 0; y < height; ++y)
                    for (int x = 0; x < width; ++x) std::copy_n(image.halves(level, x0 + x, y0 + y), 4, tile.at(x, y));
                file.setFrameBuffer(buffer_of(tile));
                file.writeTile(column, row, level);
            }
}

}  // namespace

// What a library may allocate for is checked before it sees the file again, which may have changed.
struct TiledFile::Open {
    Open(const std::filesystem::path& file, int width, int height)
        : bytes(checked(file, width, height)), stream(bytes), tiles(stream, no_threads())
    {
        if (tiles.levelMode() != Imf::MIPMAP_LEVELS || tiles.levelRoundingMode() != Imf::ROUND_DOWN) refuse_change();
        ++files_open;
    }
    ~Open() { --files_open; }
    Open(const Open&) = delete;
    Open& operator=(const Open&) = delete;

    static ImageBytes checked(const std::filesystem::path& file, int width, int height)
    {
        std::error_code error;
        if (!std::filesystem::is_regular_file(file, error)) throw Iex::InputExc("it is no file any more");
        ImageBytes bytes(file);
        if (bytes.size() == 0) throw Iex::InputExc("it is empty, or the process may not open it");
        const auto head = is_cut_off_exr(bytes) ? std::nullopt : read_exr_head(bytes);
        if (!head) throw Iex::InputExc("it is cut off, or damaged");
        if (head->width != width || head->height != height || head->channel_count != 4 ||
            head->tile_width != TextureTile::kSide || head->tile_height != TextureTile::kSide)
            refuse_change();
        return bytes;
    }
    [[noreturn]] static void refuse_change() { throw Iex::InputExc("it has changed while the scene was rendered"); }

    ImageBytes bytes;
    ExrInput stream;
    Imf::TiledInputFile tiles;
};

void TiledFile::write(const MipImage& image, TextureRole role, const std::filesystem::path& file)
{
    OutputFile out(file);
    EncodedBytes bytes(out);
    try {
        write_levels(image, role, bytes);
    } catch (const Iex::BaseExc& error) {
        throw Error(file.string(), std::string("cannot be written: ") + error.what(), {}, Error::Kind::Output);
    }
    out.publish();
}

bool TiledFile::is_one(const PictureReader& picture)
{
    const PictureSpec& spec = picture.spec();
    return picture.format() == "openexr" && picture.text_attribute(kAttribute) == kVersion && spec.has_levels &&
           spec.type == SampleType::Half && spec.tile_width == TextureTile::kSide &&
           spec.tile_height == TextureTile::kSide && spec.x == 0 && spec.y == 0 && spec.full_x == 0 && spec.full_y == 0 &&
           spec.full_width == spec.width && spec.full_height == spec.height &&
           spec.channels == std::vector<std::string>(std::begin(kChannels), std::end(kChannels));
}

bool TiledFile::keeps_colors_apart(const PictureReader& picture) { return picture.text_attribute(kAttribute) == kVersion; }

TextureRole TiledFile::role_of(const PictureReader& picture)
{
    return picture.text_attribute(kRoleAttribute) == kData ? TextureRole::Data : TextureRole::Color;
}

TiledFile::TiledFile(std::filesystem::path file, std::string name, int width, int height)
    : file_(std::move(file)), name_(std::move(name)), width_(width), height_(height), number_(++next_number)
{
}
TiledFile::~TiledFile() = default;

int TiledFile::level_count() const noexcept { return std::bit_width(static_cast<unsigned>(std::max(width_, height_))); }
int TiledFile::level_width(int level) const noexcept { return std::max(1, width_ >> level); }
int TiledFile::level_height(int level) const noexcept { return std::max(1, height_ >> level); }

TextureTile TiledFile::read(int level, int column, int row)
{
    constexpr int kSide = TextureTile::kSide;
    TextureTile tile(std::min(kSide, level_width(level) - column * kSide),
                     std::min(kSide, level_height(level) - row * kSide));
    try {
        if (!open_) open_ = std::make_unique<Open>(file_, width_, height_);
        open_->tiles.setFrameBuffer(buffer_of(tile));
        open_->tiles.readTile(column, row, level);
        if (files_open > most_open()) open_.reset();
        make_finite(tile.halves);
        return tile;
    } catch (const Iex::BaseExc& error) {
        open_.reset();
        throw Error(name_, "a tile of the image cannot be read", error.what());
    }
}

void TiledFile::check()
{
    constexpr int kSide = TextureTile::kSide;
    for (int level = 0; level < level_count(); ++level)
        for (int row = 0; row * kSide < level_height(level); ++row)
            for (int column = 0; column * kSide < level_width(level); ++column) {
                const std::lock_guard lock(reading_);
                read(level, column, row);
            }
}

}  // namespace occam
