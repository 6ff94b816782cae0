#include "usage_message.h"

#include <CLI/CLI.hpp>
#include <cctype>
#include <string_view>
#include <utility>

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

bool is_flag(const CLI::Option& option) { return option.get_items_expected_max() == 0; }

// Checks a word of one dash, in which each letter names an option, up to one whose value is the rest. Returns whether its
// value is the next word.
bool check_letters(const CLI::App& used, std::string_view word)
{
    for (std::size_t k = 1; k < word.size(); ++k) {
        const CLI::Option* option = used.get_option_no_throw(std::string("-") + word[k]);
        if (!option && k > 1)
            throw CLI::ParseError("there is no option '" + std::string(word) + "'", CLI::ExitCodes::ExtrasError);
        if (!option) return false;
        if (!is_flag(*option)) return k + 1 == word.size();
    }
    return false;
}

}  // namespace

void refuse_values_of_flags(const CLI::App& used, std::span<char* const> words)
{
    bool is_value = false;
    for (const std::string_view word : words.subspan(1)) {
        if (std::exchange(is_value, false) || word.size() < 2 || word[0] != '-') continue;
        if (word == "--") return;  // names of files follow
        if (word[1] != '-') {
            is_value = check_letters(used, word);
            continue;
        }
        const std::size_t sign = word.find('=');
        const CLI::Option* option = used.get_option_no_throw(std::string(word.substr(0, sign)));
        if (!option) continue;
        if (is_flag(*option) && sign != word.npos)
            throw CLI::ParseError(option->get_name() + " takes no value", CLI::ExitCodes::InvalidError);
        is_value = !is_flag(*option) && sign == word.npos;
    }
}

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
