// The statements of an OBJ file as lines, and checks of the numbers in them, which tinyobjloader does not make.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "io/import/words.h"

namespace occam::import {

/// Goes through the statements of a text. In the text itself it makes one line of those that end with a backslash and the
/// ones after them (Wavefront, "Appendix B1": file syntax), and blanks of comments behind a statement. What begins with a
/// name stays as it is: the backslash at the end of a path or a comment is its own, and a name may hold a #.
class ObjLines {
public:
    explicit ObjLines(std::string& text) : text_(text), lines_(text), sign_(text, '#') {}

    /// Returns false after the last statement.
    bool next();
    std::string_view line() const noexcept { return line_; }  ///< without the blanks at its begin
    std::size_t number() const noexcept { return number_; }   ///< of the statement's first line
    /// Returns the place of line() in the text, which may be changed there.
    std::span<char> place() const { return {text_.data() + (line_.data() - text_.data()), line_.size()}; }

private:
    void blank_comment(std::size_t from);

    std::string& text_;
    TextLines lines_;
    TextLines::PlaceOf sign_;  ///< of comments
    std::string_view line_;
    std::size_t number_ = 0;
};

enum class NumberKind { Missing, Finite, NotFinite, Malformed };

/// Takes the first word of `rest` and says what it is where a number is expected. What the runtime library of Microsoft
/// writes for numbers that are not finite, as 1.#IND, counts as such.
NumberKind take_number(std::string_view& rest);

/// Counts the corners of a face. Each is one to three whole numbers with slashes between them, of which the second and the
/// third may be left out. Returns none if a word is something else. Slashes at the end of a corner become blanks:
/// tinyobjloader would look for a number after them, and take the next corner.
std::optional<std::size_t> count_corners(std::span<char> rest);

}  // namespace occam::import
