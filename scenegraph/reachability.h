// Tells whether one node of a directed graph leads to another.
//
// Two searches, one along the edges and one against them, go on in turns, and the first to end decides. So it costs what the
// smaller of them costs: a node with few nodes below is soon known to lead nowhere, however many lead to the other one.
#pragma once

#include <cstddef>
#include <optional>
#include <unordered_set>
#include <vector>

namespace occam {

/// Visits what can be reached from one node, nearest nodes first, edge by edge.
/// edge_of(node, i)   returns the node at the other end of an edge, which may be null, or std::nullopt after the last edge
template <class Id, class EdgeOf>
class StepwiseSearch {
public:
    StepwiseSearch(Id start, const EdgeOf& edge_of) : edge_of_(edge_of), found_{start} {}

    bool is_done() const noexcept { return at_ == found_.size(); }
    /// Looks at the next edge, of a search that is not done. Returns the node at its end if it is new, else a null handle.
    Id step()
    {
        const std::optional<Id> end = edge_of_(found_[at_], edge_++);
        if (!end) ++at_, edge_ = 0;
        if (!end || !*end || !seen_.insert(*end).second) return {};
        found_.push_back(*end);
        return *end;
    }

private:
    const EdgeOf& edge_of_;
    std::vector<Id> found_;
    std::unordered_set<Id> seen_;
    std::size_t at_ = 0, edge_ = 0;  ///< the place in found_ of the node whose edges are looked at, and the next of them
};

/// Returns whether a path of any length leads from one node to the other. A node leads to itself.
/// after, before   list the edges that leave a node and those that end at it, as StepwiseSearch calls them
template <class Id, class After, class Before>
bool leads_to(Id from, Id to, const After& after, const Before& before)
{
    if (from == to) return true;
    StepwiseSearch<Id, After> down(from, after);
    StepwiseSearch<Id, Before> up(to, before);
    while (true) {
        if (down.step() == to) return true;
        if (down.is_done()) return false;
        if (up.step() == from) return true;
        if (up.is_done()) return false;
    }
}

}  // namespace occam
