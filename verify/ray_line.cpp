#include "verify/ray_line.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "base/error_without_file.h"
#include "base/number_in.h"
#include "base/print.h"

namespace occam {
namespace {

constexpr double kFarthestLevel = 100;  // beyond all levels

[[noreturn]] void refuse(const std::string& what) { throw error_without_file(what, "ray"); }

double number_of(std::string_view word)
{
    const auto value = number_in<double>(word);
    if (!value || !std::isfinite(*value)) refuse(std::string(word).append(" is no number"));
    return *value;
}

std::vector<std::string_view> words_of(std::string_view text)
{
    constexpr std::string_view kBetween = " ,\t\n\r";
    std::vector<std::string_view> words;
    for (std::size_t at = text.find_first_not_of(kBetween); at < text.size(); at = text.find_first_not_of(kBetween, at)) {
        const std::size_t end = std::min(text.find_first_of(kBetween, at), text.size());
        words.push_back(text.substr(at, end - at));
        at = end;
    }
    return words;
}

}  // namespace

std::string RayLine::text() const
{
    std::ostringstream out;
    const Precision digits(out, 17);
    if (cage > 0) out << "cage " << cage << ", ";
    out << "origin " << origin.x << ' ' << origin.y << ' ' << origin.z << ", direction " << direction.x << ' ' << direction.y
        << ' ' << direction.z << ", footprint " << width << ' ' << spread;
    if (time > 0) out << ", time " << time;
    if (level) out << ", level " << *level;
    return out.str();
}

RayLine read_ray_line(std::string_view text)
{
    RayLine line;
    bool has_origin = false, has_direction = false, has_footprint = false;
    const std::vector<std::string_view> words = words_of(text);
    std::size_t at = 0;
    const auto next = [&](std::string_view name) {
        if (at == words.size()) refuse(std::string("a number is missing after ").append(name));
        return number_of(words[at++]);
    };
    while (at < words.size()) {
        const std::string_view name = words[at++];
        if (name == "origin") {
            for (int a = 0; a < 3; ++a) line.origin[a] = next(name);
            has_origin = true;
        } else if (name == "direction") {
            for (int a = 0; a < 3; ++a) line.direction[a] = static_cast<float>(next(name));
            has_direction = true;
        } else if (name == "footprint") {
            line.width = next(name);
            line.spread = static_cast<float>(next(name));
            has_footprint = true;
        } else if (name == "time") {
            line.time = static_cast<float>(next(name));
        } else if (name == "level") {
            const double level = next(name);
            if (!(std::fabs(level) <= kFarthestLevel && level == std::floor(level)))
                refuse("a level is a small whole number");
            line.level = static_cast<int>(level);
        } else if (name == "cage") {
            const double number = next(name);
            if (!(number >= 0 && number < 1e9 && number == std::floor(number))) refuse("a cage has a whole number");
            line.cage = static_cast<std::size_t>(number);
        } else {
            refuse(std::string("the line of a ray has no ").append(name));
        }
    }
    if (!has_origin || !has_direction || !has_footprint) refuse("a line has origin X Y Z, direction X Y Z, footprint A B");
    const float length = glm::length(line.direction);
    if (!(std::fabs(length - 1) < 1e-3f)) refuse("the direction has no unit length");
    // A width that shrinks is one of a focused lens, so the spread alone may be negative.
    if (!(line.width > 0 || (line.width == 0 && line.spread >= 0))) refuse("the footprint has no width");
    if (!(line.time >= 0 && line.time <= 1)) refuse("the time is not from 0 to 1");
    return line;
}

}  // namespace occam
