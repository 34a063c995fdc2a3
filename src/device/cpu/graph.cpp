// SPDX-License-Identifier: Apache-2.0
// See graph.h.
#include "device/cpu/graph.h"

#include "device/cpu/event.h"
#include "device/cpu/stream.h"

#include <algorithm>

namespace sunstone::device::cpu {

std::recursive_mutex& graphMutex() {
    static std::recursive_mutex* mutex = new std::recursive_mutex; // used by detached threads
    return *mutex;
}

Graph::~Graph() = default;

GraphNode* Graph::add(GraphNode node) {
    std::vector<GraphNode*> unique;
    for (GraphNode* before : node.after)
        if (std::find(unique.begin(), unique.end(), before) == unique.end())
            unique.push_back(before);
    node.after = std::move(unique);
    nodes_.push_back(std::make_unique<GraphNode>(std::move(node)));
    return nodes_.back().get();
}

void Graph::remove(GraphNode* node) {
    for (const auto& other : nodes_)
        std::erase(other->after, node);
    std::erase_if(nodes_, [&](const auto& owned) { return owned.get() == node; });
}

std::vector<Graph::Kept>::iterator Graph::keptOf(const void* handle) {
    return std::find_if(kept_.begin(), kept_.end(),
                        [&](const Kept& kept) { return kept.handle == handle; });
}

void Graph::keep(std::shared_ptr<void> resource, const void* handle, size_t references) {
    if (const auto found = keptOf(handle); found != kept_.end())
        found->references += references;
    else
        kept_.push_back({std::move(resource), handle, references});
}

bool Graph::release(const void* handle, size_t references) {
    const auto found = handle ? keptOf(handle) : kept_.end();
    if (found == kept_.end() || found->references < references)
        return false;
    found->references -= references;
    if (found->references == 0)
        kept_.erase(found);
    return true;
}

bool Graph::owns(const GraphNode* node) const {
    return std::any_of(nodes_.begin(), nodes_.end(),
                       [&](const auto& owned) { return owned.get() == node; });
}

std::vector<GraphNode*> Graph::ordered() const {
    std::unordered_map<const GraphNode*, size_t> missing;
    std::unordered_map<const GraphNode*, std::vector<GraphNode*>> next;
    std::vector<GraphNode*> result;
    for (const auto& node : nodes_) {
        missing[node.get()] = node->after.size();
        for (const GraphNode* before : node->after)
            next[before].push_back(node.get());
        if (node->after.empty())
            result.push_back(node.get());
    }
    for (size_t i = 0; i < result.size(); ++i)
        for (GraphNode* node : next[result[i]])
            if (--missing[node] == 0)
                result.push_back(node);
    return result;
}

std::shared_ptr<Graph> Graph::clone(std::unordered_map<const GraphNode*, GraphNode*>* twins) const {
    auto copy = std::make_shared<Graph>();
    std::unordered_map<const GraphNode*, GraphNode*> own;
    for (const auto& node : nodes_) {
        copy->nodes_.push_back(std::make_unique<GraphNode>(*node));
        own[node.get()] = copy->nodes_.back().get();
        if (node->child)
            copy->nodes_.back()->child = node->child->clone(nullptr);
    }
    for (const auto& node : copy->nodes_)
        for (GraphNode*& before : node->after)
            before = own.at(before);
    copy->kept_ = kept_;
    if (twins)
        *twins = std::move(own);
    return copy;
}

std::vector<ExecutableGraph::Step> ExecutableGraph::stepsOf(const Graph& graph) {
    const std::vector<GraphNode*> order = graph.ordered();
    if (order.size() != graph.nodes().size())
        throw CaptureError(CaptureError::kInvalidValue, "the graph has a cycle");
    std::unordered_map<const GraphNode*, size_t> position;
    std::vector<Step> steps;
    for (const GraphNode* node : order) {
        Step step{node, node->kind, node->work, node->event, node->enabled, {}, {}};
        for (const GraphNode* before : node->after)
            step.after.push_back(position.at(before));
        std::sort(step.after.begin(), step.after.end());
        if (node->child)
            step.children = stepsOf(*node->child);
        position[node] = steps.size();
        steps.push_back(std::move(step));
    }
    return steps;
}

ExecutableGraph::ExecutableGraph(const Graph& graph)
    : steps_(stepsOf(graph)), source_(graph.clone(nullptr)) {}

void ExecutableGraph::flatten(const std::vector<Step>& steps, std::vector<Step>& into) {
    for (const Step& step : steps) {
        if (!step.enabled)
            continue;
        if (step.kind == WorkKind::kGraph)
            flatten(step.children, into);
        else
            into.push_back(step);
    }
}

void ExecutableGraph::launch(const std::shared_ptr<ExecutableGraph>& self,
                             const StreamPtr& stream) {
    std::lock_guard lock(graphMutex());
    auto steps = std::make_shared<std::vector<Step>>();
    flatten(self->steps_, *steps);
    // Marks of events exist as soon as the launch returns, so that other streams can wait for them.
    auto marks = std::make_shared<std::vector<CompletionPtr>>(steps->size());
    std::vector<CompletionPtr> waits{self->last_};
    const bool captured = streams().isCapturing(stream);
    for (size_t i = 0; !captured && i < steps->size(); ++i) {
        const Step& step = (*steps)[i];
        if (step.kind == WorkKind::kRecordEvent) {
            (*marks)[i] = std::make_shared<Completion>();
        } else if (step.kind == WorkKind::kWaitEvent) {
            const bool recordedHere =
                std::any_of(steps->begin(), steps->begin() + ptrdiff_t(i), [&](const Step& other) {
                    return other.kind == WorkKind::kRecordEvent && other.event == step.event;
                });
            if (!recordedHere)
                waits.push_back(step.event->mark());
        }
    }
    auto run = [steps, marks, keep = self->source_] {
        std::exception_ptr error;
        for (size_t i = 0; i < steps->size(); ++i) {
            const Step& step = (*steps)[i];
            if (step.kind == WorkKind::kRecordEvent) {
                CompletionPtr mark = (*marks)[i];
                if (!mark) {
                    mark = std::make_shared<Completion>();
                    step.event->setMark(mark);
                }
                mark->finish();
            } else if (step.work && !error) {
                try {
                    step.work();
                } catch (...) {
                    error = std::current_exception(); // marks that other streams wait for still
                                                      // finish
                }
            }
        }
        if (error)
            std::rethrow_exception(error);
    };
    CompletionPtr done =
        streams().submit(stream, std::move(run), std::move(waits), {WorkKind::kGraph, nullptr});
    if (captured)
        return;
    self->last_ = std::move(done);
    for (size_t i = 0; i < steps->size(); ++i)
        if ((*marks)[i])
            (*steps)[i].event->setMark((*marks)[i]);
}

ExecutableGraph::Difference ExecutableGraph::compare(const std::vector<Step>& own,
                                                     const std::vector<Step>& other) {
    if (own.size() != other.size())
        return {Difference::kTopology, nullptr, nullptr};
    for (size_t i = 0; i < own.size(); ++i) {
        if (own[i].kind != other[i].kind)
            return {Difference::kNodeKind, own[i].original, other[i].original};
        if (own[i].after != other[i].after)
            return {Difference::kTopology, own[i].original, other[i].original};
        const Difference inner = compare(own[i].children, other[i].children);
        if (inner.kind != Difference::kNone)
            return inner;
    }
    return {};
}

ExecutableGraph::Difference ExecutableGraph::update(const Graph& graph) {
    std::lock_guard lock(graphMutex());
    std::vector<Step> steps = stepsOf(graph);
    const Difference difference = compare(steps_, steps);
    if (difference.kind != Difference::kNone)
        return difference;
    // Nodes of the source graph remain the names of the steps.
    for (size_t i = 0; i < steps.size(); ++i)
        steps[i].original = steps_[i].original;
    steps_ = std::move(steps);
    source_ = graph.clone(nullptr);
    return {};
}

const ExecutableGraph::Step* ExecutableGraph::find(const std::vector<Step>& steps,
                                                   const GraphNode* original) {
    for (const Step& step : steps) {
        if (step.original == original)
            return &step;
        if (const Step* inner = find(step.children, original))
            return inner;
    }
    return nullptr;
}

bool ExecutableGraph::replace(const GraphNode* original, WorkKind kind,
                              std::function<void()> work) {
    std::lock_guard lock(graphMutex());
    auto* step = const_cast<Step*>(find(steps_, original));
    if (!step || step->kind != kind)
        return false;
    step->work = std::move(work);
    return true;
}

bool ExecutableGraph::setEnabled(const GraphNode* original, bool enabled) {
    std::lock_guard lock(graphMutex());
    auto* step = const_cast<Step*>(find(steps_, original));
    if (!step)
        return false;
    step->enabled = enabled;
    return true;
}

bool ExecutableGraph::isEnabled(const GraphNode* original, bool& enabled) const {
    std::lock_guard lock(graphMutex());
    const Step* step = find(steps_, original);
    if (step)
        enabled = step->enabled;
    return step != nullptr;
}

} // namespace sunstone::device::cpu
