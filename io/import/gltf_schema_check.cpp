#include "io/import/gltf_schema_check.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_set>

#include "io/import/gltf_extensions.h"
#include "io/import/gltf_schema.h"

namespace occam::import {

namespace {

using nlohmann::json;
using Kind = Rule::Kind;

class Walker {
public:
    Walker(const json& root, Report& report) : root_(root), report_(report)
    {
        for (const Rule& rule : gltf_schema()) rules_[rule.object].push_back(&rule);
        if (const auto used = root.is_object() ? root.find("extensionsUsed") : root.end(); used != root.end())
            for (const json& name : *used)
                if (name.is_string()) declared_.insert(name.get<std::string>());
    }

    void object(const json& value, const std::string& type, const std::string& where)
    {
        if (!value.is_object()) refuse("must be an object", where);
        const auto& rules = rules_.at(type);
        for (const Rule* rule : rules) {
            const auto found = value.find(rule->key);
            if (found != value.end()) property(*found, *rule, where.empty() ? rule->key : where + "." + rule->key);
            else if (rule->is_required) refuse(std::string("'") + rule->key + "' is missing", where);
        }
        for (const auto& [key, inner] : value.items()) {
            if (key == "extensions") extensions(inner, type, where);
            else if (key == "name" && !inner.is_string()) refuse("name must be a string", where);
            else if (key != "name" && key != "extras" && !has_rule(rules, key))
                report_.warn("unknown property '" + key.substr(0, 64) + "'", where);
        }
    }

private:
    [[noreturn]] void refuse(const std::string& what, const std::string& where) const
    {
        throw Error(report_.name(), what, where.empty() ? "top level" : where);
    }

    static bool has_rule(const std::vector<const Rule*>& rules, const std::string& key)
    {
        return std::any_of(rules.begin(), rules.end(), [&](const Rule* rule) { return key == rule->key; });
    }

    // Texture references of all kinds allow the same extensions.
    void extensions(const json& value, const std::string& type, const std::string& where)
    {
        if (!value.is_object()) refuse("extensions must be an object", where);
        if (value.empty()) report_.warn("extensions without an entry", where);
        const std::string place = type == "normalTexture" || type == "occlusionTexture" ? "textureInfo" : type;
        for (const auto& [name, inner] : value.items()) {
            const std::string inner_type = place + "/" + name;
            if (rules_.count(inner_type)) object(inner, inner_type, where.empty() ? name : where + "." + name);
            else if (!inner.is_object()) report_.warn("extension is not an object", where + "." + name.substr(0, 64));
            else if (is_known(name)) report_.warn("extension " + name + " is not allowed here", where);
            else if (!is_understood(name) && !declared_.contains(name))  // what is declared is a warning of its own
                report_.warn("extension " + name.substr(0, 64) + " is not understood: what it says is left out", where);
        }
    }
    bool is_known(const std::string& name) const
    {
        return std::any_of(rules_.begin(), rules_.end(),
                           [&](const auto& entry) { return entry.first.ends_with("/" + name); });
    }

    template <class Visit>
    void array(const json& value, const std::string& where, Visit&& visit)
    {
        if (!value.is_array()) refuse("must be an array", where);
        if (value.empty()) report_.warn("empty array", where);
        for (std::size_t i = 0; i < value.size(); ++i) visit(value[i], where + "[" + std::to_string(i) + "]");
    }

    void index(const json& value, const char* list, const std::string& where)
    {
        std::size_t size = 0;
        const json* at = &root_;
        for (std::string path = list; at && !path.empty();) {
            const std::size_t slash = std::min(path.find('/'), path.size());
            const std::string key = path.substr(0, slash);
            path.erase(0, slash + 1);
            const auto next = at->is_object() ? at->find(key) : at->end();
            at = at->is_object() && next != at->end() ? &*next : nullptr;
        }
        if (at && at->is_array()) size = at->size();
        if (!value.is_number_integer() || value < 0) refuse("must be an index", where);
        if (value >= size)
            refuse("names " + std::string(list) + "[" + value.dump() + "], of which there are " + std::to_string(size),
                   where);
    }

    void index_map(const json& value, const char* list, const std::string& where)
    {
        if (!value.is_object()) refuse("must be an object", where);
        if (value.empty()) report_.warn("object without an entry", where);
        for (const auto& [key, inner] : value.items()) index(inner, list, where + "." + key.substr(0, 64));
    }

    void number(const json& value, const Rule& rule, const std::string& where)
    {
        if (!value.is_number()) refuse("must be a number", where);
        const double x = value.get<double>();
        // The library takes an integer with a point for one that is missing.
        if (rule.kind == Kind::Integer && !value.is_number_integer())
            refuse("must be an integer without a point, not " + value.dump(), where);
        if (!std::isfinite(x) || x < rule.low || x > rule.high || (rule.kind == Kind::Positive && x <= rule.low))
            refuse("is out of range: " + value.dump(), where);
    }

    void property(const json& value, const Rule& rule, const std::string& where)
    {
        switch (rule.kind) {
            case Kind::Object:
                return object(value, rule.detail, where);
            case Kind::Objects:
                return array(value, where, [&](const json& v, const std::string& at) { object(v, rule.detail, at); });
            case Kind::Index:
                return index(value, rule.detail, where);
            case Kind::Indices: {
                std::unordered_set<std::uint64_t> seen;
                return array(value, where, [&](const json& v, const std::string& at) {
                    index(v, rule.detail, at);
                    if (!seen.insert(v.get<std::uint64_t>()).second) refuse("is there twice", at);
                });
            }
            case Kind::IndexMap:
                return index_map(value, rule.detail, where);
            case Kind::IndexMaps:
                return array(value, where, [&](const json& v, const std::string& at) { index_map(v, rule.detail, at); });
            case Kind::Integer:
            case Kind::Number:
            case Kind::Positive:
                return number(value, rule, where);
            case Kind::Numbers:
                if (value.is_array() &&
                    (static_cast<double>(value.size()) < rule.low || static_cast<double>(value.size()) > rule.high) &&
                    !(value.empty() && rule.low <= 1))
                    refuse("has the wrong number of elements", where);
                return array(value, where, [&](const json& v, const std::string& at) {
                    number(v, {rule.object, rule.key, Kind::Number}, at);
                });
            case Kind::Boolean:
                if (!value.is_boolean()) refuse("must be true or false", where);
                return;
            case Kind::String:
                if (!value.is_string()) refuse("must be a string", where);
                return;
            case Kind::Strings:
                return array(value, where, [&](const json& v, const std::string& at) {
                    if (!v.is_string()) refuse("must be a string", at);
                });
            case Kind::Choice: {
                const std::string word = value.is_string()           ? value.get<std::string>()
                                         : value.is_number_integer() ? value.dump()
                                                                     : "";
                const bool is_known = !word.empty() && word.find('|') == std::string::npos &&
                                      std::string(rule.detail).find("|" + word + "|") != std::string::npos;
                const bool wants_number = rule.detail[1] >= '0' && rule.detail[1] <= '9';
                if (!is_known || value.is_string() == wants_number)
                    refuse("has a value that is not allowed: " + value.dump().substr(0, 64), where);
                return;
            }
            case Kind::Any:
                return;
        }
    }

    const json& root_;
    Report& report_;
    std::map<std::string, std::vector<const Rule*>> rules_;
    std::unordered_set<std::string> declared_;  // the extensions that the file says it uses
};

}  // namespace

void check_schema(const nlohmann::json& root, Report& report) { Walker(root, report).object(root, "root", ""); }

}  // namespace occam::import
