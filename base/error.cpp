#include "base/error.h"

#include "base/printable.h"

namespace occam {

std::string Error::in_one_line(std::string text) { return printable_line(text); }

}  // namespace occam
