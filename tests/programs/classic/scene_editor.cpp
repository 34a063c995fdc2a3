// SPDX-License-Identifier: Apache-2.0
// An editor of a scene graph: nodes are added, removed, shared, moved to other parents and
// destroyed between launches, by a sequence of random steps. After each step rays look at every
// place of the scene, and what they find is compared with a model of the graph on the host. Queries
// of nodes are compared too.
#include "common.h"

#include <optixu/optixu_math_namespace.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <vector>

using namespace optix;

namespace {

constexpr int kPlaces = 32; // along x; a ray looks down at each

// A node of the model. Leaves show their mark at x = 0; what a node shows is at x + its shift.
struct Model {
    enum Kind { kLeaf, kGroup, kTransform, kSelector } kind;
    int mark = 0;
    std::vector<int> children; // of the model's list
    int shift = 0;             // of transforms
    int chosen = 0;            // of selectors
};

class Editor {
public:
    Editor() : random_(5) {
        context_->setRayTypeCount(1);
        context_->setEntryPointCount(1);
        context_->setRayGenerationProgram(0, program("look"));
        context_->setMissProgram(0, program("nothing"));
        context_["nothing_seen"]->setInt(-1);
        seen_ = context_->createBuffer(RT_BUFFER_OUTPUT, RT_FORMAT_INT, kPlaces);
        context_["seen"]->set(seen_);
        shape_ = context_->createGeometry();
        shape_->setPrimitiveCount(1);
        shape_->setBoundingBoxProgram(program("tile_bounds"));
        shape_->setIntersectionProgram(program("tile_intersect"));
        paint_ = context_->createMaterial();
        paint_->setClosestHitProgram(0, program("show_mark"));
        visit_ = program("visit_one");
        root_ = add({Model::kGroup, 0, {}, 0, 0});
        context_["top_object"]->set(groups_.at(root_));
    }
    ~Editor() { rtContextDestroy(context_->get()); }
    Editor(const Editor&) = delete;

    void step() {
        static const std::vector<void (Editor::*)()> kSteps = {
            &Editor::addLeaf,     &Editor::addLeaf,    &Editor::addParent, &Editor::addParent,
            &Editor::share,       &Editor::move,       &Editor::choose,    &Editor::mark,
            &Editor::removeChild, &Editor::destroyOne, &Editor::rescope,   &Editor::moveRoot};
        (this->*kSteps[pick(kSteps.size())])();
    }
    void check(int number) {
        context_->launch(0, kPlaces);
        const auto* found = static_cast<const int*>(seen_->map(0, RT_BUFFER_MAP_READ));
        const std::vector<int> seen(found, found + kPlaces);
        seen_->unmap();
        std::vector<int> wanted(kPlaces, -1);
        show(root_, 0, wanted);
        for (int x = 0; x < kPlaces; ++x)
            require(seen[size_t(x)] == wanted[size_t(x)],
                    "step " + std::to_string(number) + ": place " + std::to_string(x) + " shows " +
                        std::to_string(seen[size_t(x)]) + ", not " +
                        std::to_string(wanted[size_t(x)]));
        checkQueries();
    }
    size_t size() const { return nodes_.size(); }

private:
    Program program(const char* name) {
        return context_->createProgramFromPTXString(device_ptx, name);
    }
    size_t pick(size_t below) { return size_t(random_() % below); }

    // The highest mark wins: tiles of higher marks are nearer.
    void show(int id, int x, std::vector<int>& places) const {
        const Model& node = nodes_.at(id);
        if (node.kind == Model::kLeaf) {
            if (x >= 0 && x < kPlaces)
                places[size_t(x)] = std::max(places[size_t(x)], node.mark);
            return;
        }
        for (size_t i = 0; i < node.children.size(); ++i)
            if (node.kind != Model::kSelector || int(i) == node.chosen)
                show(node.children[i], x + node.shift, places);
    }

    int add(const Model& model) {
        const int id = next_++;
        nodes_[id] = model;
        switch (model.kind) {
        case Model::kLeaf: {
            GeometryInstance instance =
                context_->createGeometryInstance(shape_, &paint_, &paint_ + 1);
            instance["mark"]->setInt(model.mark);
            GeometryGroup group = context_->createGeometryGroup(&instance, &instance + 1);
            group->setAcceleration(context_->createAcceleration("NoAccel"));
            leaves_[id] = group;
            break;
        }
        case Model::kGroup:
            groups_[id] = context_->createGroup();
            groups_[id]->setAcceleration(context_->createAcceleration("Trbvh"));
            break;
        case Model::kTransform:
            transforms_[id] = context_->createTransform();
            setShift(id);
            break;
        case Model::kSelector:
            selectors_[id] = context_->createSelector();
            selectors_[id]->setVisitProgram(visit_);
            selectors_[id]["chosen"]->setInt(model.chosen);
        }
        return id;
    }
    void setShift(int id) {
        const float x = float(nodes_.at(id).shift);
        const float matrix[16] = {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        const float inverse[16] = {1, 0, 0, -x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        transforms_.at(id)->setMatrix(false, matrix, pick(2) ? inverse : nullptr);
    }
    RTobject handle(int id) {
        switch (nodes_.at(id).kind) {
        case Model::kLeaf:
            return leaves_.at(id)->get();
        case Model::kGroup:
            return groups_.at(id)->get();
        case Model::kTransform:
            return transforms_.at(id)->get();
        default:
            return selectors_.at(id)->get();
        }
    }
    void attach(int parent, int child) {
        nodes_.at(parent).children.push_back(child);
        const auto give = [&](auto& wrapper) {
            switch (nodes_.at(child).kind) {
            case Model::kLeaf:
                return void(wrapper->addChild(leaves_.at(child)));
            case Model::kGroup:
                return void(wrapper->addChild(groups_.at(child)));
            case Model::kTransform:
                return void(wrapper->addChild(transforms_.at(child)));
            default:
                wrapper->addChild(selectors_.at(child));
            }
        };
        if (nodes_.at(parent).kind == Model::kGroup) {
            give(groups_.at(parent));
            groups_.at(parent)->getAcceleration()->markDirty();
        } else {
            give(selectors_.at(parent));
        }
        markDirty();
    }
    // A change makes all groups above it dirty.
    void markDirty() {
        for (auto& [id, group] : groups_)
            group->getAcceleration()->markDirty();
    }
    // Whether the node is `other` or above it.
    bool isAbove(int id, int other) const {
        if (id == other)
            return true;
        for (const int child : nodes_.at(id).children)
            if (isAbove(child, other))
                return true;
        return false;
    }
    std::vector<int> where(const std::function<bool(const Model&)>& test) const {
        std::vector<int> found;
        for (const auto& [id, node] : nodes_)
            if (test(node))
                found.push_back(id);
        return found;
    }
    static bool isParent(const Model& node) {
        return node.kind == Model::kGroup || node.kind == Model::kSelector;
    }
    int anyParent() {
        const std::vector<int> all = where(isParent);
        return all[pick(all.size())];
    }

    // ---- steps
    void addLeaf() {
        // Below a transform of its own, as places are counted from there.
        const int leaf = add({Model::kLeaf, int(pick(90)) + 1, {}, 0, 0});
        const int transform = add({Model::kTransform, 0, {}, int(pick(kPlaces)) - 4, 0});
        setTransformChild(transform, leaf);
        attach(anyParent(), transform);
    }
    void setTransformChild(int transform, int child) {
        nodes_.at(transform).children = {child};
        switch (nodes_.at(child).kind) {
        case Model::kLeaf:
            return transforms_.at(transform)->setChild(leaves_.at(child));
        case Model::kGroup:
            return transforms_.at(transform)->setChild(groups_.at(child));
        case Model::kTransform:
            return transforms_.at(transform)->setChild(transforms_.at(child));
        default:
            transforms_.at(transform)->setChild(selectors_.at(child));
        }
    }
    void addParent() {
        const bool isGroup = pick(2) || selectors_.size() == 4; // GPUs enter as many in one another
        const auto kind = isGroup ? Model::kGroup : Model::kSelector;
        const int made = add({kind, 0, {}, 0, int(pick(3))});
        if (pick(2)) {
            attach(anyParentButNot(made), made);
            return;
        }
        const int transform = add({Model::kTransform, 0, {}, int(pick(9)) - 4, 0});
        setTransformChild(transform, made);
        attach(anyParentButNot(made), transform);
    }
    int anyParentButNot(int other) {
        const std::vector<int> all =
            where([&](const Model& node) { return isParent(node) && &node != &nodes_.at(other); });
        return all[pick(all.size())];
    }
    // One more parent for a node.
    void share() {
        const int parent = anyParent();
        const std::vector<int> all = where([](const Model&) { return true; });
        const int child = all[pick(all.size())];
        if (!isAbove(child, parent) && paths() < 200 && nodes_.at(parent).children.size() < 12)
            attach(parent, child);
    }
    // Number of paths from the root: sharing multiplies them.
    size_t paths() const {
        std::map<int, size_t> count;
        return waysBelow(root_, count);
    }
    size_t waysBelow(int id, std::map<int, size_t>& count) const {
        const auto known = count.find(id);
        if (known != count.end())
            return known->second;
        size_t ways = 1;
        for (const int child : nodes_.at(id).children)
            ways += waysBelow(child, count);
        return count[id] = ways;
    }
    void move() {
        const std::vector<int> all =
            where([](const Model& n) { return n.kind == Model::kTransform; });
        if (all.empty())
            return;
        const int id = all[pick(all.size())];
        nodes_.at(id).shift = int(pick(kPlaces)) - 4;
        setShift(id);
        markDirty();
    }
    void choose() {
        for (auto& [id, selector] : selectors_) {
            nodes_.at(id).chosen = int(pick(3));
            selector["chosen"]->setInt(nodes_.at(id).chosen);
        }
    }
    void mark() {
        for (auto& [id, leaf] : leaves_)
            if (pick(3) == 0) {
                nodes_.at(id).mark = int(pick(90)) + 1;
                leaf->getChild(0)["mark"]->setInt(nodes_.at(id).mark);
                leaf->getAcceleration()->markDirty();
            }
        markDirty();
    }
    void removeChild() {
        const int parent = anyParent();
        Model& node = nodes_.at(parent);
        if (node.children.empty())
            return;
        const size_t place = pick(node.children.size());
        if (node.kind == Model::kGroup) { // the last child fills the hole
            groups_.at(parent)->removeChild(unsigned(place));
            node.children[place] = node.children.back();
            node.children.pop_back();
        } else { // the others close the gap
            selectors_.at(parent)->removeChild(unsigned(place));
            node.children.erase(node.children.begin() + long(place));
        }
        markDirty();
    }
    // Takes a leaf out of all parents, and destroys it with its instance.
    void destroyOne() {
        const std::vector<int> all =
            where([](const Model& n) { return n.kind == Model::kTransform; });
        if (all.empty())
            return;
        const int id = all[pick(all.size())];
        for (const int parent : where(isParent))
            for (size_t i = 0; i < nodes_.at(parent).children.size();)
                if (nodes_.at(parent).children[i] == id) {
                    auto& list = nodes_.at(parent).children;
                    if (nodes_.at(parent).kind == Model::kGroup) {
                        groups_.at(parent)->removeChild(transforms_.at(id));
                        list[i] = list.back();
                        list.pop_back();
                    } else {
                        selectors_.at(parent)->removeChild(transforms_.at(id));
                        list.erase(list.begin() + long(i));
                    }
                } else {
                    ++i;
                }
        for (const int other : where([](const Model& n) { return n.kind == Model::kTransform; }))
            if (nodes_.at(other).children == std::vector<int>{id})
                return; // below another transform: it stays
        transforms_.at(id)->destroy();
        transforms_.erase(id);
        nodes_.erase(id);
        markDirty();
    }
    // The marks of leaves without one of their own come from the material, then from the context.
    void rescope() {
        for (auto& [id, leaf] : leaves_) {
            GeometryInstance instance = leaf->getChild(0);
            Variable own = instance->queryVariable("mark");
            require(bool(own), "a variable is not found");
            int value = 0;
            own->getInt(value);
            require(value == nodes_.at(id).mark, "a variable has another value");
            instance->removeVariable(own);
            require(!instance->queryVariable("mark"), "a removed variable is found");
            instance["mark"]->setInt(value);
        }
    }
    // Another root, above the present one.
    void moveRoot() {
        if (pick(4) != 0)
            return;
        const int above = add({Model::kGroup, 0, {}, 0, 0});
        attach(above, root_);
        root_ = above;
        context_["top_object"]->set(groups_.at(root_));
    }

    void checkQueries() {
        for (const auto& [id, node] : nodes_) {
            if (node.kind == Model::kTransform) {
                RTobjecttype type;
                rtTransformGetChildType(transforms_.at(id)->get(), &type);
                require(type == typeOf(node.children[0]), "a transform's child has another type");
                continue;
            }
            if (!isParent(node))
                continue;
            const bool isGroup = node.kind == Model::kGroup;
            const unsigned count =
                isGroup ? groups_.at(id)->getChildCount() : selectors_.at(id)->getChildCount();
            require(count == node.children.size(), "a node has another number of children");
            for (unsigned i = 0; i < count; ++i) {
                RTobject child = nullptr;
                if (isGroup)
                    rtGroupGetChild(groups_.at(id)->get(), i, &child);
                else
                    rtSelectorGetChild(selectors_.at(id)->get(), i, &child);
                require(child == handle(node.children[i]), "a node has another child");
                const RTobjecttype type =
                    isGroup ? groups_.at(id)->getChildType(i) : selectors_.at(id)->getChildType(i);
                require(type == typeOf(node.children[i]), "a child has another type");
            }
        }
    }
    RTobjecttype typeOf(int id) const {
        static const RTobjecttype kTypes[] = {RT_OBJECTTYPE_GEOMETRY_GROUP, RT_OBJECTTYPE_GROUP,
                                              RT_OBJECTTYPE_TRANSFORM, RT_OBJECTTYPE_SELECTOR};
        return kTypes[nodes_.at(id).kind];
    }

    std::mt19937 random_;
    Context context_ = Context::create();
    Buffer seen_;
    Geometry shape_;
    Material paint_;
    Program visit_;
    std::map<int, Model> nodes_;
    std::map<int, GeometryGroup> leaves_;
    std::map<int, Group> groups_;
    std::map<int, Transform> transforms_;
    std::map<int, Selector> selectors_;
    int next_ = 1, root_ = 0;
};

} // namespace

int main() {
    return runProgram([] {
        Editor editor;
        editor.check(0);
        for (int i = 1; i <= 150; ++i) {
            editor.step();
            editor.check(i);
        }
        require(editor.size() > 20, "the scene stays small");
    });
}
