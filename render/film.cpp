#include "render/film.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <type_traits>

namespace occam::render {
namespace {

struct LayerForm {
    std::vector<std::string> channels;
    bool full_float;
};

LayerForm form_of(Aov aov)
{
    switch (aov) {
        case Aov::Depth:
            return {{"Z"}, true};
        case Aov::Normal:
        case Aov::NormalGeometric:
            return {{"X", "Y", "Z"}, false};
        case Aov::Albedo:
            return {{"R", "G", "B", "A"}, false};
        case Aov::Uv:
            return {{"U", "V"}, true};
        case Aov::Position:
            return {{"X", "Y", "Z"}, true};
        case Aov::Id:
            return {{"I"}, true};
        case Aov::Variance:
            return {{"Y"}, true};
        case Aov::Occlusion:
            return {{"Y"}, false};
        case Aov::NormalMean:
            return {{"X", "Y", "Z"}, false};
        case Aov::CryptomatteObject:
        case Aov::CryptomatteMaterial:
            return {{"R", "G", "B", "A"}, true};
    }
    return {};
}

std::size_t index_of(Aov aov) noexcept { return static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(aov))); }

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
    const double y = (0.2126 * radiance.x + 0.7152 * radiance.y + 0.0722 * radiance.z) * weight;
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
void PixelSums::visit_packed(Sums& sums, unsigned aovs, Visit&& visit)
{
    const auto has_any = [&](std::initializer_list<Aov> wanted) {
        return std::any_of(wanted.begin(), wanted.end(), [&](Aov aov) { return (aovs & static_cast<unsigned>(aov)) != 0; });
    };
    visit(sums.beauty_), visit(sums.luminance_), visit(sums.luminance2_), visit(sums.weight_);
    visit(sums.count_), visit(sums.not_finite_);
    if (has_any({Aov::Albedo})) visit(sums.albedo_);
    if (has_any({Aov::NormalMean})) visit(sums.normal_);
    if (has_any({Aov::Occlusion})) visit(sums.occlusion_);
    if (has_any({Aov::Depth, Aov::Normal, Aov::NormalGeometric, Aov::Uv, Aov::Position, Aov::Id}))
        visit(sums.nearest_), visit(sums.first_);
}

std::size_t PixelSums::packed_bytes(unsigned aovs) noexcept
{
    std::size_t bytes = 0;
    const PixelSums sums;
    visit_packed(sums, aovs, [&](const auto& value) { bytes += sizeof value; });
    return bytes;
}

void PixelSums::pack(unsigned aovs, std::byte* to) const noexcept
{
    visit_packed(*this, aovs, [&](const auto& value) {
        std::memcpy(to, &value, sizeof value);
        to += sizeof value;
    });
}

void PixelSums::unpack(unsigned aovs, const std::byte* from) noexcept
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

float PixelSums::variance() const noexcept
{
    if (count_ < 2 || !(weight_ > 0)) return 0;
    const double n = count_;
    const double of_mean = std::max(0.0, (luminance2_ - luminance_ * luminance_ / n) / (n - 1) / n);
    return static_cast<float>(of_mean * (n / weight_) * (n / weight_));
}

float PixelSums::relative_error() const noexcept
{
    if (count_ < 2 || !(weight_ > 0)) return std::numeric_limits<float>::infinity();
    return std::sqrt(variance()) / std::max(static_cast<float>(luminance_ / weight_), kDarkest);
}

Film::Film(const Settings& settings)
    : settings_(settings), rect_(crop_pixels(settings)), image_(rect_.width(), rect_.height())
{
    image_.x0 = rect_.x0;
    image_.y0 = rect_.y0;
    image_.full_width = settings.width;
    image_.full_height = settings.height;
    image_.add_layer("beauty", {"R", "G", "B", "A"});
    for (Aov aov : kAllAovs) {
        if (!settings.has(aov)) continue;
        LayerForm form = form_of(aov);
        layer_of_[index_of(aov)] = image_.layers().size();
        if (const std::string_view matte = matte_layer(aov); !matte.empty()) {
            for (int n = 0; n < kMatteLayers; ++n)
                image_.add_layer(std::string(matte) + "0" + std::to_string(n), form.channels, form.full_float);
            continue;
        }
        Layer& layer = image_.add_layer(std::string(aov_name(aov)), std::move(form.channels), form.full_float);
        // A pixel that was never reached is a miss.
        if (aov == Aov::Depth) std::fill(layer.pixels.begin(), layer.pixels.end(), std::numeric_limits<float>::infinity());
    }
}

void Film::put(Aov aov, std::size_t pixel, const float* values, std::size_t count) noexcept
{
    if (!settings_.has(aov)) return;
    std::copy_n(values, count, image_.layer(layer_of_[index_of(aov)]).pixels.begin() + std::ptrdiff_t(pixel * count));
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
    const FirstSurface& first = sums.first();
    const Vec4f albedo = sums.albedo();
    const float variance = sums.variance();
    put(Aov::Depth, pixel, &first.depth, 1);
    put(Aov::Normal, pixel, &first.normal.x, 3);
    put(Aov::NormalGeometric, pixel, &first.normal_geometric.x, 3);
    put(Aov::Albedo, pixel, &albedo.x, 4);
    put(Aov::Uv, pixel, &first.uv.x, 2);
    put(Aov::Position, pixel, &first.position.x, 3);
    put(Aov::Id, pixel, &first.id, 1);
    put(Aov::Variance, pixel, &variance, 1);
    const Vec3f normal = sums.normal();
    put(Aov::NormalMean, pixel, &normal.x, 3);
    const float occlusion = sums.occlusion();
    put(Aov::Occlusion, pixel, &occlusion, 1);
}

std::size_t Film::bytes() const noexcept
{
    std::size_t floats = 0;
    for (const Layer& layer : image_.layers()) floats += layer.pixels.size();
    return floats * sizeof(float);
}

}  // namespace occam::render
