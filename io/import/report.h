// The report of an importer on what it repaired or left out: it keeps each kind once, with a count and the first place.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/import/folder.h"
#include "scenegraph/scene.h"

namespace occam::import {

class Report {
public:
    /// strict   every warning is thrown as an Error instead
    Report(std::filesystem::path file, bool strict)
        : file_(std::move(file)), strict_(strict), folder_(file_.parent_path()), files_{file_}
    {
    }

    const std::filesystem::path& file() const noexcept { return file_; }
    std::string name() const { return file_.string(); }
    /// Returns the folder of the scene, which finds the files that the scene names.
    Folder& folder() noexcept { return folder_; }
    bool is_strict() const noexcept { return strict_; }

    void warn(const std::string& what, const std::string& where = {}) { add(what, what, where, ", first of "); }
    /// Keeps a kind for each file, because each has to be found by a person. It is counted as often as it is used.
    void warn_of_file(const std::string& what, const std::string& file)
    {
        add(what + '\n' + file, what, file, ", number of uses: ");
    }

    /// Lists a file that is read for the scene, or that is named in it (Scene::files).
    void add_file(const std::filesystem::path& file) { files_.insert(file); }
    const std::set<std::filesystem::path>& files() const noexcept { return files_; }

    /// Returns one line for each kind, in the order in which they came up.
    std::vector<std::string> lines() const
    {
        std::vector<std::string> result;
        for (const Kind& kind : kinds_) {
            std::string line = kind.what;
            if (!kind.where.empty())
                line += " (" + kind.where + (kind.count > 1 ? kind.counted + std::to_string(kind.count) : "") + ")";
            else if (kind.count > 1) line += " (" + std::to_string(kind.count) + " times)";
            result.push_back(std::move(line));
        }
        if (left_out_ > 0) result.push_back(std::to_string(left_out_) + " warnings of other kinds");
        return result;
    }

private:
    struct Kind {
        std::string what, where;
        const char* counted;  // what stands before a count above 1
        std::size_t count = 0;
    };

    // A place may have a very long name, so it is copied for the first of a kind only.
    void add(const std::string& key, const std::string& what, const std::string& where, const char* counted)
    {
        if (strict_) throw Error(name(), what, where);
        if (const auto known = index_.find(key); known != index_.end()) {
            ++kinds_[known->second].count;
        } else if (kinds_.size() < kMaxKinds) {
            index_.try_emplace(key, kinds_.size());
            kinds_.push_back({what, where, counted, 1});
        } else {
            ++left_out_;
        }
    }

    static constexpr std::size_t kMaxKinds = 1000;  // more kinds than this would not be read
    std::filesystem::path file_;
    bool strict_;
    Folder folder_;
    std::set<std::filesystem::path> files_;
    std::size_t left_out_ = 0;
    std::vector<Kind> kinds_;
    std::map<std::string, std::size_t> index_;
};

/// Ends an import: what was repaired goes into scene.warnings, or is thrown as an Error if the report is strict. What was
/// read goes into scene.files.
void finish(Scene& scene, const Report& report);

}  // namespace occam::import
