#include "tests/bench/harness.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/processors.h"

namespace occam::bench {
namespace {

double clock_seconds(clockid_t clock)
{
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::string processor_name()
{
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
    return "unknown";
}

}  // namespace

double thread_seconds() { return clock_seconds(CLOCK_THREAD_CPUTIME_ID); }
double process_seconds() { return clock_seconds(CLOCK_PROCESS_CPUTIME_ID); }
double wall_seconds() { return clock_seconds(CLOCK_MONOTONIC); }

std::vector<double> per(double amount, std::vector<double> samples)
{
    for (double& s : samples) s = amount / s;
    return samples;
}

std::vector<double> times(std::vector<double> samples, double factor)
{
    for (double& s : samples) s *= factor;
    return samples;
}

std::vector<double> ratios(const std::vector<double>& a, const std::vector<double>& b)
{
    std::vector<double> all;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) all.push_back(a[i] / b[i]);
    return all;
}

Row& Row::add(std::string figure, std::vector<double> samples)
{
    if (samples.empty()) return *this;
    std::sort(samples.begin(), samples.end());
    const std::size_t n = samples.size();
    const double median = (samples[(n - 1) / 2] + samples[n / 2]) / 2;
    figures.push_back({std::move(figure), median, samples.front(), samples.back(), static_cast<int>(n)});
    return *this;
}

Row& Row::add(std::string figure, double value)
{
    figures.push_back({std::move(figure), value, value, value, 0});
    return *this;
}

void Report::add(Row row)
{
    std::printf("%-7s %s%s%s\n", row.suite.c_str(), row.name.c_str(), row.recipe.empty() ? "" : ", ", row.recipe.c_str());
    for (const Figure& f : row.figures) {
        std::printf("        %-30s %12.5g", f.name.c_str(), f.median);
        if (f.runs > 1) std::printf("   %.5g .. %.5g, %d runs", f.least, f.most, f.runs);
        std::printf("\n");
    }
    if (!row.note.empty()) std::printf("        %s\n", row.note.c_str());
    std::fflush(stdout);
    rows_.push_back(std::move(row));
}

std::string Report::json() const
{
    using Json = nlohmann::ordered_json;
    Json rows = Json::array();
    for (const Row& row : rows_) {
        Json figures = Json::object();
        for (const Figure& f : row.figures) {
            if (f.runs == 0) figures[f.name] = f.median;
            else figures[f.name] = {{"median", f.median}, {"min", f.least}, {"max", f.most}, {"runs", f.runs}};
        }
        Json entry = {{"suite", row.suite}, {"case", row.name}};
        if (row.recipe.empty()) entry["figures"] = figures;
        else entry["recipe"] = row.recipe;
        for (const Figure& f : row.figures) {
            if (row.recipe.empty()) break;
            entry[f.name] = f.median;
            if (f.runs > 0) entry["spread"][f.name] = figures[f.name];
        }
        if (!row.note.empty()) entry["note"] = row.note;
        rows.push_back(std::move(entry));
    }
    const Json all = {
        {"version", OCCAM_PROJECT_VERSION}, {"processor", processor_name()}, {"threads", processor_count()}, {"rows", rows}};
    return all.dump(2) + "\n";
}

}  // namespace occam::bench
