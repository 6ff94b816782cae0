#include "io/texture/texture_entry.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/stopwatch.h"
#include "io/texture/decode.h"

namespace occam {
namespace {

std::string name_of(const Texture& texture)
{
    if (!texture.name.empty()) return texture.name;
    return texture.path.empty() ? "a texture without a name" : texture.path.string();
}

}  // namespace

TextureEntry::TextureEntry(std::shared_ptr<const Texture> shared, std::atomic<bool>& has_failed, DecodeBudget& budget)
    : source_(std::move(shared)),
      name_(name_of(*source_)),
      identity_(source_->identity),
      role_(source_->role),
      has_failed_(has_failed)
{
    const Texture& texture = *source_;
    std::error_code ignored;
    if (!texture.encoded && texture.pixels.empty() && !std::filesystem::is_regular_file(texture.path, ignored)) {
        warnings_.push_back(name_ + ": there is no such image file: it is grey");
        return;
    }
    try {
        const TextureSource source(texture, &budget);
        width_ = source.width();
        height_ = source.height();
        is_tiled_file_ = source.is_tiled_file();
        has_alpha_ = source.has_alpha();
        if (source.has_texels_of_another_role())
            warnings_.push_back(name_ + (role_ == TextureRole::Data
                                             ? ": it was made for colours (occam texture without --data)"
                                             : ": it was not made for colours (occam texture --data)"));
        if (texture.encoded) file_bytes_ = texture.encoded->size();
        else if (texture.pixels.empty()) file_bytes_ = std::filesystem::file_size(texture.path, ignored);
        bytes_to_decode_ = is_tiled_file_ ? std::uintmax_t(width_) * std::uintmax_t(height_) : source.bytes_to_decode();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        add_error(error);
    }
}

std::size_t TextureEntry::bytes_of(int halvings) const
{
    return width_ > 0 ? MipImage::bytes_of(std::max(1, width_ >> halvings), std::max(1, height_ >> halvings)) : 0;
}

void TextureEntry::keep(TextureKeeping how)
{
    keeping_ = how;
    const bool is_file = !source_->encoded && source_->pixels.empty();
    if (how.is_in_tiles) tiles_ = std::make_unique<TiledFile>(source_->path, name_, width_, height_);
    if (how.halvings > 0)
        warnings_.push_back(name_ + ": halved " + std::to_string(how.halvings) + (how.halvings == 1 ? " time" : " times") +
                            " to fit the texture memory" +
                            (is_file ? "; a file that occam texture makes of it is not halved" : ""));
}

void TextureEntry::check_tiles() noexcept
{
    try {
        tiles_->check();
    } catch (const std::exception& error) {
        fail(error);
    }
}

void TextureEntry::fail(const std::exception& error) noexcept
{
    const std::lock_guard lock(decoding_);
    if (is_broken_) return;
    add_error(error);
    is_broken_ = true;  // from here on others see grey, and the failure is known by then
}

const MipImage& TextureEntry::image(const MipImage& unreadable)
{
    if (const MipImage* known = ready_.load(std::memory_order_acquire)) return *known;
    const std::lock_guard lock(decoding_);
    if (!ready_.load(std::memory_order_relaxed)) {
        decode();
        ready_.store(decoded_ ? decoded_.get() : &unreadable, std::memory_order_release);
    }
    return *ready_.load(std::memory_order_relaxed);
}

void TextureEntry::decode()
{
    if (width_ == 0) return;
    const auto start = Clock::now();
    try {
        const TextureSource source(*source_);
        if (source.width() != width_ || source.height() != height_)
            throw Error(name_, "the image has changed while the scene was rendered");
        decoded_ = std::make_unique<const MipImage>(source.decode(keeping_.halvings, keeping_.is_weighted));
        source_.reset();
        if (const std::size_t texels = decoded_->clamped_texels())
            warnings_.push_back(
                name_ + ": texels that are not finite numbers, or above 65504, were clamped: " + std::to_string(texels));
        const bool is_color = role_ == TextureRole::Color;
        if (const std::size_t texels = decoded_->texels_below_0(); is_color && texels > 0)
            warnings_.push_back(name_ + ": texels with a colour below 0, which counts as 0: " + std::to_string(texels));
    } catch (const std::bad_alloc&) {
        lacks_memory_ = true;  // a line for it would need memory, too
        has_failed_ = true;
    } catch (const std::exception& error) {
        add_error(error);
    }
    decode_seconds_ = seconds_since(start);
}

void TextureEntry::add_error(const std::exception& error) noexcept
{
    has_failed_ = true;
    lacks_memory_ |= dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    if (lacks_memory_) return;
    try {
        // What a library throws names no file.
        const bool is_named = dynamic_cast<const Error*>(&error) != nullptr;
        errors_.push_back(is_named ? error.what() : Error(name_, "image cannot be read", error.what()).what());
    } catch (const std::bad_alloc&) {
        lacks_memory_ = true;
    }
}

}  // namespace occam
