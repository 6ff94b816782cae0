// The options of settings that are one value: they are made from the rows of render/setting_rows.h.
#include "option_kinds.h"
#include "render/setting_rows.h"

namespace occam::command {
namespace {

template <class T>
void add_setting(CLI::App& app, const render::SettingRow& row, T& value)
{
    const std::string name = "--" + render::option_of(row);
    const std::string help = std::string(row.help) + " [" + render::default_of(row) + "]";
    if constexpr (std::is_same_v<T, bool>) add_switch(app, name, value, help);
    else if constexpr (std::is_enum_v<T>) {
        std::map<std::string, T> choices;
        for (const auto& [choice, word] : render::choices_of(value)) choices.emplace(word, choice);
        add_choice<T>(app, name, value, choices, help);
    } else if constexpr (std::is_integral_v<T>) {
        const std::uint64_t most = row.most < 0x1p64 ? static_cast<std::uint64_t>(row.most) : ~std::uint64_t(0);
        add_whole(app, name, value, static_cast<std::uint64_t>(row.least), most, help);
    } else {
        add_number(app, name, help, "a number, " + render::range_of(row), [&value, &row](double v) {
            value = static_cast<T>(v);
            return v >= row.least && v <= row.most;
        });
    }
}

}  // namespace

void add_settings(CLI::App& app, Settings& settings)
{
    for (const render::SettingRow& row : render::kSettings)
        if (!row.help.empty()) std::visit([&](auto member) { add_setting(app, row, settings.*member); }, row.member);
}

}  // namespace occam::command
