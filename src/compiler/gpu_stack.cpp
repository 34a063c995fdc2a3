// SPDX-License-Identifier: Apache-2.0
// See gpu_stack.h.
#include "compiler/gpu_stack.h"

#include "compiler/gpu_pipeline.h"

#include <llvm/IR/InstrTypes.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/Module.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sunstone::compiler {

namespace {

constexpr const char* kTrace = "sunstone_gpu_trace";

// Of a function beside what the code generator puts into its frame: registers that it saves, and
// what the driver's compiler spills.
constexpr uint64_t kSaved = 576;

using Frames = std::map<std::string, uint64_t, std::less<>>;

// Of ".func (.param ...) name(".
std::string_view nameIn(std::string_view declaration) {
    size_t begin = std::string_view(".func ").size();
    const auto skipSpace = [&] {
        while (begin < declaration.size() && std::isspace(uint8_t(declaration[begin])))
            ++begin;
    };
    skipSpace();
    if (declaration.substr(begin).starts_with("("))
        begin = std::min(declaration.find(')', begin) + 1, declaration.size());
    skipSpace();
    const size_t end = declaration.find_first_of("( \t\n", begin);
    return declaration.substr(begin, end - begin);
}

// The code generator declares each function's frame as __local_depotN[bytes] behind its name.
Frames framesOf(std::string_view text) {
    constexpr std::string_view kFunction = ".func ", kDepot = "__local_depot";
    Frames frames;
    for (size_t at = text.find(kFunction); at != text.npos;) {
        const size_t next = text.find(kFunction, at + 1);
        std::string_view function = text.substr(at, next - at);
        at = next;
        function = function.substr(0, function.find(".entry "));
        const size_t body = function.find('{');
        if (body == function.npos)
            continue; // declared only
        const size_t depot = function.find(kDepot);
        const size_t bracket = depot == text.npos ? text.npos : function.find('[', depot);
        if (bracket != text.npos)
            frames.emplace(nameIn(function.substr(0, body)),
                           std::strtoull(function.data() + bracket + 1, nullptr, 10));
    }
    return frames;
}

// The functions of a module and who calls whom, but for calls of the tracing function.
class CallGraph {
public:
    CallGraph(const llvm::Module& module, const Frames& frames) {
        for (const llvm::Function& function : module) {
            if (function.isDeclaration())
                continue;
            const std::string name = function.getName().str();
            const auto frame = frames.find(name);
            const bool isKernel = name == kGpuKernel;
            nodes_.emplace(&function,
                           Node{isKernel ? 0
                                         : kSaved + (frame == frames.end() ? 0 : frame->second)});
            if (!isKernel && function.hasAddressTaken())
                byAddress_.push_back(&function);
        }
        for (auto& [function, node] : nodes_)
            for (const llvm::Instruction& instruction : llvm::instructions(*function))
                if (const auto* call = llvm::dyn_cast<llvm::CallBase>(&instruction))
                    addCall(node, *call);
        for (auto& [function, node] : nodes_)
            visit(function, node);
    }

    // The most bytes from the start of this function on; with `upToTraces`, to where rays are traced.
    uint64_t bytesFrom(const llvm::Function* function, bool upToTraces) const {
        const auto found = nodes_.find(function);
        if (found == nodes_.end())
            return 0;
        return upToTraces ? found->second.toTrace.value_or(0) : found->second.toEnd;
    }

private:
    struct Node {
        uint64_t bytes;
        std::set<const llvm::Function*> callees = {};
        bool traces = false; // calls the tracing function itself
        // Strongly connected functions are found by Tarjan's algorithm (1972).
        unsigned order = 0, lowest = 0;
        bool isOpen = false;
        uint64_t toEnd = 0;
        std::optional<uint64_t> toTrace = {}; // none: nothing below traces
    };

    void addCall(Node& node, const llvm::CallBase& call) {
        if (call.isInlineAsm())
            return;
        if (const llvm::Function* callee = call.getCalledFunction()) {
            if (callee->getName() == kTrace)
                node.traces = true;
            else if (nodes_.count(callee))
                node.callees.insert(callee);
        } else {
            node.callees.insert(byAddress_.begin(), byAddress_.end());
        }
    }

    void visit(const llvm::Function* function, Node& node) {
        if (node.order)
            return;
        node.order = node.lowest = ++count_;
        node.isOpen = true;
        open_.push_back(function);
        for (const llvm::Function* callee : node.callees) {
            Node& other = nodes_.at(callee);
            visit(callee, other);
            if (other.isOpen)
                node.lowest = std::min(node.lowest, other.lowest);
        }
        if (node.lowest != node.order)
            return;
        // All that call each other in a circle count as one function.
        std::vector<Node*> circle;
        for (bool isLast = false; !isLast; open_.pop_back()) {
            circle.push_back(&nodes_.at(open_.back()));
            circle.back()->isOpen = false;
            isLast = open_.back() == function;
        }
        uint64_t own = 0, below = 0;
        std::optional<uint64_t> toTrace;
        for (const Node* member : circle) {
            own += member->bytes;
            if (member->traces)
                toTrace = std::max(toTrace.value_or(0), uint64_t(0));
            for (const llvm::Function* callee : member->callees) {
                const Node& other = nodes_.at(callee);
                below = std::max(below, other.toEnd); // 0 within the circle
                if (other.toTrace)
                    toTrace = std::max(toTrace.value_or(0), *other.toTrace);
            }
        }
        for (Node* member : circle) {
            member->toEnd = own + below;
            if (toTrace)
                member->toTrace = own + *toTrace;
        }
    }

    std::map<const llvm::Function*, Node> nodes_;
    std::vector<const llvm::Function*> byAddress_, open_;
    unsigned count_ = 0;
};

} // namespace

GpuStack gpuStackOf(const llvm::Module& module, std::string_view ptx) {
    const CallGraph graph(module, framesOf(ptx));
    const llvm::Function *kernel = module.getFunction(kGpuKernel), *trace = module.getFunction(kTrace);
    return {graph.bytesFrom(kernel, false), graph.bytesFrom(trace, true),
            graph.bytesFrom(trace, false)};
}

} // namespace sunstone::compiler
