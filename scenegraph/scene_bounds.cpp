// Marks the bounds that an edit puts out of date, and brings them up to date.
#include <algorithm>
#include <utility>

#include "scenegraph/scene_state.h"

namespace occam {

void Scene::State::mark_dirty(NodeId id) noexcept
try {
    std::vector<NodeId> todo{id};
    while (!todo.empty()) {
        NodeId at = todo.back();
        todo.pop_back();
        for (NodeRecord* node = nodes.find(at); node && !node->dirty; at = node->parent, node = nodes.find(at)) {
            node->dirty = true;
            touch_in_parent(*node);
            const auto shows_it = [&](NodeId instance) { return is_instance_of(instance, at); };
            for (NodeId instance : node->instances.those_that(shows_it)) todo.push_back(instance);
        }
    }
} catch (const std::bad_alloc&) {
    lose_bounds();
}

void Scene::State::touch_in_parent(const NodeRecord& node) noexcept
{
    if (NodeRecord* parent = nodes.find(node.parent)) touch_child(*parent, node.place_among_siblings);
}

void Scene::State::touch_child(NodeRecord& parent, std::uint32_t place_among_siblings) noexcept
try {
    if (parent.child_boxes) parent.child_boxes->touch(place_among_siblings);
} catch (const std::bad_alloc&) {
    lose_bounds();
}

void Scene::State::lose_bounds() noexcept
{
    has_lost_bounds = true;
    nodes.find(root)->dirty = true;
}

void Scene::State::find_lost_bounds() noexcept
{
    if (!has_lost_bounds) return;
    nodes.for_each([](NodeId, NodeRecord& node) {
        node.dirty = true;
        node.child_boxes.reset();
    });
    skins.for_each([](SkinId, SkinRecord& skin) { skin.dirty = true; });
    has_lost_bounds = false;
}

void Scene::State::leave_parent(NodeId id, std::uint32_t place_among_siblings) noexcept
{
    NodeRecord& parent = *nodes.find(id);
    touch_child(parent, place_among_siblings);
    parent.children[place_among_siblings] = NodeId();
    // Gaps are closed if there are few children, or as many gaps as children, so the mean cost of a removal is constant.
    if (++parent.removed_children * 2 < parent.children.size() && parent.children.size() > kManyChildren) return;
    std::erase(parent.children, NodeId());
    parent.removed_children = 0;
    parent.child_boxes.reset();
    for (std::size_t i = 0; i < parent.children.size(); ++i)
        nodes.find(parent.children[i])->place_among_siblings = static_cast<std::uint32_t>(i);
}

void Scene::State::mark_users_dirty(CageRecord& cage) noexcept
{
    if (std::exchange(cage.users_marked_in, round) == round) return;
    note_looked_at(cage.users.ids().size());
    const auto shows_it = [&](NodeId id) {
        const NodeRecord* user = nodes.find(id);
        return user && std::find(user->cages.begin(), user->cages.end(), cage.id) != user->cages.end();
    };
    for (NodeId user : cage.users.those_that(shows_it)) mark_dirty(user);
}

void Scene::State::mark_users_dirty(SkinRecord& skin) noexcept
{
    if (std::exchange(skin.users_marked_in, round) == round) return;
    note_looked_at(skin.users.ids().size());
    for (NodeId user : skin.users.those_that([&](NodeId id) { return wears(id, skin); })) mark_dirty(user);
}

std::size_t Scene::looked_at() const noexcept { return state_->looked_at_so_far.load(std::memory_order_relaxed); }

bool Scene::State::is_instance_of(NodeId id, NodeId shown) const noexcept
{
    const NodeRecord* node = nodes.find(id);
    return node && node->instance_of == shown;
}

Box3d grown_by_displacement(const Cage& cage, const Box3d& box) noexcept
{
    if (box.is_empty() || !cage.is_displaced()) return box;
    const double bound = double(cage.displacement->bound) * (1 + 0x1p-18);  // displaced points are rounded
    return {box.lo - bound, box.hi + bound};
}

std::size_t Scene::State::refit_node(NodeId id, NodeRecord& node)
{
    SkinRecord* skin = skins.find(node.skin);
    if (skin) {
        if (skin->has_stale_links || node.has_stale_links) link_user(id);
        if (skin->dirty) skin->mesh_poses = poses_of(*skin);
        skin->dirty = false;
        keep_skin_moving(node.skin, *skin);
        node.node_from_skin = node_from_skin(id, *skin);
        keep_skin_in_place(id, node, *skin);
    } else if (node.has_stale_keys) {
        keep_own_keys(id, node);
    }
    Box3d bounds;
    Contents contents = own_contents(node);
    for (CageId c : node.cages) {
        const CageRecord* cage = cages.find(c);
        if (!cage) continue;
        const Box3d box = cage_bounds(node, *cage, skin);
        bounds.add(box);
        contents.poles.add(cage_poles(node, *cage, skin));
        contents.crossed += Contents::size_of(box) * cage->layers.crossed;
        if (!contents.has(Contents::Passing)) continue;
        const FaceLayers::Passing passing = node.materials.empty() ? cage->passing : passing_faces(*cage, node.materials);
        contents.held += Contents::volume_of(box) * passing.held;
        contents.passing_area += passing.area;
    }
    const auto box_of = [&](std::size_t i) {
        const Node* child = nodes.find(node.children[i]);
        return child ? box_in_parent(*child) : Box3d();
    };
    const auto contents_of = [&](std::size_t i) {
        const Node* child = nodes.find(node.children[i]);
        Contents placed;
        if (child && child->is_visible_in_shutter())
            placed.add_placed(child->contents, child->bounds, box_in_parent(*child), largest_stretch_to_parent(*child));
        // Lights are as in the middle of the shutter, where the node may be visible although none of its segments shows it.
        else if (child && child->visible) placed.kinds |= child->contents.kinds & Contents::Lights;
        return placed;
    };
    std::size_t looked_at = 0;
    if (node.child_boxes) {
        looked_at = node.child_boxes->refit(box_of, contents_of);
        bounds.add(node.child_boxes->bounds());
        contents.add(node.child_boxes->contents());
    } else {
        for (std::size_t i = 0; i < node.children.size(); ++i) bounds.add(box_of(i)), contents.add(contents_of(i));
    }
    if (const Node* target = nodes.find(node.instance_of)) {
        bounds.add(target->bounds);
        contents.add_placed(target->contents, target->bounds, target->bounds, 1);
    }
    node.bounds = bounds;
    contents.most_layers = std::max(contents.most_layers, contents.layers_in(bounds));
    contents.most_depth = std::max(contents.most_depth, contents.depth_in(bounds));
    contents.most_passed = std::max(contents.most_passed, contents.passed_in(bounds));
    node.contents = contents;
    node.dirty = false;
    return looked_at;
}

void Scene::State::push_below(NodeRecord& node, std::vector<RefitStep>& todo) const
{
    if (node.children.size() > kManyChildren) {
        if (!node.child_boxes) node.child_boxes = std::make_unique<ChildBoxes>();
        node.child_boxes->resize(node.children.size());
        node.child_boxes->for_each_stale([&](std::size_t i) { todo.push_back({node.children[i], false}); });
    } else {
        for (const NodeId child : node.children) todo.push_back({child, false});
    }
    if (node.instance_of) todo.push_back({node.instance_of, false});
}

// Visits nodes depth first without recursion, since an untrusted tree may be deep. add_node() and copy() keep the
// graph free of cycles, and a node that is reached twice is clean the second time.
std::size_t Scene::refit()
{
    State& s = *state_;
    const std::lock_guard guard(s.refitting);
    s.find_lost_bounds();
    // Frames of several renderers may read a clean scene meanwhile, so nothing is written to it, not even for lack of
    // memory.
    if (!s.nodes.find(s.root)->dirty) return 1;
    std::vector<State::RefitStep> todo{{s.root, false}};
    Rollback begun([&] { s.lose_bounds(); });
    ++s.round;
    std::size_t looked_at = 0;
    while (!todo.empty()) {
        const State::RefitStep step = todo.back();
        todo.pop_back();
        State::NodeRecord* node = s.nodes.find(step.id);
        looked_at += step.children_are_done ? 0 : 1;
        if (!node || !node->dirty) continue;
        if (step.children_are_done) {
            looked_at += s.refit_node(step.id, *node);
            continue;
        }
        todo.push_back({step.id, true});
        s.push_below(*node, todo);
    }
    begun.keep();
    return looked_at;
}

Box3d Scene::bounds()
{
    refit();
    return box_in_parent(node(root()));
}

}  // namespace occam
