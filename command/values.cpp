#include "values.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "base/number_in.h"

namespace occam::command {

void expected(const std::string& what, std::string_view text)
{
    throw std::invalid_argument("expected " + what + ", not '" + std::string(text) + "'");
}

double real_of(std::string_view text)
{
    const auto value = number_in<double>(text);
    if (!value || !std::isfinite(*value)) expected("a number", text);
    return *value;
}

double number_of(std::string_view text)
{
    const double value = real_of(text);
    if (std::fabs(value) > double(std::numeric_limits<float>::max())) expected("a number between -3.4e38 and 3.4e38", text);
    return value;
}

int corners_of(std::string_view text)
{
    const auto corners = static_cast<int>(whole_of(text, 0, 64));
    if (corners == 1 || corners == 2) expected("0, or from 3 to 64", text);
    return corners;
}

std::optional<float> stops_of(std::string_view text)
{
    if (text == "auto") return std::nullopt;
    constexpr double kMost = 100;  // the brightest and the faintest light differ by fewer stops
    const double stops = number_of(text);
    if (!(std::fabs(stops) <= kMost)) expected("from -100 to 100 stops, or auto", text);
    return static_cast<float>(stops);
}

std::uint64_t whole_of(std::string_view text, std::uint64_t least, std::uint64_t most)
{
    auto value = number_in<std::uint64_t>(text);
    if (!value) {  // with an exponent or a point; doubles below 2^53 hold whole numbers exactly
        const auto real = number_in<double>(text);
        if (real && *real >= 0 && *real <= 0x1p53 && *real == std::floor(*real)) value = static_cast<std::uint64_t>(*real);
    }
    if (!value || *value < least || *value > most)
        expected("a whole number from " + std::to_string(least) + " to " + std::to_string(most), text);
    return *value;
}

std::vector<std::string_view> words_of(std::string_view text)
{
    std::vector<std::string_view> words;
    std::string_view rest = text;
    while (true) {
        const std::size_t comma = rest.find(',');
        words.push_back(rest.substr(0, comma));
        if (words.back().empty()) expected("words with commas between", text);
        if (comma == std::string_view::npos) return words;
        rest.remove_prefix(comma + 1);
    }
}

std::vector<double> numbers_of(std::string_view text, std::size_t n)
{
    const auto words = words_of(text);
    if (words.size() != n) expected(std::to_string(n) + " numbers with commas between", text);
    std::vector<double> numbers;
    for (std::string_view word : words) numbers.push_back(number_of(word));
    return numbers;
}

Vec3d axis_of(std::string_view text)
{
    if (text == "x") return {1, 0, 0};
    if (text == "y") return {0, 1, 0};
    if (text == "z") return {0, 0, 1};
    if (text.find(',') == std::string_view::npos) expected("x, y, z or three numbers with commas between", text);
    const auto n = numbers_of(text, 3);
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) expected("a direction", text);
    return {n[0], n[1], n[2]};
}

std::pair<int, int> size_of(std::string_view text)
{
    const std::size_t x = text.find('x');
    if (x == std::string_view::npos) expected("a size like 1280x720", text);
    const auto side = [&](std::string_view digits) {
        const auto value = number_in<int>(digits);
        if (!value || *value < 1) expected("a size like 1280x720", text);
        return *value;
    };
    return {side(text.substr(0, x)), side(text.substr(x + 1))};
}

std::size_t bytes_of(std::string_view text)
{
    if (text.empty()) expected("a size like 512M or 2G", text);
    double scale = 1;
    std::string_view digits = text;
    switch (text.back()) {
        case 'k':
        case 'K':
            scale = 1024.0;
            break;
        case 'm':
        case 'M':
            scale = 1024.0 * 1024;
            break;
        case 'g':
        case 'G':
            scale = 1024.0 * 1024 * 1024;
            break;
        case 't':
        case 'T':
            scale = 1024.0 * 1024 * 1024 * 1024;
            break;
        default:
            break;
    }
    if (scale > 1) digits.remove_suffix(1);
    const auto value = number_in<double>(digits);
    if (!value || !(*value * scale >= 1) || !(*value * scale < 0x1p62)) expected("a size like 512M or 2G", text);
    return static_cast<std::size_t>(*value * scale);
}

bool is_on(std::string_view text)
{
    if (text == "on") return true;
    if (text != "off") expected("on or off", text);
    return false;
}

}  // namespace occam::command
