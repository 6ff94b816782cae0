// Numbers in texts of any origin.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace occam {

/// Returns the number that a text is; none if it is more or less than that, or if T does not hold it. Doubles may be nan or
/// inf.
template <class T>
std::optional<T> number_in(std::string_view text) noexcept
{
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace occam
