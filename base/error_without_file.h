// Errors that no file is to blame for: those of use, and those of the machine.
#pragma once

#include <utility>

#include "base/error.h"

namespace occam {

/// what     the rule that is broken
/// where    the setting, argument or element; may be empty
inline Error error_without_file(std::string what, std::string where = {}, Error::Kind kind = Error::Kind::BadInput)
{
    return Error({}, std::move(what), std::move(where), kind);
}

}  // namespace occam
