// SPDX-License-Identifier: Apache-2.0
// All uses of arrays of RayState in the module of an optimised kernel: which bytes of a state each
// load and store touches. Addresses are followed through arithmetic and into called functions.
#pragma once

#include "devlib/abi.h"

#include <llvm/IR/DataLayout.h>
#include <llvm/IR/Instructions.h>
#include <llvm/IR/Operator.h>

#include <map>
#include <set>
#include <vector>

namespace sunstone::compiler {

class StateUses {
public:
    static constexpr uint64_t kBytes = sizeof(devlib::RayState);
    // The indexed part of a state.
    static constexpr uint64_t kList = offsetof(devlib::RayState, hit) +
                                      offsetof(devlib::Hit, transforms),
                              kListEnd = kList + sizeof(devlib::Hit::transforms);

    // A range of bytes within a state.
    struct Range {
        uint64_t begin = 0, end = 0;
        bool overlaps(const Range& other) const { return begin < other.end && other.begin < end; }
        auto operator<=>(const Range&) const = default;
    };
    // The place in a state that a pointer refers to: an offset, or any place in the indexed part.
    struct Place {
        uint64_t offset = 0;
        bool isIndexed = false;
        bool operator==(const Place&) const = default;
    };

    using Arrays = std::vector<llvm::AllocaInst*>;
    explicit StateUses(Arrays arrays); // of one kernel; at least one

    // Finds all uses. False if a state has a use other than a load, a store or a call of a known
    // function.
    bool collect();

    // A step from one pointer into the states to another, in bytes.
    struct Step {
        llvm::MapVector<llvm::Value*, llvm::APInt> variable;
        int64_t constant = 0;
    };
    bool stepOf(const llvm::GEPOperator& step, Step& result) const;

    llvm::Function& kernel() const { return *arrays.front()->getFunction(); }

    const Arrays arrays;
    std::map<llvm::Value*, Place> places;
    std::map<llvm::LoadInst*, Range> loads;
    std::map<llvm::Instruction*, Range> stores;

private:
    using Queue = std::vector<llvm::Value*>;

    bool use(llvm::Instruction& user, llvm::Value& pointer, Queue& queue);
    bool pass(llvm::CallBase& call, llvm::Value& pointer, Queue& queue);
    bool rangeOf(const Place& place, llvm::Type* type, Range& range) const;
    bool move(Place place, const llvm::GEPOperator& step, Place& result) const;
    bool reach(llvm::Value& pointer, const Place& place, Queue& queue);
    bool operandsAgree(const llvm::User& user, const Place& place) const;
    bool argumentsAgree() const;
    bool agrees(const llvm::Value& operand, const Place& place) const;
    void listCalls();

    const llvm::DataLayout& layout_;
    std::vector<llvm::CallBase*> indirectCalls_;
    std::vector<llvm::Function*> byAddress_;
};

} // namespace sunstone::compiler
