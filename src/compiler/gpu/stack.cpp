// SPDX-License-Identifier: Apache-2.0
// See gpu/stack.h.
#include "compiler/gpu/stack.h"

#include "compiler/gpu/calls_by_address.h"
#include "compiler/gpu/pipeline.h"

#include <llvm/IR/InstIterator.h>
#include <llvm/IR/InstrTypes.h>
#include <llvm/IR/Module.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <locale>
#include <optional>
#include <set>
#include <sstream>

namespace sunstone::compiler {

namespace {

constexpr const char* kTrace = "sunstone_gpu_trace";

// Bytes of a function in addition to the code generator's frame: saved registers, and spills of the
// driver's compiler.
constexpr uint64_t kSaved = 576;

using Frames = GpuCalls::Frames;

// The name in ".func (.param ...) name(".
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

// The code generator declares each function's frame as __local_depotN[bytes] after its name.
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

// Sums along calls. Functions that call one another in a circle count as one; Tarjan's algorithm
// (1972) finds them.
class Sums {
public:
    struct Node {
        uint64_t bytes = 0;
        bool traces = false;
        const std::vector<uint32_t>* callees = nullptr;
        unsigned order = 0, lowest = 0;
        bool isOpen = false;
        uint64_t toEnd = 0; // the most bytes from the function's start on
        std::optional<uint64_t> toTrace =
            {}; // to the call that traces a ray; none: no call below traces
    };

    explicit Sums(std::vector<Node> nodes) : nodes_(std::move(nodes)) {
        for (uint32_t i = 0; i < nodes_.size(); ++i)
            visit(i);
    }
    const Node& operator[](size_t i) const { return nodes_[i]; }

private:
    void visit(uint32_t function) {
        Node& node = nodes_[function];
        if (node.order)
            return;
        node.order = node.lowest = ++count_;
        node.isOpen = true;
        open_.push_back(function);
        for (const uint32_t callee : *node.callees) {
            visit(callee);
            if (nodes_[callee].isOpen)
                node.lowest = std::min(node.lowest, nodes_[callee].lowest);
        }
        if (node.lowest != node.order)
            return;
        std::vector<Node*> circle;
        for (bool isLast = false; !isLast; open_.pop_back()) {
            circle.push_back(&nodes_[open_.back()]);
            circle.back()->isOpen = false;
            isLast = open_.back() == function;
        }
        uint64_t own = 0, below = 0;
        std::optional<uint64_t> toTrace;
        for (const Node* member : circle) {
            own += member->bytes;
            if (member->traces)
                toTrace = std::max(toTrace.value_or(0), uint64_t(0));
            for (const uint32_t callee : *member->callees) {
                const Node& other = nodes_[callee];
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

    std::vector<Node> nodes_;
    std::vector<uint32_t> open_;
    unsigned count_ = 0;
};

} // namespace

GpuCalls::GpuCalls(const llvm::Module& module, std::string_view ptx) {
    const Frames frames = framesOf(ptx);
    std::map<const llvm::Function*, uint32_t> numbers;
    std::vector<const llvm::Function*> byAddress;
    for (const llvm::Function& function : module) {
        if (function.isDeclaration())
            continue;
        const auto number = uint32_t(functions_.size());
        numbers.emplace(&function, number);
        const std::string name = function.getName().str();
        const auto frame = frames.find(name);
        functions_.push_back({name, kSaved + (frame == frames.end() ? 0 : frame->second)});
        if (name != kGpuKernel && function.hasAddressTaken())
            byAddress.push_back(&function);
    }
    for (const auto& [function, number] : numbers) {
        std::set<uint32_t> callees;
        for (const llvm::Instruction& instruction : llvm::instructions(*function)) {
            const auto* call = llvm::dyn_cast<llvm::CallBase>(&instruction);
            if (!call || call->isInlineAsm())
                continue;
            const llvm::Function* callee = call->getCalledFunction();
            if (!callee) {
                for (const llvm::Function* each : byAddress)
                    if (mayCall(*call, *each))
                        callees.insert(numbers.at(each));
            } else if (callee->getName() == kTrace) {
                functions_[number].traces = true;
            } else if (const auto known = numbers.find(callee); known != numbers.end()) {
                callees.insert(known->second);
            }
        }
        functions_[number].callees.assign(callees.begin(), callees.end());
    }
}

// Name, estimate, whether it traces, callees. Processes with other locales read the text from the
// disk cache.
std::string GpuCalls::text() const {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    for (const Function& function : functions_) {
        text << function.name << ' ' << function.estimate << ' ' << function.traces;
        for (const uint32_t callee : function.callees)
            text << ' ' << callee;
        text << '\n';
    }
    return text.str();
}

GpuCalls GpuCalls::fromText(std::string_view text) {
    GpuCalls calls;
    std::istringstream lines{std::string(text)};
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        words.imbue(std::locale::classic());
        Function function;
        if (!(words >> function.name >> function.estimate >> function.traces))
            return {};
        for (uint32_t callee; words >> callee;)
            function.callees.push_back(callee);
        calls.functions_.push_back(std::move(function));
    }
    for (const Function& function : calls.functions_)
        for (const uint32_t callee : function.callees)
            if (callee >= calls.functions_.size())
                return {};
    return calls;
}

GpuStack GpuCalls::stack(const Frames& frames) const {
    std::vector<Sums::Node> nodes;
    std::optional<size_t> kernel, trace;
    for (const Function& function : functions_) {
        if (function.name == kGpuKernel)
            kernel = nodes.size();
        if (function.name == kTrace)
            trace = nodes.size();
        const auto frame = frames.find(function.name);
        Sums::Node node;
        if (function.name != kGpuKernel) // its own frame is not counted
            node.bytes = frames.empty()          ? function.estimate
                         : frame == frames.end() ? 0
                                                 : frame->second;
        node.traces = function.traces;
        node.callees = &function.callees;
        nodes.push_back(node);
    }
    const Sums sums(std::move(nodes));
    GpuStack stack;
    if (kernel)
        stack.entry = sums[*kernel].toEnd;
    if (trace) {
        stack.waiting = sums[*trace].toTrace.value_or(0);
        stack.other = sums[*trace].toEnd;
    }
    stack.isMeasured = !frames.empty();
    return stack;
}

// "... Function properties for NAME", then a line with "BYTES bytes stack frame, ...".
GpuCalls::Frames gpuFramesIn(std::string_view log) {
    constexpr std::string_view kName = "Function properties for ", kFrame = " bytes stack frame";
    Frames frames;
    for (size_t at = log.find(kName); at != log.npos;) {
        at += kName.size();
        const size_t next = log.find(kName, at);
        const std::string_view part = log.substr(at, next - at);
        const size_t end = part.find('\n'), frame = part.find(kFrame);
        if (end != part.npos && frame != part.npos && frame > end) {
            const size_t digits = part.find_last_not_of("0123456789", frame - 1) + 1;
            std::string_view name = part.substr(0, end);
            name = name.substr(0, name.find_last_not_of(" \t\r':") + 1);
            if (name.starts_with('\''))
                name.remove_prefix(1);
            frames.emplace(name, std::strtoull(part.data() + digits, nullptr, 10));
        }
        at = next;
    }
    return frames.contains(kGpuKernel) ? frames : Frames();
}

// The line after "... Function properties for NAME" has "..., BYTES bytes spill stores, ...".
uint64_t gpuSpillsIn(std::string_view log) {
    const size_t kernel = log.find(std::string("Function properties for ") + kGpuKernel);
    const size_t line = log.find('\n', kernel);
    if (kernel == log.npos || line == log.npos)
        return 0;
    const std::string_view text = log.substr(line + 1, log.find('\n', line + 1) - line - 1);
    const size_t end = text.find(" bytes spill stores");
    if (end == text.npos || end == 0)
        return 0;
    const size_t digits = text.find_last_not_of("0123456789", end - 1) + 1;
    return std::strtoull(text.data() + digits, nullptr, 10);
}

} // namespace sunstone::compiler
