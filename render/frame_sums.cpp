#include "render/frame_sums.h"

#include <algorithm>
#include <cstring>

#include "base/error_without_file.h"
#include "base/hash.h"
#include "render/stats.h"
#include "render/version.h"

namespace occam::render {
namespace {

constexpr std::string_view kMagic = "Occam checkpoint 5\n";

std::size_t tile_count(const PixelRect& area)
{
    const auto tiles = [](int side) { return static_cast<std::size_t>((side + kTileSide - 1) / kTileSide); };
    return tiles(area.width()) * tiles(area.height());
}

// Returns a hash of the settings and the camera, without those settings that do not change the finished picture: the
// deadline, whether the frame is made in rounds, and the least number of samples where no pixel ends early.
std::uint64_t identity_of(Settings settings, const Camera& camera)
{
    settings.deadline_s = 0;
    settings.progressive = false;
    if (!(settings.error > 0)) settings.min_spp = Settings().min_spp;
    const auto add = [](const auto& value, std::uint64_t h) { return fnv1a(&value, sizeof value, h); };
    const std::string text = std::string(kVersion) + to_json(settings);
    std::uint64_t h = fnv1a(text.data(), text.size());
    for (const Camera* c : {&camera, settings.lod_camera ? &*settings.lod_camera : &camera}) {
        h = add(c->world_from_camera, h);
        for (const Mat4d& key : c->keys) h = add(key, h);
        const CameraLens& lens = c->lens;
        for (const float value :
             {lens.fov, lens.aspect, lens.height, lens.radius, lens.focus, float(lens.blades), float(lens.orthographic)})
            h = add(value, h);
    }
    return h;
}

[[noreturn]] void refuse(const std::string& why) { throw error_without_file(std::string(kTheCheckpoint) + why); }

class Writer {
public:
    template <class T>
    void add(const T& value)
    {
        add_bytes(&value, sizeof value);
    }
    void add_bytes(const void* bytes, std::size_t size) { text_.append(static_cast<const char*>(bytes), size); }
    std::string finish() &&
    {
        add(fnv1a(text_.data(), text_.size()));
        return std::move(text_);
    }

private:
    std::string text_;
};

class Reader {
public:
    explicit Reader(std::string_view text) : text_(text) {}
    template <class T>
    T next()
    {
        T value;
        read_bytes(&value, sizeof value);
        return value;
    }
    void read_bytes(void* to, std::size_t size)
    {
        if (text_.size() < size) refuse("is cut off");
        std::memcpy(to, text_.data(), size);
        text_.remove_prefix(size);
    }
    bool is_at_end() const { return text_.empty(); }

private:
    std::string_view text_;
};

}  // namespace

FrameSums::FrameSums(const Settings& settings, const Camera& camera)
    : aovs_(settings.aovs),
      area_(crop_pixels(settings)),
      columns_(static_cast<std::size_t>((area_.width() + kTileSide - 1) / kTileSide)),
      spp_(settings.spp),
      identity_(identity_of(settings, camera)),
      stride_(PixelSums::packed_bytes(settings.aovs)),
      tiles_(tile_count(area_)),
      sums_(first_pixel(tiles_.size()) * stride_)
{
    for (int k : {0, 1})
        if (settings.has(kMattes[k])) mattes_[k].resize(first_pixel(tiles_.size()));
}

std::size_t FrameSums::bytes_for(const Settings& settings) noexcept
{
    const std::size_t pixels = tile_count(crop_pixels(settings)) * std::size_t(kTileSide * kTileSide);
    std::size_t mattes = 0;
    for (const Aov aov : kMattes) mattes += settings.has(aov) ? sizeof(MatteSums) : 0;
    return pixels * (PixelSums::packed_bytes(settings.aovs) + mattes);
}

std::size_t FrameSums::index_of(const PixelRect& rect) const noexcept
{
    return static_cast<std::size_t>((rect.y0 - area_.y0) / kTileSide) * columns_ +
           static_cast<std::size_t>((rect.x0 - area_.x0) / kTileSide);
}

void FrameSums::load(const PixelRect& rect, std::vector<PixelSums>& sums, std::vector<MatteSums> (&mattes)[2]) const
{
    const std::size_t count = static_cast<std::size_t>(rect.width() * rect.height()), index = index_of(rect);
    const std::size_t first = first_pixel(index);
    const bool is_empty = tiles_[index].samples == 0;  // the bits of sums without a sample are not all zero
    for (std::size_t i = 0; i < count; ++i)
        if (PixelSums& pixel = sums.emplace_back(); !is_empty) pixel.unpack(aovs_, sums_.data() + (first + i) * stride_);
    for (int k : {0, 1})
        if (!mattes_[k].empty())
            mattes[k].insert(mattes[k].end(), mattes_[k].begin() + std::ptrdiff_t(first),
                             mattes_[k].begin() + std::ptrdiff_t(first + count));
}

void FrameSums::store(const PixelRect& rect, Tile tile, std::span<const PixelSums> sums,
                      const std::vector<MatteSums> (&mattes)[2], std::size_t first)
{
    const std::size_t count = static_cast<std::size_t>(rect.width() * rect.height()), index = index_of(rect);
    tiles_[index] = tile;
    std::byte* to = sums_.data() + first_pixel(index) * stride_;
    for (std::size_t i = 0; i < count; ++i, to += stride_) sums[first + i].pack(aovs_, to);
    for (int k : {0, 1})
        if (!mattes_[k].empty())
            std::copy_n(mattes[k].begin() + std::ptrdiff_t(first), count,
                        mattes_[k].begin() + std::ptrdiff_t(first_pixel(index)));
}

int FrameSums::least_samples() const noexcept
{
    int least = spp_;
    for (const Tile& tile : tiles_)
        if (!tile.is_done) least = std::min(least, tile.samples);
    return least;
}

std::string FrameSums::checkpoint(std::uint64_t scene_hash) const
{
    Writer out;
    out.add_bytes(kMagic.data(), kMagic.size());
    out.add(identity_);
    out.add(scene_hash);
    out.add_bytes(tiles_.data(), tiles_.size() * sizeof(Tile));
    out.add_bytes(sums_.data(), sums_.size());
    for (const std::vector<MatteSums>& mattes : mattes_)
        for (const MatteSums& pixel : mattes) {
            out.add(static_cast<std::uint32_t>(pixel.shares().size()));
            for (const MatteSums::Share& share : pixel.shares()) {
                out.add(share.id);
                out.add(share.mass);
                out.add(share.coverage);
            }
        }
    return std::move(out).finish();
}

void FrameSums::restore(std::string_view checkpoint, std::uint64_t scene_hash)
{
    if (!checkpoint.starts_with(kMagic)) refuse("was not made by this version");
    std::uint64_t sum = 0;
    if (checkpoint.size() < kMagic.size() + sizeof sum) refuse("is cut off");
    std::memcpy(&sum, checkpoint.data() + checkpoint.size() - sizeof sum, sizeof sum);
    checkpoint.remove_suffix(sizeof sum);
    if (fnv1a(checkpoint.data(), checkpoint.size()) != sum) refuse("is cut off or damaged");

    Reader in(checkpoint.substr(kMagic.size()));
    if (in.next<std::uint64_t>() != identity_) refuse("belongs to a picture with other settings or another camera");
    if (in.next<std::uint64_t>() != scene_hash)
        refuse("belongs to a picture of another scene, of an edited one, or with textures made smaller for other memory");
    in.read_bytes(tiles_.data(), tiles_.size() * sizeof(Tile));
    for (const Tile& tile : tiles_)
        if (tile.samples < 0 || tile.samples > spp_ || (tile.is_done && tile.samples == 0))
            refuse("holds impossible numbers of samples");
    in.read_bytes(sums_.data(), sums_.size());
    for (std::vector<MatteSums>& mattes : mattes_)
        for (MatteSums& pixel : mattes)
            for (std::uint32_t left = in.next<std::uint32_t>(); left > 0; --left) {
                const auto id = in.next<float>();
                const auto mass = in.next<float>();
                if (!pixel.restore({id, mass, in.next<double>()})) refuse("holds too many names of a pixel");
            }
    if (!in.is_at_end()) refuse("is longer than this picture's");
}

}  // namespace occam::render
