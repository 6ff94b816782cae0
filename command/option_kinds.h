// The kinds of options that parse.cpp and parse_motion.cpp add. A value that cannot be read becomes a line about its option.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "arguments.h"
#include "values.h"

namespace occam::command {

/// Adds an option whose text `read` parses. An exception that `read` throws becomes a line about that option.
inline CLI::Option* add_value(CLI::App& app, const std::string& names, const std::string& what, const std::string& form,
                              std::function<void(const std::string&)> read)
{
    CLI::Option* option = app.add_option_function<std::string>(
        names,
        [names, read = std::move(read)](const std::string& text) {
            try {
                read(text);
            } catch (const std::invalid_argument& error) {
                throw CLI::ValidationError(names.substr(0, names.find(',')), error.what());
            }
        },
        what);
    return option->type_name(form);
}

/// range   which numbers can be taken, as in "more than 0"
/// set     takes the number, or returns false
inline CLI::Option* add_number(CLI::App& app, const std::string& name, const std::string& what, const std::string& range,
                               std::function<bool(double)> set)
{
    return add_value(app, name, what, "NUMBER", [range, set = std::move(set)](const std::string& t) {
        if (!set(number_of(t))) expected(range, t);
    });
}

/// Adds an option whose value is a whole number, which may be written as 1e5.
template <class T>
CLI::Option* add_whole(CLI::App& app, const std::string& name, T& value, std::uint64_t least, std::uint64_t most,
                       const std::string& what)
{
    return add_value(app, name, what, "N",
                     [&value, least, most](const std::string& t) { value = static_cast<T>(whole_of(t, least, most)); });
}

/// Adds an option whose value is a number that is not below 0.
inline CLI::Option* add_amount(CLI::App& app, const std::string& name, const std::string& what,
                               std::function<void(double)> set)
{
    return add_number(app, name, what, "0 or more", [set = std::move(set)](double v) {
        if (v >= 0) set(v);
        return v >= 0;
    });
}

inline CLI::Option* add_switch(CLI::App& app, const std::string& name, bool& value, const std::string& what)
{
    return add_value(app, name, what, "on|off", [&value](const std::string& t) { value = is_on(t); });
}

template <class T>
CLI::Option* add_choice(CLI::App& app, const std::string& name, T& value, const std::map<std::string, T>& choices,
                        const std::string& what)
{
    std::string form;
    for (const auto& choice : choices) form += (form.empty() ? "" : "|") + choice.first;
    return add_value(app, name, what, form, [&value, choices, form](const std::string& text) {
        const auto found = choices.find(text);
        if (found == choices.end()) expected("one of " + form, text);
        value = found->second;
    });
}

/// Refuses options of a command that were given with an empty value, as a variable without a value in a script leaves it:
/// they would count as not given.
inline void refuse_empty_values(const CLI::App& command)
{
    for (const CLI::Option* option : command.get_options())
        for (const std::string& value : option->results())
            if (value.empty()) throw CLI::ValidationError(option->get_name(), "its value is empty");
}
/// Refuses words like --name= before they are parsed, for the same reason: the parser would take the next word for the
/// value.
inline void refuse_empty_values(std::span<char* const> words)
{
    for (const std::string_view word : words) {
        if (word == "--") return;  // names of files follow
        if (word.starts_with("--") && word.find('=') == word.size() - 1)
            throw CLI::ValidationError(std::string(word.substr(0, word.size() - 1)), "its value is empty");
    }
}

/// Adds an option for each row of render/setting_rows.h that has one.
void add_settings(CLI::App& app, Settings& settings);

// The options of time, for commands that pose the scene.
void add_clip(CLI::App& app, RenderArguments& arguments);
void add_moment(CLI::App& app, RenderArguments& arguments);  ///< after add_clip()
void add_shutter(CLI::App& app, RenderArguments& arguments);
void add_sequence(CLI::App& app, AnimateArguments& arguments);

// The options that trace one sample or ray again. With the first, the picture's option is not required.
void add_replay(CLI::App& app, CLI::Option& output, RenderArguments& arguments);
void add_replay(CLI::App& app, VerifyArguments& arguments);
/// Add `occam compare` and `occam texture` (parse_pictures.cpp).
CLI::App& add_compare(CLI::App& all, CompareArguments& arguments);
CLI::App& add_texture(CLI::App& all, TextureArguments& arguments);

/// Holds the words for the benchmark program.
struct BenchWords {
    std::vector<std::string> suites;
    std::string only, json;
    bool list = false;

    BenchArguments arguments() const;
};
CLI::App& add_bench(CLI::App& all, BenchWords& bench);

}  // namespace occam::command
