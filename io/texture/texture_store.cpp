#include "io/texture/texture_store.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "base/cancellation.h"
#include "base/error_without_file.h"
#include "base/hash.h"
#include "base/maths.h"
#include "base/processors.h"
#include "base/threads.h"
#include "io/texture/decode_budget.h"
#include "io/texture/texture_entry.h"
#include "io/texture/tile_cache.h"
#include "scenegraph/scene.h"

namespace occam {

namespace {

const Vec4f kGrey(0.5f, 0.5f, 0.5f, 1.0f);

// Returns the replacement of a texture that is missing or cannot be read: grey, which as a normal map changes nothing.
MipImage stand_in()
{
    MipImage image(1, 1);
    image.write_row(0, {&kGrey, 1});
    image.build_levels();
    return image;
}

// Says how all textures are kept, and how many bytes are left for tiles.
struct Plan {
    std::vector<TextureKeeping> keepings;
    std::size_t tile_bytes = 0;
};

// Plans the memory of the textures: tiled files are read in tiles, unless their colours are weighted by alpha, which those
// of the tiles are not. If the others do not fit beside a quarter for these, or beside all of these, the largest are halved
// until they do. Sizes alone decide, so the outcome depends neither on which textures are looked up, nor on the number of
// threads, nor on what earlier frames knew.
Plan plan_for(const std::vector<std::shared_ptr<TextureEntry>>& entries, const std::vector<bool>& are_weighted,
              std::size_t bytes)
{
    Plan plan{std::vector<TextureKeeping>(entries.size())};
    std::vector<std::size_t> planned;
    std::size_t sum = 0, in_tiles = 0;
    for (const auto& entry : entries) sum += planned.emplace_back(entry->bytes_of(0));
    for (std::size_t i = 0; i < entries.size(); ++i) {
        plan.keepings[i].is_weighted = are_weighted[i];
        if (!entries[i]->is_tiled_file() || are_weighted[i]) continue;
        plan.keepings[i].is_in_tiles = true;
        in_tiles += std::exchange(planned[i], 0);
    }
    sum -= in_tiles;
    const std::size_t most = bytes - std::min(in_tiles, bytes / 4);
    while (sum > most) {
        const auto largest = std::max_element(planned.begin(), planned.end());
        const auto i = static_cast<std::size_t>(largest - planned.begin());
        const std::size_t halved = entries[i]->bytes_of(plan.keepings[i].halvings + 1);
        if (halved == *largest) break;  // each texture is a single tile, so nothing more can be saved
        ++plan.keepings[i].halvings;
        sum -= *largest - halved;
        *largest = halved;
    }
    plan.tile_bytes = bytes - std::min(sum, bytes);
    return plan;
}

// Looks up an image that is kept in tiles. Where a tile cannot be read it is grey, and the entry knows why.
class ImageInTiles {
public:
    ImageInTiles(TiledFile& file, TileCache& cache, TextureEntry& entry) noexcept : file_(file), cache_(cache), entry_(entry)
    {
    }

    int width() const noexcept { return file_.width(); }
    int height() const noexcept { return file_.height(); }
    int level_count() const noexcept { return file_.level_count(); }
    Vec4f lookup(int level, Vec2f st, TextureUse::Wrap wrap_s, TextureUse::Wrap wrap_t, bool nearest) const noexcept
    {
        if (entry_.is_broken()) return kGrey;
        try {
            return cache_.lookup(file_, level, st, wrap_s, wrap_t, nearest);
        } catch (const std::exception& error) {
            entry_.fail(error);
            return kGrey;
        }
    }

private:
    TiledFile& file_;
    TileCache& cache_;
    TextureEntry& entry_;
};

// Returns how many texels of the finest level a filter spans. One texel for the whole image, or for the whole surface, does
// not vary along its axis, which then has no say.
// width   in units of the image
template <class Image>
float texels_in(Vec2f width, const Image& image) noexcept
{
    const float x = width.x * static_cast<float>(image.width()), y = width.y * static_cast<float>(image.height());
    if (x == y || image.height() == 1 || !(y > 0)) return x;
    return image.width() == 1 || !(x > 0) ? y : std::sqrt(x * y);
}

// Returns the width of a filter along either side of an image, after the use's transform. A rotation leaves the mean of both
// as it is, so it counts only where one side alone has a say.
template <class Image>
Vec2f transformed(Vec2f width, const TextureUse& use, const Image& image) noexcept
{
    const Vec2f scaled = width * glm::abs(use.scale);
    if (use.rotation == 0 || (image.width() > 1 && image.height() > 1)) return scaled;
    const float s = maths::sin(use.rotation), c = maths::cos(use.rotation);
    return {std::hypot(c * scaled.x, s * scaled.y), std::hypot(c * scaled.y, s * scaled.x)};
}

// Returns the filtered texel of an image at coordinates by the use's transform.
// width   of the filter, before that transform
template <class Image>
Vec4f filtered(const Image& image, const TextureUse& use, Vec2f st, Vec2f width) noexcept
{
    const auto at = [&](int level, bool nearest) { return image.lookup(level, st, use.wrap_s, use.wrap_t, nearest); };
    const float texels = texels_in(transformed(width, use, image), image);
    if (!(texels > 1)) return at(0, use.nearest);
    const int last = image.level_count() - 1;
    // Two levels are blended by the width and not by its logarithm. Both agree at the ends, and a logarithm would make the
    // lookup slower.
    const auto bits = std::bit_cast<std::uint32_t>(texels);
    const int finer = static_cast<int>(bits >> 23) - 127;
    if (finer >= last) return at(last, false);
    const float share = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u) - 1;
    return at(finer, false) * (1 - share) + at(finer + 1, false) * share;
}

template <class Image>
bool has_one_texel_in(const Image& image)
{
    const auto texel = [&](int x, int y) {
        const Vec2f st((float(x) + 0.5f) / float(image.width()), (float(y) + 0.5f) / float(image.height()));
        return image.lookup(0, st, TextureUse::Wrap::Clamp, TextureUse::Wrap::Clamp, true);
    };
    const Vec4f first = texel(0, 0);
    for (int y = 0; y < image.height(); ++y) {
        throw_if_cancelled();
        for (int x = 0; x < image.width(); ++x)
            if (texel(x, y) != first) return false;
    }
    return true;
}

// Refuses images that would take minutes to decode though their files are small: each of them may be within its limits.
void check_decoding(const std::vector<TextureEntry*>& entries)
{
    std::uintmax_t decoded = 0, bytes = 0;
    for (const TextureEntry* entry : entries) {
        decoded += entry->bytes_to_decode();
        bytes += entry->file_bytes();
    }
    if (DecodeBudget::allows_bytes(decoded, bytes)) return;
    throw error_without_file("the images hold " + std::to_string(decoded >> 20) +
                             " MB of texels, though their files have only " + std::to_string((bytes >> 10) + 1) +
                             " KB: beyond " + std::to_string(DecodeBudget::kAlwaysAllowedBytes >> 20) + " MB, at most " +
                             std::to_string(DecodeBudget::kMostBytesPerByte) + " bytes for each byte are decoded");
}

}  // namespace

struct TextureStore::State {
    explicit State(std::size_t cap) : cap_bytes(cap), unreadable(stand_in()) {}

    struct Slot {
        std::uint32_t generation = 0;
        TextureEntry* entry = nullptr;
    };
    TextureEntry* find(TextureId id) const noexcept
    {
        if (id.slot >= slots.size()) return nullptr;
        const Slot& slot = slots[id.slot];
        return slot.generation == id.generation ? slot.entry : nullptr;
    }

    std::size_t cap_bytes;
    MipImage unreadable;
    std::atomic<bool> has_failed = false;                            ///< a texture of the scene could not be read
    std::map<std::uint64_t, std::shared_ptr<TextureEntry>> entries;  // by identity
    std::vector<Slot> slots;                                         // by TextureId
    TileCache tiles{0};                                              // of the entries that are kept in tiles

    // Entries that were forgotten, or never kept, do not count.
    void count_failures()
    {
        has_failed = std::any_of(entries.begin(), entries.end(), [](const auto& e) { return e.second->has_failed(); });
    }
};

TextureStore::TextureStore(std::size_t cap_bytes) : state_(std::make_unique<State>(cap_bytes)) {}
TextureStore::~TextureStore() = default;

void TextureStore::prepare(const Scene& scene)
{
    // The store changes at the end only: it stays as it was if an image is refused or there is not enough memory.
    const std::vector<TextureId> ids = scene.texture_ids();
    std::vector<std::shared_ptr<TextureEntry>> all;
    std::vector<bool> is_fresh, are_weighted;
    std::vector<TextureEntry*> fresh;
    bool is_weighting_known = true;
    DecodeBudget budget;
    for (const TextureId id : ids) {
        const Texture& texture = scene.texture(id);
        const auto known = state_->entries.find(texture.identity);
        is_fresh.push_back(known == state_->entries.end() || known->second->has_failed());
        all.push_back(is_fresh.back() ? std::make_shared<TextureEntry>(scene.share(id), state_->has_failed, budget)
                                      : known->second);
        if (is_fresh.back()) fresh.push_back(all.back().get());
        are_weighted.push_back(all.back()->has_alpha() && scene.is_cut_out_by(id));
        is_weighting_known &= all.back()->keeping().is_weighted == are_weighted.back();
    }
    // The textures may be those of the frame before, and used in the same way.
    if (fresh.empty() && is_weighting_known && ids.size() == state_->entries.size()) return state_->count_failures();
    check_decoding(fresh);
    const Plan plan = plan_for(all, are_weighted, state_->cap_bytes);
    std::map<std::uint64_t, std::shared_ptr<TextureEntry>> entries;
    std::vector<State::Slot> slots;
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const Texture& texture = scene.texture(ids[i]);
        std::shared_ptr<TextureEntry>& entry = all[i];
        if (entry->keeping() != plan.keepings[i]) {
            if (!is_fresh[i]) entry = std::make_shared<TextureEntry>(scene.share(ids[i]), state_->has_failed, budget);
            entry->keep(plan.keepings[i]);
        }
        entries[texture.identity] = entry;
        if (ids[i].slot >= slots.size()) slots.resize(ids[i].slot + 1);
        slots[ids[i].slot] = {ids[i].generation, entry.get()};
    }
    state_->entries.swap(entries);
    state_->slots.swap(slots);
    state_->tiles.set_limit(plan.tile_bytes);
    state_->count_failures();
}

void TextureStore::clear() noexcept
{
    state_->has_failed = false;
    state_->slots.clear();
    state_->entries.clear();
    state_->tiles.set_limit(0);
}

void TextureStore::decode_all()
{
    std::vector<TextureEntry*> all;
    for (const auto& [identity, entry] : state_->entries) all.push_back(entry.get());
    std::atomic<std::size_t> next{0};
    const auto work = [&](int) {
        for (std::size_t i; (i = next.fetch_add(1)) < all.size();)
            if (all[i]->tiles()) all[i]->check_tiles();
            else all[i]->image(state_->unreadable);
    };
    run_in_threads(static_cast<int>(std::min<std::size_t>(all.size(), std::size_t(processor_count()))), work);
}

float TextureStore::texel_width(const TextureUse& use) const noexcept
{
    const TextureEntry* found = state_->find(use.texture);
    if (!found) return 0;
    const int side = found->is_readable() ? std::max(found->width(), found->height()) : state_->unreadable.width();
    const float repeats = std::max(std::abs(use.scale.x), std::abs(use.scale.y));
    return repeats > 0 ? 1 / (repeats * static_cast<float>(side)) : 0;
}

bool TextureStore::has_one_texel(const TextureUse& use) const
{
    TextureEntry* const found = state_->find(use.texture);
    if (!found) return true;
    if (TiledFile* const tiles = found->tiles()) return has_one_texel_in(ImageInTiles(*tiles, state_->tiles, *found));
    return has_one_texel_in(found->image(state_->unreadable));
}

Vec3f TextureStore::brightest(const TextureUse& use) const noexcept
{
    const TextureEntry* found = state_->find(use.texture);
    return found ? found->brightest() : Vec3f(1);
}

std::uint64_t TextureStore::identity(const TextureUse& use) const noexcept
{
    const TextureEntry* found = state_->find(use.texture);
    return found ? found->identity() : 0;
}

Vec2f scaled_and_rotated(const TextureUse& use, Vec2f uv) noexcept
{
    const Vec2f st = uv * use.scale;
    if (use.rotation == 0) return st;
    const float s = maths::sin(use.rotation), c = maths::cos(use.rotation);
    return {c * st.x + s * st.y, c * st.y - s * st.x};
}

Vec4f TextureStore::sample(const TextureUse& use, Vec2f uv, Vec2f width) const noexcept
{
    TextureEntry* found = state_->find(use.texture);
    if (!found) return Vec4f(1);

    Vec2f st = scaled_and_rotated(use, uv) + use.offset;
    if (!std::isfinite(st.x)) st.x = 0;
    if (!std::isfinite(st.y)) st.y = 0;

    if (TiledFile* const tiles = found->tiles())
        return filtered(ImageInTiles(*tiles, state_->tiles, *found), use, st, width);
    Vec4f texel = filtered(found->image(state_->unreadable), use, st, width);
    if (found->keeping().is_weighted && texel.w > 0) texel = Vec4f(Vec3f(texel) / texel.w, texel.w);
    return texel;
}

std::uint64_t TextureStore::halvings_hash() const noexcept
{
    std::uint64_t hash = 0, place = 0;
    for (const auto& [identity, entry] : state_->entries) {
        ++place;
        const int halvings = entry->keeping().halvings;
        if (halvings > 0) hash = mix_bits(mix_bits(hash ^ place) ^ std::uint64_t(halvings));
    }
    return hash;
}

std::size_t TextureStore::bytes() const noexcept
{
    std::size_t sum = state_->tiles.bytes();
    for (const auto& [identity, entry] : state_->entries) sum += entry->decoded_bytes();
    return sum;
}

double TextureStore::decode_seconds() const noexcept
{
    double sum = state_->tiles.read_seconds();
    for (const auto& [identity, entry] : state_->entries) sum += entry->decode_seconds();
    return sum;
}

std::vector<std::string> TextureStore::warnings() const
{
    std::vector<std::string> lines;
    for (const auto& [identity, entry] : state_->entries)
        for (std::string& line : entry->warnings()) lines.push_back(std::move(line));
    return lines;
}

bool TextureStore::has_failed() const noexcept { return state_->has_failed; }

std::vector<std::string> TextureStore::errors() const
{
    std::vector<std::string> lines;
    for (const auto& [identity, entry] : state_->entries)
        for (std::string& line : entry->errors()) lines.push_back(std::move(line));
    return lines;
}

void TextureStore::throw_if_failed() const
{
    if (!has_failed()) return;
    if (const std::vector<std::string> lines = errors(); !lines.empty()) throw error_without_file(lines.front());
}

}  // namespace occam
