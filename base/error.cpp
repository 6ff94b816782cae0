#include "base/error.h"

namespace occam {

std::string Error::in_one_line(std::string text)
{
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    std::string line;
    for (const char c : text) {
        if (c != '\n' && c != '\r') line += c;
        else if (!line.ends_with("; ")) line += "; ";
    }
    return line;
}

}  // namespace occam
