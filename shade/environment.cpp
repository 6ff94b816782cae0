#include "shade/environment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/cancellation.h"
#include "base/luminance.h"
#include "base/prefetch.h"
#include "shade/frame_of.h"
#include "shade/input_limits.h"

namespace occam::shade {
namespace {

// An image is even if the mean square of its luminance is at most this many times the square of its mean. Directions that
// are scattered by surfaces then find its light with so little noise that samples of the image take as much time as they
// save. At 1.9 they save a quarter of the time in some scenes and nothing in others, at 3.7 a third to a half.
constexpr double kEven = 1.5;

constexpr int kColumns = 512, kRows = 256;
constexpr double kLeastShare = 0.05;  // the darkest cells are sampled as if they had this share of the mean
const Vec2f kCell(1.0f / kColumns, 1.0f / kRows);

// Returns the density per solid angle of directions in a cell.
// row, column   chances of the cell's row, and of the cell in it
// ring          sine of the angle to the pole
float density_of(float row, float column, float ring) noexcept
{
    return row * column * float(kColumns * kRows) / (2 * kPi * kPi * std::max(1e-6f, ring));
}

struct Cell {
    int row, column;
};
Cell cell_at(Vec2f uv) noexcept
{
    return {std::clamp(int(uv.y * kRows), 0, kRows - 1), std::clamp(int(uv.x * kColumns), 0, kColumns - 1)};
}

// Returns the luminance by which a colour counts in the tables.
float brightness_of(Vec3f c) noexcept { return std::min(luminance(c), 1e6f); }

// Returns the sine of a direction's angle to the pole.
float ring_of(Vec3f direction) noexcept { return std::sqrt(std::max(0.0f, 1 - direction.y * direction.y)); }

constexpr Vec3f kZenith{0.36f, 0.45f, 0.60f}, kHorizon{0.60f, 0.62f, 0.64f}, kGround{0.36f, 0.37f, 0.385f};

Vec3f sky_radiance(float y) noexcept
{
    if (y >= 0) {
        const float down = 1 - std::min(y, 1.0f);
        return glm::mix(kZenith, kHorizon, down * down * down);
    }
    const float t = std::min(1.0f, -y * 6);
    return glm::mix(kHorizon, kGround, t * t * (3 - 2 * t));
}

// Returns how many places across a cell the texels of an image ask for: 1 if they are no finer than the cell.
int places_across(const TextureStore& textures, const TextureUse& image) noexcept
{
    constexpr float kMostPlaces = 8;
    const float width = textures.texel_width(image);
    return width > 0 ? static_cast<int>(std::clamp(std::ceil(kCell.x / width), 1.0f, kMostPlaces)) : 1;
}

// Returns whether lamps within the cells of an image whose cells are even make it worth sampling: the noise of scattered
// directions follows the mean square of the luminance at all places, and that of samples of the cells divides each of these
// squares by how much brighter than all the cell is. A fine pattern that is the same everywhere gains nothing.
// cell_at   returns the mean luminance of a cell
template <class CellAt>
bool has_lamps_within_cells(const TextureStore& textures, const TextureUse& image, double mean, CellAt&& cell_at)
{
    const int places = places_across(textures, image);
    if (places == 1 || !(mean > 0)) return false;
    double scattered = 0, sampled = 0;
    for (int row = 0; row < kRows; ++row) {
        throw_if_cancelled();
        const double ring = double(maths::sin((float(row) + 0.5f) * kPi / kRows));
        for (int column = 0; column < kColumns; ++column) {
            double squares = 0;
            for (int k = 0; k < places * places; ++k) {
                const Vec2f within(float(k % places) + 0.5f, float(k / places) + 0.5f);
                const Vec2f uv = (Vec2f(float(column), float(row)) + within / float(places)) * kCell;
                const double y = double(
                    brightness_of(glm::max(Vec3f(textures.sample(image, uv, kCell / float(places))), Vec3f(0))));
                squares += y * y;
            }
            scattered += squares * ring;
            sampled += squares * ring * mean / std::max(double(cell_at(row, column)), kLeastShare * mean);
        }
    }
    return scattered > kEven * sampled;
}

}  // namespace

// Says how the light of an image is spread over the sphere.
struct Environment::Spread {
    Vec3f darkest{std::numeric_limits<float>::infinity()}, brightest{0};  // in each channel
    double area = 0, sum = 0, sum_of_squares = 0;                         // of luminances, by solid angle

    void add(Vec3f color, float luminance, float solid_angle) noexcept
    {
        darkest = glm::min(darkest, color);
        brightest = glm::max(brightest, color);
        area += double(solid_angle);
        sum += double(luminance) * double(solid_angle);
        sum_of_squares += double(luminance) * double(luminance) * double(solid_angle);
    }
    bool is_one_color() const noexcept { return darkest == brightest; }
    bool is_even() const noexcept { return sum_of_squares * area <= kEven * sum * sum; }
    double mean() const noexcept { return area > 0 ? sum / area : 0; }
};

// Holds the index of the interval of rising `sums` that contains u, u's place in it, and the size of the interval.
struct Environment::Interval {
    int index;
    float within, share;
};

Vec2f Environment::uv_at(const Interval& row, const Interval& column) noexcept
{
    return {(float(column.index) + column.within) / kColumns, (float(row.index) + row.within) / kRows};
}

// The number of sums is a power of two, so that no product is rounded.
const Environment::Sum& Environment::guide_of(std::span<const Sum> sums, float u) noexcept
{
    return sums[std::min(static_cast<std::size_t>(u * float(sums.size())), sums.size() - 1)];
}

Environment::Interval Environment::find_interval(std::span<const Sum> sums, float u) noexcept
{
    const std::size_t last = sums.size() - 1;
    std::size_t index = guide_of(sums, u).guide;
    while (index < last && !(u < sums[index].upto)) ++index;
    const float below = index ? sums[index - 1].upto : 0, share = sums[index].upto - below;
    return {static_cast<int>(index), share > 0 ? std::clamp((u - below) / share, 0.0f, 0.9999999f) : 0.5f, share};
}

void Environment::fill_guides(std::span<Sum> sums) noexcept
{
    std::size_t index = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        while (index + 1 < sums.size() && !(float(i) / float(sums.size()) < sums[index].upto)) ++index;
        sums[i].guide = static_cast<std::uint16_t>(index);
    }
}

float Environment::share_of(std::span<const Sum> sums, int index) noexcept
{
    return sums[std::size_t(index)].upto - (index ? sums[std::size_t(index) - 1].upto : 0);
}

// Replaces weights by their running sums, divided so that the last one is exactly 1. Returns the sum of the weights.
float Environment::accumulate(std::span<Sum> weights) noexcept
{
    double sum = 0;
    for (const Sum& w : weights) sum += double(w.upto);
    double running = 0;
    for (Sum& w : weights) {
        running += double(w.upto);
        w.upto = sum > 0 ? float(running / sum) : 0;
    }
    weights.back().upto = 1;
    return float(sum);
}

Environment::Environment(const occam::Environment& description, const TextureStore& textures, Kept* kept)
    : scale_(limited(description.radiance)), textures_(&textures)
{
    if (scale_ == Vec3f(0)) return;
    kind_ = Kind::Constant;
    if (!description.image) return;
    kind_ = Kind::Image;
    image_.texture = description.image;
    image_.wrap_t = TextureUse::Wrap::Clamp;
    rotation_sin_ = maths::sin(description.rotation);
    rotation_cos_ = maths::cos(description.rotation);
    const bool is_known = kept && *kept && (*kept)->image == textures.identity(image_) &&
                          (*kept)->texel_width == textures.texel_width(image_);
    const Kept table = is_known ? *kept : tabulate();
    if (kept) *kept = table;
    take(table);
}

void Environment::take(Kept table) noexcept
{
    if (table->is_one_color) {
        kind_ = Kind::Constant;
        scale_ = limited(scale_ * table->darkest);
    }
    rows_ = table->rows;
    cells_ = table->cells;
    table_ = std::move(table);
}

Environment Environment::sky(float strength)
{
    Environment e;
    e.kind_ = strength > 0 ? Kind::Sky : Kind::None;
    e.scale_ = limited(Vec3f(strength));
    return e;
}

Vec3f Environment::radiance(Vec3f direction) const noexcept
{
    switch (kind_) {
        case Kind::None:
            return Vec3f(0);
        case Kind::Constant:
            return scale_;
        case Kind::Sky:
            return scale_ * sky_radiance(direction.y);
        case Kind::Image:
            break;
    }
    return texel(uv_of(direction));
}

Vec3f Environment::texel(Vec2f uv) const noexcept { return limited(scale_ * Vec3f(textures_->sample(image_, uv, 0))); }

// Rotates a direction back about +y.
Vec3f Environment::in_axes_of_image(Vec3f d) const noexcept
{
    return {rotation_cos_ * d.x - rotation_sin_ * d.z, d.y, rotation_sin_ * d.x + rotation_cos_ * d.z};
}

Vec2f Environment::uv_of(Vec3f direction) const noexcept
{
    const Vec3f d = in_axes_of_image(direction);
    return {0.5f + maths::atan2(d.x, -d.z) / (2 * kPi), maths::acos(std::clamp(d.y, -1.0f, 1.0f)) / kPi};
}

Vec3f Environment::direction_of(maths::SinCos around, maths::SinCos up) const noexcept
{
    const float x = up.sin * around.sin, z = -up.sin * around.cos;
    return {rotation_cos_ * x + rotation_sin_ * z, up.cos, rotation_cos_ * z - rotation_sin_ * x};
}

float Environment::mean_of_cell(int row, int column) const noexcept
{
    constexpr int kSteps = 8;
    float sum = 0;
    for (int j = 0; j <= kSteps; ++j)
        for (int i = 0; i <= kSteps; ++i) {
            const Vec2f uv((float(column) + float(i) / kSteps) / kColumns, (float(row) + float(j) / kSteps) / kRows);
            const float weight = (i % kSteps == 0 ? 0.5f : 1.0f) * (j % kSteps == 0 ? 0.5f : 1.0f);
            sum += weight * brightness_of(glm::max(Vec3f(textures_->sample(image_, uv, kCell / float(kSteps))), Vec3f(0)));
        }
    return sum / (kSteps * kSteps);
}

// The light of a bright texel at the border of a cell reaches into the next one, since texels are interpolated. The middle
// of that cell may know nothing of it, and samples there would be few and far too bright.
void Environment::add_light_from_beside(std::vector<Sum>& cells, double mean) const
{
    constexpr float kMoreThanOwn = 4, kMoreThanMean = 4;
    struct Refined {
        std::size_t cell;
        float luminance;
    };
    std::vector<Refined> refined;
    const auto at = [](int row, int column) { return std::size_t(row * kColumns + (column + kColumns) % kColumns); };
    for (int row = 0; row < kRows; ++row) {
        throw_if_cancelled();
        for (int column = 0; column < kColumns; ++column) {
            const float own = cells[at(row, column)].upto, least = std::max(kMoreThanOwn * own, kMoreThanMean * float(mean));
            bool is_beside_light = false;
            for (int j = std::max(row - 1, 0); j <= std::min(row + 1, kRows - 1); ++j)
                for (int i = column - 1; i <= column + 1; ++i) is_beside_light |= cells[at(j, i)].upto > least;
            if (is_beside_light) refined.push_back({at(row, column), std::max(own, mean_of_cell(row, column))});
        }
    }
    for (const Refined& r : refined) cells[r.cell].upto = r.luminance;
}

Environment::Kept Environment::tabulate() const
{
    const auto table = std::make_shared<Table>();
    table->image = textures_->identity(image_);
    std::vector<Sum>&rows = table->rows, &cells = table->cells;
    cells.resize(std::size_t(kColumns) * kRows);
    rows.resize(kRows);
    double total = 0;
    Spread spread;
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            const Vec2f uv((float(column) + 0.5f) / kColumns, (float(row) + 0.5f) / kRows);
            const Vec3f c = glm::max(Vec3f(textures_->sample(image_, uv, kCell)), Vec3f(0));
            const float y = brightness_of(c);
            cells[std::size_t(row * kColumns + column)].upto = y;
            total += double(y);
            spread.add(c, y, maths::sin((float(row) + 0.5f) * kPi / kRows));
        }
    table->texel_width = textures_->texel_width(image_);
    table->darkest = spread.darkest;
    const auto cell_at = [&](int row, int column) { return cells[std::size_t(row * kColumns + column)].upto; };
    if (spread.is_even() && !has_lamps_within_cells(*textures_, image_, spread.mean(), cell_at)) {
        cells.clear();
        rows.clear();
        // The means of the cells may be equal whatever lies in them.
        table->is_one_color = spread.is_one_color() && textures_->has_one_texel(image_);
        return table;
    }
    add_light_from_beside(cells, total / (kColumns * kRows));
    // A floor keeps the density above zero where filtering brings light into a black cell.
    const float floor = std::max(float(total / (kColumns * kRows)) * float(kLeastShare), 1e-6f);
    for (int row = 0; row < kRows; ++row) {
        const std::span of_row(cells.data() + row * kColumns, std::size_t(kColumns));
        for (Sum& w : of_row) w.upto += floor;
        rows[std::size_t(row)].upto = accumulate(of_row) * maths::sin((float(row) + 0.5f) * kPi / kRows);
    }
    accumulate(rows);
    fill_guides(rows);
    for (std::size_t first = 0; first < cells.size(); first += kColumns)
        fill_guides(std::span(cells).subspan(first, kColumns));
    return table;
}

std::span<const Environment::Sum> Environment::cells_of(int row) const noexcept
{
    return cells_.subspan(std::size_t(row) * kColumns, kColumns);
}

float Environment::density_at(int row, int column, float ring) const noexcept
{
    return density_of(share_of(rows_, row), share_of(cells_of(row), column), ring);
}

Environment::Light Environment::draw(Vec2f square) const noexcept
{
    Light light;
    draw(std::span(&square, 1), std::span(&light, 1));
    return light;
}

Environment::Light Environment::light_at(Vec3f direction, Vec2f uv) const noexcept
{
    const Cell cell = cell_at(uv);
    return {direction, texel(uv), density_at(cell.row, cell.column, ring_of(direction))};
}

Environment::Light Environment::look_up(Vec3f direction) const noexcept
{
    return has_density() ? light_at(direction, uv_of(direction)) : Light{direction, radiance(direction), 0};
}

void Environment::draw(std::span<const Vec2f> squares, std::span<Light> to) const noexcept
{
    Interval rows[kAtOnce], columns[kAtOnce];
    Vec2f uv[kAtOnce];
    float around[kAtOnce] = {}, up[kAtOnce] = {}, sin_around[kAtOnce], cos_around[kAtOnce], sin_up[kAtOnce], cos_up[kAtOnce];
    const std::size_t count = squares.size();
    for (std::size_t k = 0; k < count; ++k) {
        rows[k] = find_interval(rows_, squares[k].y);
        prefetch(&guide_of(cells_of(rows[k].index), squares[k].x));
    }
    for (std::size_t k = 0; k < count; ++k) {
        const std::span cells = cells_of(rows[k].index);
        prefetch(&cells[guide_of(cells, squares[k].x).guide]);
    }
    for (std::size_t k = 0; k < count; ++k) {
        columns[k] = find_interval(cells_of(rows[k].index), squares[k].x);
        uv[k] = uv_at(rows[k], columns[k]);
        around[k] = (uv[k].x - 0.5f) * 2 * kPi;
        up[k] = uv[k].y * kPi;
    }
    maths::sin_cos(around, count, sin_around, cos_around);
    maths::sin_cos(up, count, sin_up, cos_up);
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3f direction = direction_of({sin_around[k], cos_around[k]}, {sin_up[k], cos_up[k]});
        to[k] = {direction, texel(uv[k]), density_of(rows[k].share, columns[k].share, ring_of(direction))};
    }
}

void Environment::look_up(std::span<const Vec3f> directions, std::span<Light> to) const noexcept
{
    float x[kAtOnce] = {}, y[kAtOnce] = {}, height[kAtOnce] = {}, around[kAtOnce], down[kAtOnce];
    const std::size_t count = directions.size();
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3f in_image = in_axes_of_image(directions[k]);
        y[k] = in_image.x;
        x[k] = -in_image.z;
        height[k] = std::clamp(in_image.y, -1.0f, 1.0f);
    }
    maths::atan2(y, x, count, around);
    maths::acos(height, count, down);
    Vec2f uv[kAtOnce];
    for (std::size_t k = 0; k < count; ++k) {
        uv[k] = {0.5f + around[k] / (2 * kPi), down[k] / kPi};
        const Cell cell = cell_at(uv[k]);
        prefetch(&cells_of(cell.row)[std::size_t(cell.column)]);
    }
    for (std::size_t k = 0; k < count; ++k) to[k] = light_at(directions[k], uv[k]);
}

}  // namespace occam::shade
