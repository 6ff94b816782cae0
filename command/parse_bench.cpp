// The options of `occam bench`.
#include "option_kinds.h"

namespace occam::command {

BenchArguments BenchWords::arguments() const
{
    BenchArguments all{suites};
    if (list) all.words.push_back("--list");
    if (!only.empty()) all.words.insert(all.words.end(), {"--only", only});
    if (!json.empty()) all.words.insert(all.words.end(), {"--json", json});
    return all;
}

CLI::App& add_bench(CLI::App& all, BenchWords& bench)
{
    CLI::App& app = *all.add_subcommand("bench", "Measure speed, beside other software, where benchmarks were built");
    CLI::Option* suites = app.add_option("SUITE", bench.suites, "Suites to run [all]")->type_name("");
    CLI::Option* only = app.add_option("--only", bench.only, "Cases whose name or recipe has this text")->type_name("TEXT");
    CLI::Option* json = app.add_option("--json", bench.json, "Write the rows as JSON")->type_name("FILE");
    app.add_flag("--list", bench.list, "List the suites")->excludes(suites)->excludes(only)->excludes(json);
    app.footer("Example: occam bench crowd --only fast --json crowd.json");
    return app;
}

}  // namespace occam::command
