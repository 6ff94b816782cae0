#include "io/texture/texture_store.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <thread>

#include "base/error.h"
#include "base/maths.h"
#include "io/texture/decode.h"
#include "scenegraph/scene.h"

namespace occam {

namespace {

// What stands for a texture that cannot be read: magenta and black squares.
MipImage stand_in()
{
    constexpr int kSide = 32, kSquare = 4;
    MipImage image(kSide, kSide);
    std::vector<Vec4f> row(kSide);
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x)
            row[static_cast<std::size_t>(x)] = (x / kSquare + y / kSquare) % 2 ? Vec4f(0, 0, 0, 1) : Vec4f(1, 0, 1, 1);
        image.write_row(y, row);
    }
    image.build_levels();
    return image;
}

struct Entry {
    std::shared_ptr<const MipImage> image;
    std::string warning;  // why it is the stand-in, or that it was made smaller
};

// One texture on its way in.
struct Pending {
    std::uint64_t identity = 0;
    std::string name;
    std::optional<TextureSource> source;
    int halvings = 0;
    Entry entry;

    std::size_t bytes() const
    {
        return source
                   ? MipImage::bytes_of(std::max(1, source->width() >> halvings), std::max(1, source->height() >> halvings))
                   : 0;
    }
    void decode()
    {
        if (!source) return;
        try {
            entry.image = std::make_shared<const MipImage>(source->decode(halvings));
            if (halvings > 0)
                entry.warning = name + ": halved " + std::to_string(halvings) + " times to fit the texture memory";
        } catch (const std::exception& error) {
            entry.warning = error.what();
        }
        source.reset();
    }
};

// The largest ones are halved until all fit. Sizes alone decide, so the outcome is the same for any number of threads.
void fit(std::vector<Pending>& pending, std::size_t bytes)
{
    std::size_t sum = 0;
    for (const Pending& p : pending) sum += p.bytes();
    while (sum > bytes) {
        const auto largest = std::max_element(pending.begin(), pending.end(),
                                              [](const Pending& a, const Pending& b) { return a.bytes() < b.bytes(); });
        const std::size_t before = largest->bytes();
        ++largest->halvings;
        if (largest->bytes() == before) return;  // a single tile each: nothing is left to give
        sum -= before - largest->bytes();
    }
}

}  // namespace

struct TextureStore::State {
    explicit State(std::size_t cap) : cap_bytes(cap), unreadable(std::make_shared<const MipImage>(stand_in())) {}

    struct Slot {
        std::uint32_t generation = 0;
        const MipImage* image = nullptr;
    };
    std::size_t cap_bytes;
    std::shared_ptr<const MipImage> unreadable;
    std::map<std::uint64_t, Entry> entries;  // by identity
    std::vector<Slot> slots;                 // by TextureId
};

TextureStore::TextureStore(std::size_t cap_bytes) : state_(std::make_unique<State>(cap_bytes)) {}
TextureStore::~TextureStore() = default;

void TextureStore::prepare(const Scene& scene)
{
    std::map<std::uint64_t, Entry> entries;
    std::vector<Pending> pending;
    std::size_t kept_bytes = 0;
    const std::vector<TextureId> ids = scene.texture_ids();
    for (TextureId id : ids) {
        const Texture& texture = scene.texture(id);
        if (const auto known = state_->entries.find(texture.identity); known != state_->entries.end()) {
            kept_bytes += known->second.image->bytes();
            entries.insert(*known);
            continue;
        }
        Pending& p = pending.emplace_back();
        p.identity = texture.identity;
        p.name = texture.name;
        try {
            p.source.emplace(texture);
        } catch (const std::exception& error) {
            p.entry.warning = error.what();
        }
    }
    fit(pending, state_->cap_bytes - std::min(state_->cap_bytes, kept_bytes));

    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t i; (i = next.fetch_add(1)) < pending.size();) pending[i].decode();
    };
    {
        std::vector<std::jthread> workers;
        const std::size_t threads = std::min<std::size_t>(pending.size(), std::thread::hardware_concurrency());
        for (std::size_t t = 1; t < threads; ++t) workers.emplace_back(work);
        work();
    }
    for (Pending& p : pending) {
        if (!p.entry.image) p.entry.image = state_->unreadable;
        entries.emplace(p.identity, std::move(p.entry));
    }
    state_->entries = std::move(entries);
    state_->slots.clear();
    for (TextureId id : ids) {
        if (id.slot >= state_->slots.size()) state_->slots.resize(id.slot + 1);
        state_->slots[id.slot] = {id.generation, state_->entries.at(scene.texture(id).identity).image.get()};
    }
}

const MipImage* TextureStore::image(TextureId id) const noexcept
{
    if (id.slot >= state_->slots.size()) return nullptr;
    const State::Slot& slot = state_->slots[id.slot];
    return slot.generation == id.generation ? slot.image : nullptr;
}

float TextureStore::texel_width(const TextureUse& use) const noexcept
{
    const MipImage* found = image(use.texture);
    const float repeats = std::max(std::abs(use.scale.x), std::abs(use.scale.y));
    return found && repeats > 0 ? 1 / (repeats * static_cast<float>(std::max(found->width(), found->height()))) : 0;
}

Vec4f TextureStore::sample(const TextureUse& use, Vec2f uv, float width) const noexcept
{
    const MipImage* found = image(use.texture);
    if (!found) return Vec4f(1);

    // KHR_texture_transform: scale, then rotate, then move.
    Vec2f st = uv * use.scale;
    if (use.rotation != 0) {
        const float s = maths::sin(use.rotation), c = maths::cos(use.rotation);
        st = Vec2f(c * st.x + s * st.y, c * st.y - s * st.x);
    }
    st += use.offset;
    if (!std::isfinite(st.x)) st.x = 0;
    if (!std::isfinite(st.y)) st.y = 0;

    const MipImage& image = *found;
    const auto at = [&](int level, bool nearest) { return image.lookup(level, st, use.wrap_s, use.wrap_t, nearest); };
    const float texels = width * std::max(std::abs(use.scale.x), std::abs(use.scale.y)) *
                         static_cast<float>(std::max(image.width(), image.height()));
    if (!(texels > 1)) return at(0, use.nearest);
    const int last = image.level_count() - 1;
    // Between two levels by width, not by its logarithm: the same at both ends, and no slower than the lookups.
    const auto bits = std::bit_cast<std::uint32_t>(texels);
    const int finer = static_cast<int>(bits >> 23) - 127;
    if (finer >= last) return at(last, false);
    const float share = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u) - 1;
    return at(finer, false) * (1 - share) + at(finer + 1, false) * share;
}

std::size_t TextureStore::bytes() const noexcept
{
    std::size_t sum = 0;
    for (const auto& [identity, entry] : state_->entries)
        if (entry.image != state_->unreadable) sum += entry.image->bytes();
    return sum;
}

std::vector<std::string> TextureStore::warnings() const
{
    std::vector<std::string> lines;
    for (const auto& [identity, entry] : state_->entries)
        if (!entry.warning.empty()) lines.push_back(entry.warning);
    return lines;
}

}  // namespace occam
