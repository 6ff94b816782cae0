#include "replay_command.h"

#include <algorithm>
#include <cctype>

namespace occam::command {
namespace {

// Quotes a word for a POSIX shell, if that is needed.
std::string for_shell(std::string_view word)
{
    static constexpr std::string_view kPlain = "_./:=,+-@%";
    const auto is_plain = [](unsigned char c) { return std::isalnum(c) || kPlain.find(char(c)) != std::string_view::npos; };
    if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return std::string(word);
    std::string text = "'";
    for (const char c : word) c == '\'' ? text += "'\\''" : text += c;
    return text + "'";
}

}  // namespace

std::vector<std::string> words_of_scene(std::span<char* const> words)
{
    std::vector<std::string> kept{"occam"};
    for (std::size_t i = 1; i < words.size(); ++i) {
        const std::string_view word = words[i], name = word.substr(0, word.find('='));
        if (word == "--") {  // what follows are files, whatever they are called
            kept.insert(kept.end(), words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
            break;
        }
        if (name == "--json") continue;
        if (name == "--rays" || name == "--seed" || name == "--replay") {
            if (name == word) ++i;  // its value is the next word
            continue;
        }
        kept.emplace_back(word);
    }
    return kept;
}

std::string replay_command(const std::vector<std::string>& words, std::string_view line)
{
    const auto files = std::find(words.begin(), words.end(), "--");
    std::string text;
    const auto add = [&](const std::string& word) { text.append(text.empty() ? "" : " ").append(for_shell(word)); };
    std::for_each(words.begin(), files, add);
    text.append(" --replay ").append(for_shell(line));
    std::for_each(files, words.end(), add);
    return text;
}

}  // namespace occam::command
