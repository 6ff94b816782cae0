// The benchmarks measure and report with these functions: rows of named figures, each a median with its minimum and maximum.
//
// Time is CPU time of the calling thread where one thread does the work, so that a busy machine disturbs it least. The work
// still shares caches and memory with whatever else runs, so figures to be compared are taken in turns within one run.
#pragma once

#include <string>
#include <vector>

namespace occam::bench {

double thread_seconds();   ///< CPU time of this thread
double process_seconds();  ///< CPU time of all threads of this process
double wall_seconds();     ///< wall time since a fixed moment

/// Returns the CPU seconds of this thread for each of `runs` calls.
template <class Work>
std::vector<double> repeat(int runs, Work&& work)
{
    std::vector<double> seconds;
    for (int i = 0; i < runs; ++i) {
        const double start = thread_seconds();
        work();
        seconds.push_back(thread_seconds() - start);
    }
    return seconds;
}

/// Divides `amount` by each of the samples, which turns seconds into rates.
std::vector<double> per(double amount, std::vector<double> samples);
/// Multiplies each of the samples by `factor`.
std::vector<double> times(std::vector<double> samples, double factor);
/// Returns a[i] / b[i] for samples taken in turns.
std::vector<double> ratios(const std::vector<double>& a, const std::vector<double>& b);

struct Figure {
    std::string name;  ///< with its unit
    double median = 0, least = 0, most = 0;
    int runs = 0;  ///< 0 for a count or an error, which is the same each time
};

/// Holds one case of a suite.
struct Row {
    std::string suite, name;
    std::vector<Figure> figures{};
    std::string note{};    ///< why there are no figures, or how to read them
    std::string recipe{};  ///< if not empty, the row's JSON is flat: medians under the figures' names

    Row& add(std::string figure, std::vector<double> samples);
    Row& add(std::string figure, double value);
};

class Report {
public:
    /// only   empty, or a part of the names of the cases to run
    explicit Report(std::string only = {}) : only_(std::move(only)) {}

    bool wants(const std::string& name) const { return name.find(only_) != std::string::npos; }
    /// Prints the row and keeps it.
    void add(Row row);
    /// Returns all rows as JSON, with the machine on which they were measured.
    std::string json() const;

private:
    std::string only_;
    std::vector<Row> rows_;
};

}  // namespace occam::bench
