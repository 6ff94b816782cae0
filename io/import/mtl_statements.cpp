#include "io/import/mtl_statements.h"

#include <array>
#include <charconv>
#include <initializer_list>

#include "io/import/words.h"

namespace occam::import {

namespace {

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> list)
{
    return std::find(list.begin(), list.end(), word) != list.end();
}

// An option of an image with numbers, and the values of those that are left out.
struct NumberOption {
    std::string_view name;
    int numbers;
    std::array<std::string_view, 3> defaults;
    bool is_read = true;  // false: other values than the defaults would change the picture, but are left out
};
constexpr NumberOption kNumberOptions[] = {
    {"-o", 3, {"0", "0", "0"}},        {"-s", 3, {"1", "1", "1"}}, {"-t", 3, {"0", "0", "0"}, false},
    {"-mm", 2, {"0", "1", ""}, false}, {"-bm", 1, {"1", "", ""}},  {"-boost", 1, {"1", "", ""}},
};

// Returns whether the word is a number, also one that is not finite or that no double holds.
bool is_any_number(std::string_view word)
{
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error != std::errc::invalid_argument && end == word.data() + word.size();
}

class Preparation {
public:
    Preparation(const std::string& name, Report& report) : name_(name), report_(report) {}

    std::string run(std::string_view text)
    {
        out_.reserve(text.size());
        for (TextLines lines(text); lines.next();) {
            line_number_ = lines.number();
            statement(lines.line());
        }
        return std::move(out_);
    }

private:
    void statement(std::string_view line)
    {
        Words words(line);
        const std::string_view keyword = words.next();
        if (keyword == "newmtl") {
            is_nameless_ = words.rest().empty();
            if (is_nameless_) warn("a material has no name: it is left out");
        }
        if (is_nameless_) return;
        if (keyword == "newmtl") {
            put({keyword, words.rest()});
            for (const std::string_view value : {"Kd -1 -1 -1", "Ni -1", "Pr -1", "Pm -1"}) put({value});
        } else if (is_one_of(keyword, {"Kd", "Ke"})) {
            color(keyword, Words(without_comment(words.rest())));
        } else if (is_one_of(keyword, {"d", "Tr", "Ni", "Ns", "illum", "Pr", "Pm", "Pc", "Pcr"})) {
            number(keyword, Words(without_comment(words.rest())));
        } else if (keyword.starts_with("map_") || is_one_of(keyword, {"bump", "disp", "refl", "norm"})) {
            image(keyword, words);
        } else {
            put({line});
        }
    }

    void put(std::initializer_list<std::string_view> words)
    {
        for (const std::string_view word : words) out_.append(word).push_back(' ');
        out_.back() = '\n';
    }
    void warn(const char* what) { report_.warn(what, name_ + ", line " + std::to_string(line_number_)); }

    // The second and the third part equal the first where they are left out.
    void color(std::string_view keyword, Words words)
    {
        const std::string_view r = words.next();
        std::string_view g = words.next(), b = words.next();
        if (g.empty()) g = r;
        if (b.empty()) b = r;
        if (finite_number(r) && finite_number(g) && finite_number(b)) {
            put({keyword, r, g, b});
            return;
        }
        if (is_one_of(r, {"spectral", "xyz"}))
            warn("colours as spectra or in CIE XYZ are not supported: the default is used");
        else warn("a colour is not made of numbers: the default is used");
        if (keyword == "Kd") put({keyword, "1 1 1"});  // as where there is no material
    }

    void number(std::string_view keyword, Words words)
    {
        std::string_view value = words.next();
        if (keyword == "d" && value == "-halo") {
            warn("opacity with -halo is the same from all directions");
            value = words.next();
        }
        if (finite_number(value)) put({keyword, value});
        else warn("a value of a material is not a number: it is left out");
    }

    void image(std::string_view keyword, Words words)
    {
        out_.append(keyword);
        while (take_option(words)) {
        }
        out_.append(" ").append(words.rest()).append("\n");
    }

    // Copies one option with its values. Returns false if the words do not begin with an option.
    bool take_option(Words& words)
    {
        Words after = words;
        const std::string_view name = after.next();
        const auto option = std::find_if(std::begin(kNumberOptions), std::end(kNumberOptions),
                                         [&](const NumberOption& o) { return o.name == name; });
        if (option != std::end(kNumberOptions)) {
            words = after;
            take_numbers(*option, words);
            return true;
        }
        const bool is_switch = is_one_of(name, {"-blendu", "-blendv", "-clamp", "-cc"});
        if (!is_switch && !is_one_of(name, {"-imfchan", "-type", "-texres", "-colorspace"})) return false;
        words = after;
        std::string_view value = after.next();
        const bool has_value = is_switch ? is_one_of(value, {"on", "off"}) : !after.rest().empty();
        if (has_value) words = after;
        else value = "on";
        if (name != "-cc" && (has_value || is_switch))  // tinyobjloader does not know -cc
            out_.append(" ").append(name).append(" ").append(value);
        return true;
    }

    // The last word of a line is the name of the image, even if it is a number.
    void take_numbers(const NumberOption& option, Words& words)
    {
        out_.append(" ").append(option.name);
        bool is_number = true, is_finite = true, is_default = true;
        for (std::size_t i = 0; i < static_cast<std::size_t>(option.numbers); ++i) {
            Words after = words;
            const std::string_view value = after.next();
            is_number = is_number && is_any_number(value) && !after.rest().empty();
            if (is_number) words = after;
            const bool is_taken = is_number && finite_number(value);
            is_finite = is_finite && is_taken == is_number;
            is_default &= !is_taken || finite_number(value) == finite_number(option.defaults[i]);
            out_.append(" ").append(is_taken ? value : option.defaults[i]);
        }
        if (!option.is_read && !is_default)
            warn("the options -mm and -t of images, which change their colours and their places, are left out");
        if (!is_finite) warn("a value of an image's option is not a finite number: the default is used");
    }

    const std::string& name_;
    Report& report_;
    std::string out_;
    std::size_t line_number_ = 0;
    bool is_nameless_ = false;  // what is read belongs to a material that nothing can name
};

}  // namespace

std::string prepare_mtl(std::string_view text, const std::string& name, Report& report)
{
    return Preparation(name, report).run(text);
}

}  // namespace occam::import
