// SPDX-License-Identifier: Apache-2.0
// See ray_states.h.
#include "compiler/gpu/ray_states.h"

#include "devlib/abi.h"

#include <llvm/IR/DataLayout.h>
#include <llvm/IR/Function.h>
#include <llvm/IR/IntrinsicInst.h>
#include <llvm/IR/Module.h>
#include <llvm/IR/Operator.h>

#include <bitset>
#include <map>
#include <optional>
#include <set>
#include <vector>

namespace sunstone::compiler {

namespace {

using devlib::Hit;
using devlib::RayState;
using llvm::Value;

constexpr uint64_t kBytes = sizeof(RayState);
// The indexed part of the state.
constexpr uint64_t kList = offsetof(RayState, hit) + offsetof(Hit, transforms),
                   kListEnd = kList + sizeof(Hit::transforms);

// A range of bytes within a state.
struct Range {
    uint64_t begin = 0, end = 0;
    bool overlaps(const Range& other) const { return begin < other.end && other.begin < end; }
    auto operator<=>(const Range&) const = default;
};

class Fields {
public:
    explicit Fields(llvm::AllocaInst& states)
        : states_(states), layout_(states.getModule()->getDataLayout()) {}

    bool fold() {
        if (!collect())
            return false;
        const bool shared = shareValues(), dropped = dropStores();
        return shared || dropped;
    }

private:
    // The place in a state that a pointer leads to: an offset, or anywhere in the state's list.
    struct Place {
        uint64_t offset = 0;
        bool isIndexed = false;
        bool operator==(const Place&) const = default;
    };

    // Finds all loads and stores; false if the states have other uses.
    bool collect() {
        places_.emplace(&states_, Place());
        std::vector<Value*> queue = {&states_};
        while (!queue.empty()) {
            Value* const pointer = queue.back();
            queue.pop_back();
            for (llvm::User* user : pointer->users()) {
                auto* const instruction = llvm::dyn_cast<llvm::Instruction>(user);
                if (!instruction || !use(*instruction, *pointer, queue))
                    return false;
            }
        }
        // At a phi or select, all inputs must come from states.
        for (const auto& [pointer, place] : places_)
            if (llvm::isa<llvm::PHINode, llvm::SelectInst>(pointer))
                for (const Value* operand : llvm::cast<llvm::User>(pointer)->operands())
                    if (operand->getType()->isPointerTy() &&
                        !places_.contains(const_cast<Value*>(operand)))
                        return false;
        return true;
    }

    bool use(llvm::Instruction& user, Value& pointer, std::vector<Value*>& queue) {
        const Place place = places_.at(&pointer);
        if (auto* load = llvm::dyn_cast<llvm::LoadInst>(&user)) {
            loads_.emplace(load, Range());
            return load->isSimple() && rangeOf(place, load->getType(), loads_[load]);
        }
        if (auto* store = llvm::dyn_cast<llvm::StoreInst>(&user)) {
            Value* const value = store->getValueOperand();
            return value != &pointer && store->isSimple() &&
                   rangeOf(place, value->getType(), stores_[store]);
        }
        if (auto* fill = llvm::dyn_cast<llvm::MemSetInst>(&user)) {
            const auto* length = llvm::dyn_cast<llvm::ConstantInt>(fill->getLength());
            if (fill->isVolatile() || !length || place.isIndexed ||
                place.offset + length->getZExtValue() > kBytes)
                return false;
            stores_[fill] = {place.offset, place.offset + length->getZExtValue()};
            return true;
        }
        if (auto* step = llvm::dyn_cast<llvm::GEPOperator>(&user))
            return move(place, *step) && reach(user, place_, queue);
        if (llvm::isa<llvm::PHINode, llvm::SelectInst>(user))
            return reach(user, place, queue);
        return llvm::isa<llvm::ICmpInst, llvm::LifetimeIntrinsic>(user);
    }

    bool rangeOf(const Place& place, llvm::Type* type, Range& range) const {
        const uint64_t size = layout_.getTypeStoreSize(type).getFixedValue();
        range = place.isIndexed ? Range{kList, kListEnd} : Range{place.offset, place.offset + size};
        return range.end <= kBytes;
    }

    // Sets place_ to the place after a step.
    bool move(Place place, llvm::GEPOperator& step) {
        const unsigned bits = layout_.getIndexTypeSizeInBits(step.getType());
        llvm::MapVector<Value*, llvm::APInt> variable;
        llvm::APInt constant(bits, 0);
        if (!step.collectOffset(layout_, bits, variable, constant))
            return false;
        for (const auto& [value, scale] : variable)
            if (scale.srem(int64_t(kBytes)) != 0) {
                if (!place.isIndexed && (place.offset < kList || place.offset >= kListEnd))
                    return false;
                place.isIndexed = true;
            }
        if (!place.isIndexed) {
            const int64_t offset = int64_t(place.offset) + constant.getSExtValue();
            place.offset = uint64_t((offset % int64_t(kBytes) + int64_t(kBytes)) % int64_t(kBytes));
        }
        if (place.isIndexed)
            place.offset = kList;
        place_ = place;
        return true;
    }

    bool reach(Value& pointer, const Place& place, std::vector<Value*>& queue) {
        const auto [known, isNew] = places_.emplace(&pointer, place);
        if (isNew)
            queue.push_back(&pointer);
        return known->second == place;
    }

    // The single value that these bytes ever get, if it is the same everywhere in the kernel.
    std::optional<Value*> valueOf(const Range& range) const {
        Value* value = nullptr;
        for (const auto& [store, bytes] : stores_) {
            if (!bytes.overlaps(range))
                continue;
            auto* const plain = llvm::dyn_cast<llvm::StoreInst>(store);
            std::set<Value*> seen;
            if (!plain || bytes != range || !meet(value, plain->getValueOperand(), range, seen))
                return std::nullopt;
        }
        if (!value)
            return std::nullopt;
        return value;
    }

    // Whether `next` is `value`, or is loaded from the same bytes of a state, or leaves the value
    // open.
    bool meet(Value*& value, Value* next, const Range& range, std::set<Value*>& seen) const {
        if (!seen.insert(next).second)
            return true;
        if (auto* load = llvm::dyn_cast<llvm::LoadInst>(next)) {
            const auto known = loads_.find(load);
            return known != loads_.end() && known->second == range;
        }
        if (auto* phi = llvm::dyn_cast<llvm::PHINode>(next)) {
            for (Value* incoming : phi->incoming_values())
                if (!meet(value, incoming, range, seen))
                    return false;
            return true;
        }
        if (auto* select = llvm::dyn_cast<llvm::SelectInst>(next))
            return meet(value, select->getTrueValue(), range, seen) &&
                   meet(value, select->getFalseValue(), range, seen);
        const auto* memory = llvm::dyn_cast<llvm::AllocaInst>(next);
        if (!llvm::isa<llvm::Constant, llvm::Argument>(next) &&
            !(memory && memory->isStaticAlloca()))
            return false;
        if (value && value != next)
            return false;
        value = next;
        return true;
    }

    bool shareValues() {
        std::map<Range, std::optional<Value*>> values;
        bool changed = false;
        for (auto entry = loads_.begin(); entry != loads_.end();) {
            const auto [load, range] = *entry;
            if (!values.contains(range))
                values[range] = range.begin == kList ? std::nullopt : valueOf(range);
            const std::optional<Value*> value = values[range];
            if (!value || (*value)->getType() != load->getType()) {
                ++entry;
                continue;
            }
            load->replaceAllUsesWith(*value);
            load->eraseFromParent();
            entry = loads_.erase(entry);
            changed = true;
        }
        return changed;
    }

    bool dropStores() {
        std::bitset<kBytes> read;
        for (const auto& [load, range] : loads_)
            for (uint64_t i = range.begin; i < range.end; ++i)
                read.set(i);
        bool changed = false;
        for (const auto& [store, range] : stores_) {
            bool isRead = false;
            for (uint64_t i = range.begin; i < range.end; ++i)
                isRead |= read[i];
            if (isRead)
                continue;
            store->eraseFromParent();
            changed = true;
        }
        return changed;
    }

    llvm::AllocaInst& states_;
    const llvm::DataLayout& layout_;
    std::map<Value*, Place> places_;
    Place place_;
    std::map<llvm::LoadInst*, Range> loads_;
    std::map<llvm::Instruction*, Range> stores_;
};

} // namespace

bool foldRayStates(llvm::AllocaInst& states) {
    return Fields(states).fold();
}

} // namespace sunstone::compiler
