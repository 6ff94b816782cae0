// The settings of a picture that are one value: one row for each.
//
// To add a setting, add its member to Settings (render/settings.h) and its row to kSettings. Statistics, checks, options
// with their help, and the table in docs/settings.md are made from the rows; a test compares the last one. Settings of
// several values are listed in render/json.cpp, in check() and in command/parse.cpp.
#pragma once

#include <array>
#include <iosfwd>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "render/settings.h"

namespace occam::render {

/// Names a value of a setting that is a choice.
template <class E>
struct Choice {
    E value;
    std::string_view name;
};
/// Return the choices of a type, in the order in which they are listed.
constexpr auto choices_of(IntegratorKind) noexcept
{
    return std::to_array<Choice<IntegratorKind>>(
        {{IntegratorKind::Direct, "direct"}, {IntegratorKind::Ao, "ao"}, {IntegratorKind::Path, "path"}});
}
constexpr auto choices_of(Lod) noexcept
{
    return std::to_array<Choice<Lod>>({{Lod::On, "on"}, {Lod::Off, "off"}, {Lod::Frozen, "frozen"}});
}
constexpr auto choices_of(ShadeAt) noexcept
{
    return std::to_array<Choice<ShadeAt>>({{ShadeAt::Vertex, "vertex"}, {ShadeAt::Hit, "hit"}});
}
constexpr auto choices_of(shade::Sky) noexcept
{
    return std::to_array<Choice<shade::Sky>>({{shade::Sky::Auto, "auto"}, {shade::Sky::On, "on"}, {shade::Sky::Off, "off"}});
}
constexpr auto choices_of(FilterKind) noexcept
{
    std::array<Choice<FilterKind>, std::size(kFilters)> all{};
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = {kFilters[k].kind, kFilters[k].name};
    return all;
}
constexpr auto choices_of(View) noexcept
{
    std::array<Choice<View>, std::size(kViews) + 1> all{{{View::Beauty, "beauty"}}};
    for (std::size_t k = 0; k < std::size(kViews); ++k) all[k + 1] = {kViews[k].view, kViews[k].name};
    return all;
}
/// Returns the name of a choice.
template <class E>
constexpr std::string_view name_of(E value) noexcept
{
    for (const Choice<E>& choice : choices_of(value))
        if (choice.value == value) return choice.name;
    return {};
}

/// Names the member of Settings that a row is about.
using SettingMember = std::variant<bool Settings::*, int Settings::*, std::uint64_t Settings::*, float Settings::*,
                                   double Settings::*, FilterKind Settings::*, IntegratorKind Settings::*, Lod Settings::*,
                                   ShadeAt Settings::*, View Settings::*, shade::Sky Settings::*>;

struct SettingRow {
    std::string_view name;  ///< in statistics; the option has - for _
    SettingMember member;
    /// The range of a number, ends included. A number is always finite.
    double least = 0, most = std::numeric_limits<double>::max();
    std::string_view unit{};     ///< of the range, as in "from 0 to 16 pixels"
    std::string_view help{};     ///< of the option; empty: no option of its own sets it
    std::string_view initial{};  ///< what the help says of the default where its value does not tell
};

inline constexpr double kBelowOne = 1 - 0x1p-24;  ///< the largest float below 1
inline constexpr double kMostSeconds = 1e9;       ///< thirty years, which clocks can add to any moment

inline constexpr SettingRow kSettings[] = {
    {"spp", &Settings::spp, 1, kMaxSamples, "", "Samples a pixel"},
    {"jitter", &Settings::jitter, 0, 1, "", "off: every sample through the middle of its pixel"},
    {"light_samples", &Settings::light_samples, 1, kMaxLightSamples, "", "Samples of each light at each hit"},
    {"filter", &Settings::filter, 0, 0, "", "Reconstruction filter"},
    {"filter_radius", &Settings::filter_radius, 0, 16, "pixels", "Half the filter's width, pixels", "depends on the filter"},
    {"error", &Settings::error, 0, kBelowOne, "",
     "End pixels whose estimated relative error is below this, at the latest after --spp samples", "never"},
    {"min_spp", &Settings::min_spp, 2, kMaxSamples, "", "Samples a pixel after which --error may end it for the first time"},
    {"shading_rate", &Settings::shading_rate, 1.0 / 64, 1024, "pixels", "Target edge length of micropolygons, pixels"},
    {"lod", &Settings::lod, 0, 0, "",
     "Level of detail. on: for each ray; off: one for each cage; frozen: secondary rays keep that of their origin"},
    {"seed", &Settings::seed, 0, 0x1p64, "", "Seed of the random numbers"},
    {"deadline", &Settings::deadline_s, 0, kMostSeconds, "seconds",
     "Stop after this many seconds; all pixels then have about equally many samples", "none"},
    {"progressive", &Settings::progressive},
    {"background", &Settings::background, 0, 1, "", "Sky or environment behind the scene; off: transparent"},
    {"back_faces", &Settings::back_faces, 0, 1, "", "off: rays pass the backs of single-sided surfaces"},
    {"view", &Settings::view, 0, 0, "", "A debug picture instead of light"},
    {"integrator", &Settings::integrator, 0, 0, "", "How light is computed"},
    {"bounces", &Settings::bounces, 0, kMaxBounces, "",
     "Largest number of times that light is scattered; direct: of mirrors in a row"},
    {"clamp", &Settings::clamp},
    {"clamp_as_shown", &Settings::clamp_as_shown},
    {"ao_distance", &Settings::ao_distance, 0, std::numeric_limits<float>::max(), "world length",
     "Length of the rays of ao, world length", "infinite"},
    {"shade", &Settings::shade_at, 0, 0, "",
     "Where materials are looked up: once at the vertices of grids, or at every hit"},
    {"sky", &Settings::sky},
    {"sky_strength", &Settings::sky_strength},
    {"strict", &Settings::strict},
};

/// Returns the name of the option, without dashes before it.
std::string option_of(const SettingRow& row);
/// Returns "from 1 to 65536", "0 or more" and the like, or nothing for a setting that is no number.
std::string range_of(const SettingRow& row);
/// Returns the value of a setting as text: integers exactly, and other numbers with nine digits.
std::string text_of(const SettingRow& row, const Settings& settings);
/// Returns what the help says of the default.
std::string default_of(const SettingRow& row);

/// Writes the size, and the settings of one value that are not as usual.
std::ostream& operator<<(std::ostream& out, const Settings& settings);

}  // namespace occam::render
