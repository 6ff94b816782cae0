#include "usage_message.h"

#include <CLI/CLI.hpp>
#include <cctype>
#include <string_view>

#include "base/printable.h"

namespace occam::command {
namespace {

// Returns the option of the command whose name begins as the word does or contains it; null if there is none.
const CLI::Option* similar_option(const CLI::App& app, const std::string& word)
{
    const CLI::Option* found = nullptr;
    for (const CLI::Option* option : app.get_options()) {
        const std::string name = option->get_name();
        if (name.rfind(word, 0) == 0) return option;
        if (!found && word.size() > 3 && name.find(word.substr(2)) != std::string::npos) found = option;
    }
    return found;
}

}  // namespace

std::string message_of(const CLI::ParseError& error, const CLI::App& used, std::span<char*> words)
{
    const std::string text = printable_line(error.what());
    // The text alone tells whether there are too few values or too many.
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) && text.rfind("--", 0) == 0)
        return text.substr(0, text.find(':')) +
               (text.find("At Most") != std::string::npos ? " is given more than once" : " needs a value");
    const bool is_extra = dynamic_cast<const CLI::ExtrasError*>(&error) || dynamic_cast<const CLI::RequiredError*>(&error);
    if (!is_extra) return text;
    for (const char* raw : words.subspan(1)) {
        const std::string word = std::string(raw).substr(0, std::string_view(raw).find('='));
        if (word.size() < 2 || word[0] != '-' || !std::isalpha(static_cast<unsigned char>(word.back()))) continue;
        if (used.get_option_no_throw(word)) continue;
        const CLI::Option* similar = similar_option(used, word);
        return "there is no option '" + printable_line(word) + "'" + (similar ? "; there is " + similar->get_name() : "");
    }
    return text;
}

}  // namespace occam::command
