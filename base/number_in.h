// Numbers in texts of any origin.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <optional>
#include <string_view>

namespace occam {

/// Returns whether a decimal number that std::from_chars takes is out of range because it is too small, not too large.
inline bool is_too_small(std::string_view number) noexcept
{
    const std::size_t e = std::min(number.find_first_of("eE"), number.size());
    const std::string_view mantissa = number.substr(0, e);
    const std::size_t first = mantissa.find_first_of("123456789"), point = std::min(mantissa.find('.'), mantissa.size());
    if (first == std::string_view::npos) return true;
    const bool has_sign = e + 1 < number.size() && (number[e + 1] == '+' || number[e + 1] == '-');
    const bool is_negative = has_sign && number[e + 1] == '-';
    long long exponent = 0;
    const char* digits = number.data() + std::min(e + (has_sign ? 2 : 1), number.size());
    if (std::from_chars(digits, number.data() + number.size(), exponent).ec == std::errc::result_out_of_range)
        return is_negative;
    exponent = std::min(exponent, 1LL << 60);  // no text is so long, so the sum below neither overflows nor changes its sign
    const auto places = static_cast<long long>(point) - static_cast<long long>(first);
    return (is_negative ? -exponent : exponent) + places < 0;
}

/// Reads a number as std::from_chars does, but one that is too small for a real T is 0, with its sign.
template <class T>
std::from_chars_result read_number(const char* begin, const char* end, T& value) noexcept
{
    std::from_chars_result result = std::from_chars(begin, end, value);
    if constexpr (std::floating_point<T>) {
        const std::string_view number(begin, static_cast<std::size_t>(result.ptr - begin));
        if (result.ec == std::errc::result_out_of_range && is_too_small(number)) {
            value = std::copysign(T(0), *begin == '-' ? T(-1) : T(1));
            result.ec = std::errc();
        }
    }
    return result;
}

/// Returns the number that a text is; none if it is more or less than that, or if it is too large for T. Doubles may be nan
/// or inf, and are 0 where the number is too small.
template <class T>
std::optional<T> number_in(std::string_view text) noexcept
{
    T value{};
    const auto [end, error] = read_number(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace occam
