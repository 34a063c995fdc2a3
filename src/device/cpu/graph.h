// SPDX-License-Identifier: Apache-2.0
// Graphs of work, and streams that capture work into a graph instead of running it.
//
// A Graph owns its nodes; a node lists the nodes it comes after. An ExecutableGraph is a copy in
// topological order, with child graphs unfolded. It runs as one piece of work of a stream, so all
// rules of stream order hold for it as a whole. Nodes run one after the other, as each node already
// uses all cores.
//
// While a stream captures, Streams::submit adds a node after the stream's tips (the nodes that
// later work depends on) instead of queueing work. An event recorded then marks these tips; a
// stream that waits for such a mark joins the capture. Read next: stream.h.
#pragma once

#include "base/error.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

namespace sunstone::device::cpu {

class Completion;
class Event;
class Graph;
class Stream;
using CompletionPtr = std::shared_ptr<Completion>;
using StreamPtr = std::shared_ptr<Stream>;

// The kind of a piece of work; numbered like CUgraphNodeType.
enum class WorkKind : unsigned {
    kKernel = 0,
    kCopy = 1,
    kSet = 2,
    kHost = 3,
    kGraph = 4,
    kEmpty = 5,
    kWaitEvent = 6,
    kRecordEvent = 7,
    kAllocate = 10,
    kFree = 11,
};

// An error of capturing or of graphs, with its number in the CUDA API.
class CaptureError : public Error {
public:
    enum Number {
        kInvalidValue = 1,
        kIllegalState = 401,
        kUnsupported = 900,
        kInvalidated = 901,
        kMerge = 902,
        kUnmatched = 903,
        kUnjoined = 904,
        kIsolation = 905,
        kImplicit = 906,
        kCapturedEvent = 907,
        kWrongThread = 908,
    };
    CaptureError(Number number, const std::string& text)
        : Error(Code::kInvalidOperation, text), number_(number) {}
    Number number() const { return number_; }

private:
    Number number_;
};

struct GraphNode {
    WorkKind kind = WorkKind::kEmpty;
    std::function<void()> work;          // not of kGraph and the event kinds
    std::vector<GraphNode*> after;       // no duplicates
    std::shared_ptr<const void> details; // parameters as the API shows them; may be null
    std::shared_ptr<Graph> child;        // of kGraph
    std::shared_ptr<Event> event;        // of the event kinds
    bool enabled = true;
    // Node attributes of the API that were set, by number.
    using AttributeBytes = std::array<unsigned char, 64>;
    std::map<int, AttributeBytes> attributes;
};

class Graph {
public:
    Graph() = default;
    Graph(const Graph&) = delete;
    Graph& operator=(const Graph&) = delete;
    ~Graph();

    // `after` are nodes of this graph.
    GraphNode* add(GraphNode node);
    // Also removes the edges from and to it.
    void remove(GraphNode* node);
    bool owns(const GraphNode* node) const;
    const std::vector<std::unique_ptr<GraphNode>>& nodes() const { return nodes_; }
    // Nodes such that each comes after those it depends on; fewer than all for a cycle.
    std::vector<GraphNode*> ordered() const;
    // A copy, including children; `twins` receives the copy of each original.
    std::shared_ptr<Graph> clone(std::unordered_map<const GraphNode*, GraphNode*>* twins) const;
    // Keeps a resource, such as memory that nodes use, alive as long as the graph.
    void keep(std::shared_ptr<void> resource) { kept_.push_back({std::move(resource)}); }
    // The same with a number of references, which add up for a handle of the client.
    void keep(std::shared_ptr<void> resource, const void* handle, size_t references);
    // Drops references to a handle; changes nothing and returns false if there are fewer.
    bool release(const void* handle, size_t references);

private:
    std::vector<std::unique_ptr<GraphNode>> nodes_;
    struct Kept {
        std::shared_ptr<void> resource;
        const void* handle = nullptr;
        size_t references = 1;
    };
    std::vector<Kept>::iterator keptOf(const void* handle);

    std::vector<Kept> kept_; // the resources are shared with clones
};

// Guards all graphs; taken to read or change one, also while capturing.
std::recursive_mutex& graphMutex();

class ExecutableGraph {
public:
    // Throws CaptureError(kInvalidValue) if the graph has a cycle.
    explicit ExecutableGraph(const Graph& graph);

    // Queues one run on the stream, after the run before it.
    static void launch(const std::shared_ptr<ExecutableGraph>& self, const StreamPtr& stream);

    // The result of update().
    struct Difference {
        enum Kind { kNone, kTopology, kNodeKind } kind = kNone;
        const GraphNode* own = nullptr;   // of the graph this was made from
        const GraphNode* other = nullptr; // of the graph compared with
    };
    // Takes over the work of a graph of the same shape, or returns the first difference.
    Difference update(const Graph& graph);
    // Replaces the work of the step made from a node of the original graph; false if there is no
    // such step of that kind.
    bool replace(const GraphNode* original, WorkKind kind, std::function<void()> work);
    bool setEnabled(const GraphNode* original, bool enabled);
    bool isEnabled(const GraphNode* original, bool& enabled) const;

private:
    struct Step {
        const GraphNode* original;
        WorkKind kind;
        std::function<void()> work;
        std::shared_ptr<Event> event;
        bool enabled;
        std::vector<size_t> after; // within its graph level, for comparison
        std::vector<Step> children;
    };
    static std::vector<Step> stepsOf(const Graph& graph);
    static Difference compare(const std::vector<Step>& own, const std::vector<Step>& other);
    static const Step* find(const std::vector<Step>& steps, const GraphNode* original);
    static void flatten(const std::vector<Step>& steps, std::vector<Step>& into);

    std::vector<Step> steps_;
    std::shared_ptr<Graph> source_; // keeps the nodes' resources
    CompletionPtr last_;
};

// A capture. The graph is guarded by graphMutex().
struct Capture {
    enum Mode { kGlobal = 0, kThreadLocal = 1, kRelaxed = 2 };
    uint64_t id = 0;
    Mode mode = kGlobal;
    std::thread::id thread;
    const Stream* origin = nullptr;
    std::shared_ptr<Graph> graph; // null after endCapture: marks of events outlive the graph
    std::atomic<bool> invalidated{false};
    std::atomic<bool> ended{false};
};

// The state of a capturing stream, and the capture and tips that the mark of an event refers to.
struct CapturedMark {
    std::shared_ptr<Capture> capture;
    std::shared_ptr<Graph> graph; // null in marks of events
    std::vector<GraphNode*> tips;
};

} // namespace sunstone::device::cpu
