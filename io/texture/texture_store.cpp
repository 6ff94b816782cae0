#include "io/texture/texture_store.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "base/error_without_file.h"
#include "base/hash.h"
#include "base/maths.h"
#include "base/stopwatch.h"
#include "io/texture/decode.h"
#include "scenegraph/scene.h"

namespace occam {

namespace {

// Returns the replacement of a texture that is missing or cannot be read: grey, which as a normal map changes nothing.
MipImage stand_in()
{
    MipImage image(1, 1);
    const Vec4f grey(0.5f, 0.5f, 0.5f, 1.0f);
    image.write_row(0, {&grey, 1});
    image.build_levels();
    return image;
}

std::string name_of(const Texture& texture) { return texture.name.empty() ? texture.path.string() : texture.name; }

// Holds one texture that the store knows; it is decoded when it is first asked for.
class Entry {
public:
    /// Opens the image to learn its size. Throws std::bad_alloc alone: a missing texture has a warning and no size, and one
    /// that cannot be opened has an error and no size.
    /// has_failed   is set if the image cannot be read, now or later; it must outlive the entry
    Entry(const Texture& texture, std::atomic<bool>& has_failed) : description_(texture), has_failed_(has_failed)
    {
        std::error_code ignored;
        if (!texture.encoded && texture.pixels.empty() && !std::filesystem::is_regular_file(texture.path, ignored)) {
            warnings_.push_back(name_of(texture) + ": there is no such image file: it is grey");
            return;
        }
        try {
            const TextureSource source(texture);
            width_ = source.width();
            height_ = source.height();
            if (texture.encoded) file_bytes_ = texture.encoded->size();
            else if (texture.pixels.empty()) file_bytes_ = std::filesystem::file_size(texture.path, ignored);
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            add_error(error);
        }
    }

    /// Returns the bytes of the image with all its levels, if it is halved that often; 0 if it cannot be opened.
    std::size_t bytes_of(int halvings) const
    {
        return width_ > 0 ? MipImage::bytes_of(std::max(1, width_ >> halvings), std::max(1, height_ >> halvings)) : 0;
    }
    bool is_readable() const { return width_ > 0; }
    std::uint64_t identity() const { return description_.identity; }
    /// Returns the texels that decoding will visit, and the bytes of the file from which they come; both are 0 for texels
    /// that are in memory.
    std::uintmax_t encoded_texels() const { return file_bytes_ == 0 ? 0 : std::uintmax_t(width_) * std::uintmax_t(height_); }
    std::uintmax_t file_bytes() const { return file_bytes_; }
    int width() const { return std::max(1, width_ >> halvings_); }
    int height() const { return std::max(1, height_ >> halvings_); }
    int halvings() const { return halvings_; }
    /// Halves the size at which the image will be decoded. It may be called once, before the first image().
    void halve(int times)
    {
        halvings_ = times;
        if (times > 0)
            warnings_.push_back(description_.name + ": halved " + std::to_string(times) +
                                " times to fit the texture memory");
    }

    /// Returns the image, and decodes it if this is the first call. Callers from other threads wait for it.
    const MipImage& image(const MipImage& unreadable)
    {
        if (const MipImage* known = ready_.load(std::memory_order_acquire)) return *known;
        const std::lock_guard lock(decoding_);
        if (!ready_.load(std::memory_order_relaxed)) {
            decode();
            ready_.store(decoded_ ? decoded_.get() : &unreadable, std::memory_order_release);
        }
        return *ready_.load(std::memory_order_relaxed);
    }
    std::size_t decoded_bytes() const
    {
        const std::lock_guard lock(decoding_);
        return decoded_ ? decoded_->bytes() : 0;
    }
    double decode_seconds() const
    {
        const std::lock_guard lock(decoding_);
        return decode_seconds_;
    }
    /// Returns whether decoding it has failed for lack of memory. The next frame may have more.
    bool lacks_memory() const
    {
        const std::lock_guard lock(decoding_);
        return lacks_memory_;
    }
    std::vector<std::string> warnings() const
    {
        const std::lock_guard lock(decoding_);
        return warnings_;
    }
    std::vector<std::string> errors() const
    {
        const std::lock_guard lock(decoding_);
        if (lacks_memory_) throw std::bad_alloc();
        return errors_;
    }

private:
    void decode()
    {
        if (width_ == 0) return;
        const auto start = Clock::now();
        try {
            const TextureSource source(description_);
            if (source.width() != width_ || source.height() != height_)
                throw Error(description_.name, "the image has changed while the scene was rendered");
            decoded_ = std::make_unique<const MipImage>(source.decode(halvings_));
            description_.pixels = {};
            if (const std::size_t texels = decoded_->clamped_texels())
                warnings_.push_back(
                    description_.name +
                    ": texels that are not finite numbers, or above 65504, were clamped: " + std::to_string(texels));
        } catch (const std::bad_alloc&) {
            lacks_memory_ = true;  // a line for it would need memory, too
            has_failed_ = true;
        } catch (const std::exception& error) {
            add_error(error);
        }
        decode_seconds_ = seconds_since(start);
    }

    void add_error(const std::exception& error) noexcept
    {
        has_failed_ = true;
        try {
            // What a library throws names no file.
            const bool is_named = dynamic_cast<const Error*>(&error) != nullptr;
            errors_.push_back(is_named ? error.what()
                                       : Error(name_of(description_), "image cannot be read", error.what()).what());
        } catch (const std::bad_alloc&) {
            lacks_memory_ = true;
        }
    }

    std::atomic<const MipImage*> ready_{nullptr};
    Texture description_;
    std::atomic<bool>& has_failed_;
    int width_ = 0, height_ = 0, halvings_ = 0;
    std::uintmax_t file_bytes_ = 0;
    mutable std::mutex decoding_;  // guards the members below
    std::unique_ptr<const MipImage> decoded_;
    std::vector<std::string> warnings_, errors_;
    double decode_seconds_ = 0;
    bool lacks_memory_ = false;
};

// Returns how often each texture is to be halved: the largest are, until all fit together. Sizes alone decide, so the
// outcome depends neither on which textures are looked up, nor on the number of threads, nor on what earlier frames knew.
std::vector<int> halvings_that_fit(const std::vector<std::shared_ptr<Entry>>& entries, std::size_t bytes)
{
    std::vector<int> halvings(entries.size(), 0);
    std::vector<std::size_t> planned;
    std::size_t sum = 0;
    for (const auto& entry : entries) sum += planned.emplace_back(entry->bytes_of(0));
    while (sum > bytes) {
        const auto largest = std::max_element(planned.begin(), planned.end());
        const auto i = static_cast<std::size_t>(largest - planned.begin());
        const std::size_t halved = entries[i]->bytes_of(halvings[i] + 1);
        if (halved == *largest) break;  // each texture is a single tile, so nothing more can be saved
        ++halvings[i];
        sum -= *largest - halved;
        *largest = halved;
    }
    return halvings;
}

// Returns how many texels of the finest level a filter spans. One texel for the whole image, or for the whole surface, does
// not vary along its axis, which then has no say.
// width   in units of the image
float texels_in(Vec2f width, const MipImage& image) noexcept
{
    const float x = width.x * static_cast<float>(image.width()), y = width.y * static_cast<float>(image.height());
    if (x == y || image.height() == 1 || !(y > 0)) return x;
    return image.width() == 1 || !(x > 0) ? y : std::sqrt(x * y);
}

// Refuses images that would take minutes to decode though their files are small: each of them may be within its limits.
void check_texels(const std::vector<Entry*>& entries)
{
    constexpr std::uintmax_t kAlwaysAllowed = std::uintmax_t(1) << 32, kMostPerByte = 512;
    std::uintmax_t texels = 0, bytes = 0;
    for (const Entry* entry : entries) {
        texels += entry->encoded_texels();
        bytes += entry->file_bytes();
    }
    if (texels <= kAlwaysAllowed || texels / kMostPerByte <= bytes) return;
    throw error_without_file("the images hold " + std::to_string(texels >> 20) +
                             " million texels, though their files have only " + std::to_string((bytes >> 10) + 1) +
                             " KB: beyond " + std::to_string(kAlwaysAllowed >> 20) + " million, at most " +
                             std::to_string(kMostPerByte) + " for each byte are decoded");
}

}  // namespace

struct TextureStore::State {
    explicit State(std::size_t cap) : cap_bytes(cap), unreadable(stand_in()) {}

    struct Slot {
        std::uint32_t generation = 0;
        Entry* entry = nullptr;
    };
    Entry* find(TextureId id) const noexcept
    {
        if (id.slot >= slots.size()) return nullptr;
        const Slot& slot = slots[id.slot];
        return slot.generation == id.generation ? slot.entry : nullptr;
    }

    std::size_t cap_bytes;
    MipImage unreadable;
    std::atomic<bool> has_failed = false;  ///< some texture could not be read, perhaps one that is forgotten since
    std::map<std::uint64_t, std::shared_ptr<Entry>> entries;  // by identity
    std::vector<Slot> slots;                                  // by TextureId
};

TextureStore::TextureStore(std::size_t cap_bytes) : state_(std::make_unique<State>(cap_bytes)) {}
TextureStore::~TextureStore() = default;

void TextureStore::prepare(const Scene& scene)
{
    // The store changes at the end only: it stays as it was if an image is refused or there is not enough memory.
    const std::vector<TextureId> ids = scene.texture_ids();
    std::vector<std::shared_ptr<Entry>> all;
    std::vector<bool> is_fresh;
    std::vector<Entry*> fresh;
    for (const TextureId id : ids) {
        const Texture& texture = scene.texture(id);
        const auto known = state_->entries.find(texture.identity);
        is_fresh.push_back(known == state_->entries.end() || known->second->lacks_memory());
        all.push_back(is_fresh.back() ? std::make_shared<Entry>(texture, state_->has_failed) : known->second);
        if (is_fresh.back()) fresh.push_back(all.back().get());
    }
    if (fresh.empty() && ids.size() == state_->entries.size()) return;  // the textures are those of the frame before
    check_texels(fresh);
    const std::vector<int> halvings = halvings_that_fit(all, state_->cap_bytes);
    std::map<std::uint64_t, std::shared_ptr<Entry>> entries;
    std::vector<State::Slot> slots;
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const Texture& texture = scene.texture(ids[i]);
        std::shared_ptr<Entry>& entry = all[i];
        if (entry->halvings() != halvings[i]) {
            if (!is_fresh[i]) entry = std::make_shared<Entry>(texture, state_->has_failed);
            entry->halve(halvings[i]);
        }
        entries[texture.identity] = entry;
        if (ids[i].slot >= slots.size()) slots.resize(ids[i].slot + 1);
        slots[ids[i].slot] = {ids[i].generation, entry.get()};
    }
    state_->entries.swap(entries);
    state_->slots.swap(slots);
}

void TextureStore::clear() noexcept
{
    state_->has_failed = false;
    state_->slots.clear();
    state_->entries.clear();
}

void TextureStore::decode_all()
{
    std::vector<Entry*> all;
    for (const auto& [identity, entry] : state_->entries) all.push_back(entry.get());
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t i; (i = next.fetch_add(1)) < all.size();) all[i]->image(state_->unreadable);
    };
    std::vector<std::jthread> workers;
    const std::size_t threads = std::min<std::size_t>(all.size(), std::thread::hardware_concurrency());
    for (std::size_t t = 1; t < threads; ++t) workers.emplace_back(work);
    work();
}

float TextureStore::texel_width(const TextureUse& use) const noexcept
{
    const Entry* found = state_->find(use.texture);
    if (!found) return 0;
    const int side = found->is_readable() ? std::max(found->width(), found->height()) : state_->unreadable.width();
    const float repeats = std::max(std::abs(use.scale.x), std::abs(use.scale.y));
    return repeats > 0 ? 1 / (repeats * static_cast<float>(side)) : 0;
}

std::uint64_t TextureStore::identity(const TextureUse& use) const noexcept
{
    const Entry* found = state_->find(use.texture);
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
    Entry* found = state_->find(use.texture);
    if (!found) return Vec4f(1);

    Vec2f st = scaled_and_rotated(use, uv) + use.offset;
    if (!std::isfinite(st.x)) st.x = 0;
    if (!std::isfinite(st.y)) st.y = 0;

    const MipImage& image = found->image(state_->unreadable);
    const auto at = [&](int level, bool nearest) { return image.lookup(level, st, use.wrap_s, use.wrap_t, nearest); };
    const float texels = texels_in(width * glm::abs(use.scale), image);
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

std::uint64_t TextureStore::halvings_hash() const noexcept
{
    std::uint64_t hash = 0, place = 0;
    for (const auto& [identity, entry] : state_->entries) {
        ++place;
        if (entry->halvings() > 0) hash = mix_bits(mix_bits(hash ^ place) ^ std::uint64_t(entry->halvings()));
    }
    return hash;
}

std::size_t TextureStore::bytes() const noexcept
{
    std::size_t sum = 0;
    for (const auto& [identity, entry] : state_->entries) sum += entry->decoded_bytes();
    return sum;
}

double TextureStore::decode_seconds() const noexcept
{
    double sum = 0;
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

}  // namespace occam
