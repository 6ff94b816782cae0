// What is said about a command line that cannot be parsed.
#pragma once

#include <span>
#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace occam::command {

/// Returns what a person can act upon. The parser's own messages list words in reverse and speak of mismatches.
/// used    the command that was given, or the program itself
/// words   argv
std::string message_of(const CLI::ParseError& error, const CLI::App& used, std::span<char*> words);

/// Throws CLI::ParseError if a flag has a value, or is one letter followed by what is none: the parser would take the first
/// part of `--version=1` and `-h2` alone.
/// used, words   as above
void refuse_values_of_flags(const CLI::App& used, std::span<char* const> words);

}  // namespace occam::command
