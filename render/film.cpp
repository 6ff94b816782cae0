#include "render/film.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "base/luminance.h"

namespace occam::render {
namespace {

std::size_t index_of(Aov aov) noexcept { return static_cast<std::size_t>(aov); }

bool is_finite(Vec3f v) noexcept { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

void PixelSums::add(const SampleResult& sample) noexcept
{
    const bool is_good = is_finite(sample.radiance);
    not_finite_ += !is_good;
    const double weight = double(sample.weight);
    const Vec3d radiance = is_good ? Vec3d(sample.radiance) : Vec3d(0);
    beauty_ += Vec4d(radiance, double(sample.alpha)) * weight;
    if (is_finite(Vec3f(sample.albedo))) albedo_ += Vec4d(sample.albedo) * weight;
    if (is_finite(sample.normal)) normal_ += Vec3d(sample.normal) * weight;
    if (std::isfinite(sample.occlusion)) occlusion_ += double(sample.occlusion) * weight;
    const double y = luminance(radiance);
    luminance_ += y;
    luminance2_ += y * y;
    weight_ += weight;
    ++count_;
    const float distance = glm::dot(sample.offset, sample.offset);
    if (distance < nearest_) {
        nearest_ = distance;
        first_ = sample.first;
    }
}

template <class Sums, class Visit>
void PixelSums::visit_packed(Sums& sums, AovSet aovs, Visit&& visit)
{
    visit(sums.beauty_), visit(sums.luminance_), visit(sums.luminance2_), visit(sums.weight_);
    visit(sums.count_), visit(sums.not_finite_);
    if (aovs.has(Aov::Albedo)) visit(sums.albedo_);
    if (aovs.has(Aov::NormalMean)) visit(sums.normal_);
    if (aovs.has(Aov::Occlusion)) visit(sums.occlusion_);
    if (aovs.has_any(kFirstSurfaceAovs)) visit(sums.nearest_), visit(sums.first_);
}

std::size_t PixelSums::packed_bytes(AovSet aovs) noexcept
{
    std::size_t bytes = 0;
    const PixelSums sums;
    visit_packed(sums, aovs, [&](const auto& value) { bytes += sizeof value; });
    return bytes;
}

void PixelSums::pack(AovSet aovs, std::byte* to) const noexcept
{
    visit_packed(*this, aovs, [&](const auto& value) {
        std::memcpy(to, &value, sizeof value);
        to += sizeof value;
    });
}

void PixelSums::unpack(AovSet aovs, const std::byte* from) noexcept
{
    visit_packed(*this, aovs, [&](auto& value) {
        static_assert(std::is_trivially_copyable_v<std::remove_reference_t<decltype(value)>>);
        std::memcpy(&value, from, sizeof value);
        from += sizeof value;
    });
}

// The weights of a few samples of a filter with negative lobes may add up to 0 or less. Such a pixel stays black.
Vec4f PixelSums::beauty() const noexcept { return weight_ > 0 ? Vec4f(beauty_ / weight_) : Vec4f(0); }
Vec4f PixelSums::albedo() const noexcept { return weight_ > 0 ? Vec4f(albedo_ / weight_) : Vec4f(0); }
Vec3f PixelSums::normal() const noexcept { return weight_ > 0 ? Vec3f(normal_ / weight_) : Vec3f(0); }
float PixelSums::occlusion() const noexcept { return weight_ > 0 ? static_cast<float>(occlusion_ / weight_) : 0; }

void PixelSums::write(Aov aov, float* to) const noexcept
{
    const auto put = [&](const auto& vector) { std::copy_n(&vector.x, vector.length(), to); };
    switch (aov) {
        case Aov::Depth:
            *to = first_.depth;
            break;
        case Aov::Normal:
            put(first_.normal);
            break;
        case Aov::NormalGeometric:
            put(first_.normal_geometric);
            break;
        case Aov::Albedo:
            put(albedo());
            break;
        case Aov::Uv:
            put(first_.uv);
            break;
        case Aov::Position:
            put(first_.position);
            break;
        case Aov::Id:
            *to = first_.id;
            break;
        case Aov::Variance:
            *to = variance();
            break;
        case Aov::NormalMean:
            put(normal());
            break;
        case Aov::CryptomatteObject:
        case Aov::CryptomatteMaterial:
            break;
        case Aov::Occlusion:
            *to = occlusion();
            break;
        case Aov::Motion:
            put(first_.motion);
            break;
    }
}

float PixelSums::variance() const noexcept
{
    if (count_ < 2 || !(weight_ > 0)) return std::numeric_limits<float>::infinity();
    // The mean is one of sums, that of the weighted luminances over that of the weights. To the first order the deviations
    // of the samples from it make its variance; their weights are 1 or -1, so the weights' squares are 1.
    const double n = count_, aside = luminance_ / n - luminance(Vec3d(beauty_)) / weight_;
    const double squares = luminance2_ - luminance_ * luminance_ / n + n * aside * aside;
    return static_cast<float>(std::max(0.0, squares / (n - 1) / n) * (n / weight_) * (n / weight_));
}

float PixelSums::relative_error() const noexcept
{
    const float of_mean = variance();
    if (!std::isfinite(of_mean)) return std::numeric_limits<float>::infinity();
    return std::sqrt(of_mean) / std::max(static_cast<float>(luminance(Vec3d(beauty_)) / weight_), kDarkest);
}

Film::Film(const Settings& settings)
    : settings_(settings), rect_(crop_pixels(settings)), image_(rect_.width(), rect_.height())
{
    image_.x0 = rect_.x0;
    image_.y0 = rect_.y0;
    image_.full_width = settings.width;
    image_.full_height = settings.height;
    image_.add_layer("beauty", {"R", "G", "B", "A"});
    for (const AovRow& row : kAovs) {
        if (!settings.has(row.aov)) continue;
        std::vector<std::string> channels;
        for (const char letter : row.channels) channels.emplace_back(1, letter);
        layer_of_[index_of(row.aov)] = image_.layers().size();
        if (kCryptomattes.has(row.aov)) {
            for (int n = 0; n < kMatteLayers; ++n)
                image_.add_layer(std::string(matte_layer(row.aov)) + "0" + std::to_string(n), channels, row.full_float);
            continue;
        }
        Layer& layer = image_.add_layer(std::string(row.name), std::move(channels), row.full_float);
        std::fill(layer.pixels.begin(), layer.pixels.end(), row.miss);  // a pixel that was never reached is a miss
    }
}

std::size_t Film::pixel_of(int x, int y) const noexcept
{
    return std::size_t(y - rect_.y0) * std::size_t(rect_.width()) + std::size_t(x - rect_.x0);
}

void Film::store(int x, int y, Aov aov, MatteSums& mattes, double weight) noexcept
{
    float ranks[2 * kMatteRanks];
    mattes.rank(weight, ranks);
    const std::size_t first = layer_of_[index_of(aov)];
    for (std::size_t n = 0; n < kMatteLayers; ++n)
        std::copy_n(ranks + 4 * n, 4, image_.layer(first + n).pixels.begin() + std::ptrdiff_t(pixel_of(x, y) * 4));
}

void Film::store(int x, int y, const PixelSums& sums) noexcept
{
    const std::size_t pixel = pixel_of(x, y);
    const Vec4f beauty = sums.beauty();
    std::copy_n(&beauty.x, 4, image_.layer(0).pixels.begin() + std::ptrdiff_t(pixel * 4));
    for (const AovRow& row : kAovs) {
        if (!settings_.has(row.aov) || kCryptomattes.has(row.aov)) continue;
        float values[kMostChannels];
        sums.write(row.aov, values);
        const std::size_t count = row.channels.size();
        std::copy_n(values, count,
                    image_.layer(layer_of_[index_of(row.aov)]).pixels.begin() + std::ptrdiff_t(pixel * count));
    }
}

std::size_t Film::bytes_for(const Settings& settings) noexcept
{
    const PixelRect rect = crop_pixels(settings);
    std::size_t floats = 4;
    for (const AovRow& row : kAovs)
        if (settings.has(row.aov)) floats += row.channels.size() * (kCryptomattes.has(row.aov) ? kMatteLayers : 1);
    return std::size_t(rect.width()) * std::size_t(rect.height()) * floats * sizeof(float);
}

}  // namespace occam::render
