// The engine's one exception, for bad input. Importers and api/ validate before rendering. After the first tile a frame ends
// with an exception only for what is known no sooner: texels that cannot be decoded, cages made on demand, and memory.
#pragma once

#include <stdexcept>
#include <string>

namespace occam {

/// Describes what went wrong, so that a person can repair it: "FILE: WHAT (WHERE)".
class Error : public std::runtime_error {
public:
    enum class Kind {
        BadInput,  ///< a file, a setting or a call that breaks a rule: exit code 2
        Output     ///< something could not be written, or a resource ran out: exit code 3
    };

    /// file     path as the user gave it, or empty for an error of use
    /// what     the rule that is broken
    /// where    the element: "mesh 3, primitive 0", "line 12"; may be empty
    Error(std::string file, std::string what, std::string where = {}, Kind kind = Kind::BadInput)
        : std::runtime_error(
              in_one_line((file.empty() ? "" : file + ": ") + what + (where.empty() ? "" : " (" + where + ")"))),
          file_(std::move(file)),
          kind_(kind)
    {
    }

    const std::string& file() const noexcept { return file_; }
    Kind kind() const noexcept { return kind_; }

private:
    /// Joins the lines of a text: libraries collect several errors in one, and a file's name may hold anything.
    static std::string in_one_line(std::string text);

    std::string file_;
    Kind kind_;
};

}  // namespace occam
