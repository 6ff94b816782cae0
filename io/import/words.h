// The lines of a text file and the words of a line, as the statements of OBJ and MTL need them.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/number_in.h"

namespace occam::import {

/// Goes through the lines of a text. They end with LF, CR LF or CR alone, as tinyobjloader reads them.
class TextLines {
public:
    explicit TextLines(std::string_view text) : text_(text), lf_(text, '\n'), cr_(text, '\r') {}

    /// Returns false after the last line.
    bool next()
    {
        begin_ = after_;
        return extend();
    }
    /// Adds the next line to this one. Returns false if there is none.
    bool extend()
    {
        if (after_ >= text_.size()) return false;
        end_ = std::min(lf_.from(after_), cr_.from(after_));
        after_ = std::min(end_ + (text_.substr(end_).starts_with("\r\n") ? 2 : 1), text_.size());
        ++number_;
        return true;
    }
    std::size_t begin() const noexcept { return begin_; }
    std::size_t end() const noexcept { return end_; }      ///< without the line's end
    std::size_t after() const noexcept { return after_; }  ///< the begin of the next line
    std::size_t number() const noexcept { return number_; }
    std::string_view line() const { return text_.substr(begin_, end_ - begin_); }

    /// Finds a character at or after places that only grow. The last place is kept, so that a text which lacks the character
    /// is searched once.
    class PlaceOf {
    public:
        PlaceOf(std::string_view text, char c) : text_(text), c_(c) { find(0); }
        std::size_t from(std::size_t begin)
        {
            if (place_ < begin) find(begin);
            return place_;
        }

    private:
        void find(std::size_t begin) { place_ = std::min(text_.find(c_, begin), text_.size()); }
        std::string_view text_;
        char c_;
        std::size_t place_ = 0;
    };

private:
    std::string_view text_;
    PlaceOf lf_, cr_;
    std::size_t begin_ = 0, end_ = 0, after_ = 0, number_ = 0;
};

inline bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\r'; }

/// Returns the line without its comment, which begins with a # after a blank or at the begin, and without the blanks at its
/// end.
inline std::string_view without_comment(std::string_view line)
{
    for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1))
        if (at == 0 || is_blank(line[at - 1])) line = line.substr(0, at);
    return line.substr(0, line.find_last_not_of(" \t\r") + 1);
}

/// Returns the word as a number; none if it is something else, or not finite.
inline std::optional<double> finite_number(std::string_view word)
{
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto value = number_in<double>(word);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// Takes words from the begin of a line.
class Words {
public:
    explicit Words(std::string_view line) : rest_(line.substr(0, line.find_last_not_of(" \t\r") + 1)) {}

    /// Returns an empty word at the end.
    std::string_view next()
    {
        const std::size_t begin = rest_.find_first_not_of(" \t\r");
        if (begin == std::string_view::npos) return {};
        const std::size_t end = std::min(rest_.find_first_of(" \t\r", begin), rest_.size());
        const std::string_view word = rest_.substr(begin, end - begin);
        rest_.remove_prefix(end);
        return word;
    }
    template <class T>
    std::optional<T> number()
    {
        return number_in<T>(next());
    }
    /// Returns what is left, without the blanks around it.
    std::string_view rest() const
    {
        const std::size_t begin = rest_.find_first_not_of(" \t\r");
        if (begin == std::string_view::npos) return {};
        return rest_.substr(begin);
    }

private:
    std::string_view rest_;  ///< without the blanks at its end, which would be searched again and again
};

}  // namespace occam::import
