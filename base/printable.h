// Text of files and names as one line without control characters, which a terminal would obey. Characters that turn the
// direction of writing around are kept: names in some languages need them.
#pragma once

#include <string>
#include <string_view>

namespace occam {

/// Returns the text as one line: line ends become "; ", other control characters and bytes that are no UTF-8 become "\xNN".
/// The middle of a text that is much longer than any message is left out.
std::string printable_line(std::string_view text);

}  // namespace occam
