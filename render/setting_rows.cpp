#include "render/setting_rows.h"

#include <algorithm>
#include <cstdio>
#include <ostream>
#include <type_traits>

namespace occam::render {
namespace {

std::string text_of(double number)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", number);
    return text;
}

}  // namespace

std::string option_of(const SettingRow& row)
{
    std::string option(row.name);
    std::replace(option.begin(), option.end(), '_', '-');
    return option;
}

std::string range_of(const SettingRow& row)
{
    return std::visit(
        [&]<class T>(T Settings::*) -> std::string {
            if constexpr (std::is_enum_v<T> || std::is_same_v<T, bool>) return {};
            else {
                std::string range;
                if (row.most >= 0x1p64) {
                    range.append(text_of(row.least)).append(" or more");
                    if (!row.unit.empty()) range.append(",");
                } else {
                    range.append("from ").append(text_of(row.least)).append(" to ");
                    range.append(row.most == kBelowOne ? "less than 1" : text_of(row.most));
                }
                if (!row.unit.empty()) range.append(" ").append(row.unit);
                return range;
            }
        },
        row.member);
}

std::string text_of(const SettingRow& row, const Settings& settings)
{
    return std::visit(
        [&]<class T>(T Settings::*member) -> std::string {
            const T value = settings.*member;
            if constexpr (std::is_enum_v<T>) return std::string(name_of(value));
            else if constexpr (std::is_same_v<T, bool>) return value ? "on" : "off";
            else if constexpr (std::is_integral_v<T>) return std::to_string(value);
            else return text_of(static_cast<double>(value));
        },
        row.member);
}

std::string default_of(const SettingRow& row)
{
    return row.initial.empty() ? text_of(row, Settings()) : std::string(row.initial);
}

std::ostream& operator<<(std::ostream& out, const Settings& settings)
{
    out << settings.width << 'x' << settings.height;
    for (const SettingRow& row : kSettings)
        if (const std::string text = text_of(row, settings); text != text_of(row, Settings()))
            out << ", " << row.name << ' ' << text;
    return out;
}

}  // namespace occam::render
