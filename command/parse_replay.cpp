// The options that trace one ray or sample again and write what it does.
#include "option_kinds.h"

namespace occam::command {

void add_replay(CLI::App& app, CLI::Option& output, RenderArguments& a)
{
    add_value(
        app, "--replay",
        "Trace sample S [0] of pixel X,Y from the top left again, and print each step of its rays; no picture is written, "
        "so --output is not needed",
        "X,Y[,S]", [&](const std::string& t) {
            const std::vector<std::string_view> words = words_of(t);
            if (words.size() < 2 || words.size() > 3) expected("X,Y or X,Y,SAMPLE", t);
            const auto number = [&](std::size_t k) { return static_cast<int>(whole_of(words[k], 0, 0x7fffffff)); };
            a.replay = PixelSample{number(0), number(1), words.size() > 2 ? number(2) : 0};
            output.required(false);
        });
}

void add_replay(CLI::App& app, VerifyArguments& a)
{
    app.add_option("--replay", a.replay,
                   "Trace one ray again and print each step: a line that was printed for a ray that escaped")
        ->type_name("LINE");
}

}  // namespace occam::command
