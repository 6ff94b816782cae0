#include "io/texture/tiled_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfTiledInputFile.h>
#include <ImfTiledOutputFile.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>
#include <utility>

#include "base/error.h"
#include "io/exr_streams.h"
#include "io/output_file.h"
#include "io/texture/image_header.h"

namespace occam {
namespace {

constexpr const char *kAttribute = "occam_texture", *kVersion = "1";
constexpr const char* kChannels[] = {"R", "G", "B", "A"};

// Files beyond this number are closed after each tile, since a process may open a thousand or so.
constexpr int kMostOpen = 256;
std::atomic<int> files_open = 0;

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

class TileBytes final : public PictureBytes {
public:
    explicit TileBytes(OutputFile& file) : file_(file) {}
    void write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept override
    {
        file_.write_at(bytes, size, offset);
    }
    std::size_t read_at(void* bytes, std::size_t size, std::uint64_t offset) const noexcept override
    {
        return file_.read_at(bytes, size, offset);
    }
    std::uint64_t size() const noexcept override { return file_.size(); }

private:
    OutputFile& file_;
};

void write_levels(const MipImage& image, PictureBytes& to)
{
    Imf::Header header(image.width(), image.height());
    header.compression() = Imf::ZIP_COMPRESSION;
    header.setTileDescription({TextureTile::kSide, TextureTile::kSide, Imf::MIPMAP_LEVELS, Imf::ROUND_DOWN});
    for (const char* name : kChannels) header.channels().insert(name, Imf::Channel(Imf::HALF));
    header.insert(kAttribute, Imf::StringAttribute(kVersion));
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

struct TiledFile::Open {
    std::mutex mutex;  // guards the members below
    struct Input {
        explicit Input(const std::filesystem::path& file) : bytes(file), stream(bytes), tiles(stream, no_threads())
        {
            ++files_open;
        }
        ~Input() { --files_open; }
        Input(const Input&) = delete;
        Input& operator=(const Input&) = delete;

        ImageBytes bytes;
        ExrInput stream;
        Imf::TiledInputFile tiles;
    };
    std::unique_ptr<Input> input;
};

void TiledFile::write(const MipImage& image, const std::filesystem::path& file)
{
    OutputFile out(file);
    TileBytes bytes(out);
    try {
        write_levels(image, bytes);
    } catch (const Iex::BaseExc& error) {
        throw Error(file.string(), std::string("cannot be written: ") + error.what(), {}, Error::Kind::Output);
    }
    out.publish();
}

bool TiledFile::is_one(const PictureReader& picture)
{
    const PictureSpec& spec = picture.spec();
    return picture.format() == "openexr" && picture.text_attribute(kAttribute) == kVersion &&
           spec.tile_width == TextureTile::kSide && spec.tile_height == TextureTile::kSide && spec.x == 0 && spec.y == 0 &&
           spec.full_x == 0 && spec.full_y == 0 && spec.full_width == spec.width && spec.full_height == spec.height &&
           spec.channels == std::vector<std::string>(std::begin(kChannels), std::end(kChannels));
}

TiledFile::TiledFile(std::filesystem::path file, std::string name, int width, int height)
    : file_(std::move(file)),
      name_(std::move(name)),
      width_(width),
      height_(height),
      number_(++next_number),
      open_(std::make_unique<Open>())
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
    const std::lock_guard lock(open_->mutex);
    try {
        if (!open_->input) {
            auto input = std::make_unique<Open::Input>(file_);
            const Imf::TiledInputFile& tiles = input->tiles;
            const Imf::Header& header = tiles.header();
            const Imath::Box2i& data = header.dataWindow();
            if (tiles.numXLevels() != level_count() || tiles.levelMode() != Imf::MIPMAP_LEVELS ||
                tiles.levelRoundingMode() != Imf::ROUND_DOWN || tiles.tileXSize() != TextureTile::kSide ||
                tiles.tileYSize() != TextureTile::kSide || data.min != Imath::V2i(0, 0) ||
                data.max != Imath::V2i(width_ - 1, height_ - 1))
                throw Error(name_, "the image has changed while the scene was rendered, or is not as occam texture made it");
            open_->input = std::move(input);
        }
        open_->input->tiles.setFrameBuffer(buffer_of(tile));
        open_->input->tiles.readTile(column, row, level);
        if (files_open > kMostOpen) open_->input.reset();
        return tile;
    } catch (const Iex::BaseExc& error) {
        open_->input.reset();
        throw Error(name_, "a tile of the image cannot be read", error.what());
    }
}

}  // namespace occam
