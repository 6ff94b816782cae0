// Tests of the search for cycles: that nodes cannot show themselves, and what it costs to find that out.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include "base/error.h"
#include "scenegraph/ids.h"
#include "scenegraph/reachability.h"
#include "scenegraph/scene.h"

namespace occam {
namespace {

/// A directed graph that counts how often it is asked for an edge.
struct Graph {
    std::vector<std::vector<NodeId>> after, before;
    mutable std::size_t asked = 0;

    explicit Graph(std::size_t nodes) : after(nodes), before(nodes) {}
    static NodeId id(std::size_t node) { return {static_cast<std::uint32_t>(node), 0}; }
    void add_edge(std::size_t from, std::size_t to)
    {
        after[from].push_back(id(to));
        before[to].push_back(id(from));
    }
    bool leads_to(std::size_t from, std::size_t to) const
    {
        asked = 0;
        const auto edge_of = [&](const std::vector<std::vector<NodeId>>& edges) {
            return [&](NodeId node, std::size_t i) {
                ++asked;
                return i < edges[node.slot].size() ? std::optional<NodeId>(edges[node.slot][i]) : std::nullopt;
            };
        };
        return occam::leads_to(id(from), id(to), edge_of(after), edge_of(before));
    }
};

TEST(Reachability, ANodeLeadsToWhatAPathOfEdgesReaches)
{
    std::mt19937 random(3);
    int yes = 0, no = 0;
    for (int round = 0; round < 200; ++round) {
        constexpr std::size_t kNodes = 12;
        Graph graph(kNodes);
        bool reached[kNodes][kNodes] = {};
        for (std::size_t n = 0; n < kNodes; ++n) reached[n][n] = true;
        const int edges = 1 + round % 20;
        for (int e = 0; e < edges; ++e) {
            const std::size_t from = random() % kNodes;
            const std::size_t to = random() % kNodes;
            graph.add_edge(from, to);
            reached[from][to] = true;
            if (e % 4 == 0) graph.after[from].push_back({}), graph.before[to].push_back({});
        }
        for (std::size_t via = 0; via < kNodes; ++via)
            for (auto& from : reached)
                for (std::size_t to = 0; to < kNodes; ++to) from[to] = from[to] || (from[via] && reached[via][to]);
        for (std::size_t from = 0; from < kNodes; ++from)
            for (std::size_t to = 0; to < kNodes; ++to) {
                EXPECT_EQ(graph.leads_to(from, to), reached[from][to]) << "round " << round << ": " << from << ", " << to;
                ++(reached[from][to] ? yes : no);
            }
    }
    EXPECT_GT(yes, 3000);
    EXPECT_GT(no, 3000);
}

// Content is added below what very many nodes show, and very much content where few nodes do.
TEST(Reachability, TheSmallerSideDecidesWhatAnAnswerCosts)
{
    constexpr std::size_t kMany = 10000;
    // Nodes 2 and above lead to node 0, and node 1 leads to a few of its own.
    Graph crowd(kMany + 5), forest(kMany + 5);
    for (std::size_t n = 5; n < kMany + 5; ++n) crowd.add_edge(n, 0), forest.add_edge(1, n);
    for (std::size_t n = 2; n < 5; ++n) crowd.add_edge(1, n), forest.add_edge(n, 0);
    for (const Graph* graph : {&crowd, &forest}) {
        EXPECT_FALSE(graph->leads_to(1, 0));
        EXPECT_LT(graph->asked, 20u);
    }
    Graph both(2 * kMany + 2);
    for (std::size_t n = 2; n < kMany; ++n) both.add_edge(n, 0), both.add_edge(1, n + kMany);
    EXPECT_FALSE(both.leads_to(1, 0));
    EXPECT_LT(both.asked, 6 * kMany) << "each edge, and each end of a list";
    both.add_edge(1, 0);
    EXPECT_TRUE(both.leads_to(1, 0));
}

/// What a scene's nodes show, as a plain list of edges.
struct Model {
    struct Entry {
        NodeId id, parent, shown;
    };
    std::vector<Entry> nodes;

    Entry& at(NodeId id)
    {
        return *std::find_if(nodes.begin(), nodes.end(), [&](const Entry& node) { return node.id == id; });
    }
    bool lies_below(NodeId id, NodeId top)
    {
        while (id && id != top) id = at(id).parent;
        return id == top;
    }
    void remove(NodeId top)
    {
        std::set<std::uint32_t> gone;
        for (const Entry& node : nodes)
            if (lies_below(node.id, top)) gone.insert(node.id.slot);
        std::erase_if(nodes, [&](const Entry& node) { return gone.contains(node.id.slot); });
        for (Entry& node : nodes)
            if (node.shown && gone.contains(node.shown.slot)) node.shown = {};
    }
    /// Takes away nodes that show none, again and again: what is left lies on a cycle or above one.
    bool has_cycle() const
    {
        std::vector<Entry> left = nodes;
        while (true) {
            const auto shows_any = [&](const Entry& node) {
                return std::any_of(left.begin(), left.end(),
                                   [&](const Entry& other) { return other.parent == node.id || other.id == node.shown; });
            };
            std::vector<Entry> next;
            std::copy_if(left.begin(), left.end(), std::back_inserter(next), shows_any);
            if (next.size() == left.size()) return !left.empty();
            left = std::move(next);
        }
    }
};

/// Random edits of a scene, each of which has to be refused if the model of it would have a cycle.
class RandomEdits {
public:
    explicit RandomEdits(unsigned seed) : random_(seed) { model_.nodes.push_back({scene_.root(), {}, {}}); }

    void edit()
    {
        const std::size_t kind = pick(20);
        const NodeId a = any(), b = any();
        Model after = model_;
        if (kind < 6 && model_.nodes.size() < 24) {
            const NodeId shown = kind < 3 ? b : NodeId();
            after.nodes.push_back({kNew, a, shown});
            NodeId made;
            attempt(after, [&] { made = scene_.add_node(a, {.instance_of = shown}); });
            if (made) model_.at(kNew).id = made;
        } else if (kind < 12) {
            after.at(a).shown = kind == 6 ? NodeId() : b;
            attempt(after, [&] { scene_.set_instance_of(a, after.at(a).shown); });
        } else if (kind < 17 && a != scene_.root()) {
            after.at(a).parent = b;
            attempt(after, [&] { scene_.set_parent(a, b); });
        } else if (kind == 17 && a != scene_.root() && pick(2) == 0) {
            scene_.remove(a);
            model_.remove(a);
        } else if (kind > 17 && model_.nodes.size() < 24 && !model_.lies_below(b, a)) {
            copy(a, b);
        }
    }
    int refused = 0, done = 0;

private:
    static constexpr NodeId kNew{1u << 30, 0};

    std::size_t pick(std::size_t n) { return std::size_t(random_() % n); }
    NodeId any() { return model_.nodes[pick(model_.nodes.size())].id; }
    void attempt(const Model& after, const std::function<void()>& edit)
    {
        bool is_refused = false;
        try {
            edit();
        } catch (const Error&) {
            is_refused = true;
        }
        EXPECT_EQ(is_refused, after.has_cycle());
        ++(is_refused ? refused : done);
        if (!is_refused) model_ = after;
    }
    void copy(NodeId top, NodeId parent)
    {
        std::map<std::uint32_t, NodeId> copy_of;  // by the slot of the original
        for (const Model::Entry& node : model_.nodes)
            if (model_.lies_below(node.id, top)) copy_of[node.id.slot] = {kNew.slot + node.id.slot, 0};
        const auto counterpart = [&](NodeId id) { return id && copy_of.contains(id.slot) ? copy_of.at(id.slot) : id; };
        Model after = model_;
        for (const Model::Entry& node : model_.nodes)
            if (copy_of.contains(node.id.slot))
                after.nodes.push_back(
                    {counterpart(node.id), node.id == top ? parent : counterpart(node.parent), counterpart(node.shown)});
        NodeId made;
        attempt(after, [&] { made = scene_.copy(top, parent); });
        if (made) name_copy(top, made, copy_of);
    }
    /// Gives the copies in the model the handles that the scene gave them.
    void name_copy(NodeId original, NodeId made, const std::map<std::uint32_t, NodeId>& copy_of)
    {
        const NodeId known = copy_of.at(original.slot);
        for (Model::Entry& node : model_.nodes)
            for (NodeId* id : {&node.id, &node.parent, &node.shown})
                if (*id == known) *id = made;
        for (std::size_t i = 0; i < scene_.node(made).children.size(); ++i)
            name_copy(scene_.node(original).children[i], scene_.node(made).children[i], copy_of);
    }

    std::mt19937 random_;
    Scene scene_;
    Model model_;
};

TEST(Reachability, AnEditIsRefusedIfAndOnlyIfANodeWouldShowItself)
{
    int refused = 0, done = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE(seed);
        RandomEdits edits(seed);
        for (int i = 0; i < 100; ++i) edits.edit();
        refused += edits.refused;
        done += edits.done;
    }
    EXPECT_GT(refused, 400);
    EXPECT_GT(done, 1000);
}

}  // namespace
}  // namespace occam
