// SPDX-License-Identifier: Apache-2.0
// See ray_states.h.
#include "compiler/gpu/ray_states.h"

#include "compiler/gpu/state_uses.h"

#include <llvm/Analysis/ValueTracking.h>
#include <llvm/IR/IRBuilder.h>
#include <llvm/IR/InstIterator.h>
#include <llvm/IR/IntrinsicInst.h>
#include <llvm/Transforms/Utils/BasicBlockUtils.h>

#include <algorithm>
#include <bitset>
#include <optional>
#include <set>

namespace sunstone::compiler {

namespace {

using llvm::Value;
using Range = StateUses::Range;

constexpr auto kBytes = int64_t(StateUses::kBytes);

// LLVM joins two loads into one load from a phi or select of their addresses. If one of the
// addresses leads to the states and another does not, this class separates the loads again.
class JoinedLoads {
public:
    explicit JoinedLoads(const StateUses::Arrays& states) : states_(states) {}

    void separate() {
        std::vector<llvm::LoadInst*> joined;
        for (llvm::Instruction& each : llvm::instructions(*states_.front()->getFunction()))
            if (auto* load = llvm::dyn_cast<llvm::LoadInst>(&each); load && isJoined(*load))
                joined.push_back(load);
        for (llvm::LoadInst* load : joined)
            if (auto* select = llvm::dyn_cast<llvm::SelectInst>(load->getPointerOperand()))
                separate(*load, *select);
            else
                separate(*load);
    }

private:
    bool isState(const Value* pointer) const {
        llvm::SmallVector<const Value*, 4> objects;
        llvm::getUnderlyingObjects(pointer, objects);
        return llvm::any_of(
            objects, [&](const Value* object) { return llvm::is_contained(states_, object); });
    }

    bool isJoined(const llvm::LoadInst& load) const {
        if (const auto* select = llvm::dyn_cast<llvm::SelectInst>(load.getPointerOperand()))
            return load.isSimple() &&
                   isState(select->getTrueValue()) != isState(select->getFalseValue());
        const auto* pointer = llvm::dyn_cast<llvm::PHINode>(load.getPointerOperand());
        if (!pointer || pointer->getParent() != load.getParent() || !load.isSimple())
            return false;
        for (const llvm::Instruction& each : *load.getParent()) {
            if (&each == &load)
                break;
            if (each.mayWriteToMemory())
                return false;
        }
        const auto isFromState = [&](const Value* value) { return isState(value); };
        return llvm::any_of(pointer->incoming_values(), isFromState) &&
               !llvm::all_of(pointer->incoming_values(), isFromState);
    }

    static void separate(llvm::LoadInst& load, llvm::SelectInst& select) {
        llvm::Instruction* ends[2];
        llvm::SplitBlockAndInsertIfThenElse(select.getCondition(), &load, &ends[0], &ends[1]);
        auto* value = llvm::PHINode::Create(load.getType(), 2, "", load.getParent()->begin());
        Value* const pointers[2] = {select.getTrueValue(), select.getFalseValue()};
        for (unsigned i = 0; i < 2; ++i) {
            llvm::Instruction* const part = load.clone();
            part->setOperand(0, pointers[i]);
            part->insertBefore(ends[i]);
            value->addIncoming(part, ends[i]->getParent());
        }
        load.replaceAllUsesWith(value);
        load.eraseFromParent();
        if (select.use_empty())
            select.eraseFromParent();
    }

    static void separate(llvm::LoadInst& load) {
        auto* pointer = llvm::cast<llvm::PHINode>(load.getPointerOperand());
        llvm::BasicBlock* const block = load.getParent();
        const std::vector<llvm::BasicBlock*> sources(pointer->block_begin(), pointer->block_end());
        for (llvm::BasicBlock* source : sources)
            if (source->getTerminator()->getNumSuccessors() > 1)
                llvm::SplitCriticalEdge(
                    source, block, llvm::CriticalEdgeSplittingOptions().setMergeIdenticalEdges());
        auto* value = llvm::PHINode::Create(load.getType(), pointer->getNumIncomingValues(), "",
                                            block->begin());
        std::map<llvm::BasicBlock*, llvm::LoadInst*> loads;
        for (unsigned i = 0; i < pointer->getNumIncomingValues(); ++i) {
            llvm::BasicBlock* const source = pointer->getIncomingBlock(i);
            llvm::LoadInst*& part = loads[source];
            if (!part) {
                part = llvm::cast<llvm::LoadInst>(load.clone());
                part->setOperand(0, pointer->getIncomingValue(i));
                part->insertBefore(source->getTerminator());
            }
            value->addIncoming(part, source);
        }
        load.replaceAllUsesWith(value);
        load.eraseFromParent();
        if (pointer->use_empty())
            pointer->eraseFromParent();
    }

    const StateUses::Arrays& states_;
};

class Fields {
public:
    explicit Fields(const StateUses::Arrays& states) : uses_(states) {}

    bool collect() {
        JoinedLoads(uses_.arrays).separate();
        return uses_.collect();
    }

    bool fold() {
        const bool shared = shareValues(), dropped = dropStores();
        return shared || dropped;
    }

private:
    // The single value that these bytes ever get, if it is the same everywhere in the kernel.
    std::optional<Value*> valueOf(const Range& range) const {
        Value* value = nullptr;
        for (const auto& [store, bytes] : uses_.stores) {
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

    // Arguments and memory of functions that the kernel calls can differ between rays.
    bool isSameInKernel(const Value& value) const {
        if (const auto* argument = llvm::dyn_cast<llvm::Argument>(&value))
            return argument->getParent() == &uses_.kernel();
        const auto* memory = llvm::dyn_cast<llvm::AllocaInst>(&value);
        return llvm::isa<llvm::Constant>(value) ||
               (memory && memory->isStaticAlloca() && memory->getFunction() == &uses_.kernel());
    }

    // Whether `next` agrees with `value`: it is `value`, is loaded from the same bytes of a state,
    // or is undefined.
    bool meet(Value*& value, Value* next, const Range& range, std::set<Value*>& seen) const {
        if (!seen.insert(next).second)
            return true;
        if (auto* load = llvm::dyn_cast<llvm::LoadInst>(next)) {
            const auto known = uses_.loads.find(load);
            return known != uses_.loads.end() && known->second == range;
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
        if (!isSameInKernel(*next))
            return false;
        if (value && value != next)
            return false;
        value = next;
        return true;
    }

    bool shareValues() {
        std::map<Range, std::optional<Value*>> values;
        bool changed = false;
        for (auto entry = uses_.loads.begin(); entry != uses_.loads.end();) {
            const auto [load, range] = *entry;
            if (!values.contains(range))
                values[range] = range.begin == StateUses::kList ? std::nullopt : valueOf(range);
            const std::optional<Value*> value = values[range];
            const bool isKnown = value && (llvm::isa<llvm::Constant>(*value) ||
                                           load->getFunction() == &uses_.kernel());
            if (!isKnown || (*value)->getType() != load->getType()) {
                ++entry;
                continue;
            }
            load->replaceAllUsesWith(*value);
            load->eraseFromParent();
            entry = uses_.loads.erase(entry);
            changed = true;
        }
        return changed;
    }

    bool dropStores() {
        std::bitset<StateUses::kBytes> read;
        for (const auto& [load, range] : uses_.loads)
            for (uint64_t i = range.begin; i < range.end; ++i)
                read.set(i);
        bool changed = false;
        for (const auto& [store, range] : uses_.stores) {
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

    StateUses uses_;
};

// The place of each field in a packed state.
class PackedLayout {
public:
    explicit PackedLayout(const StateUses& uses) {
        std::map<Range, uint64_t> alignments;
        for (const auto& [load, range] : uses.loads)
            widen(alignments[range], load->getAlign().value());
        for (const auto& [store, range] : uses.stores)
            if (const auto* plain = llvm::dyn_cast<llvm::StoreInst>(store))
                widen(alignments[range], plain->getAlign().value());
            else
                widen(alignments[range], 1);
        for (const auto& [range, alignment] : alignments)
            if (!fields_.empty() && range.begin < fields_.back().range.end) {
                fields_.back().range.end = std::max(fields_.back().range.end, range.end);
                widen(fields_.back().alignment, alignment);
            } else {
                fields_.push_back({range, alignment, 0});
            }
        for (Field& field : fields_) {
            const uint64_t phase = field.range.begin % field.alignment;
            const uint64_t next = (bytes_ + field.alignment - 1 - phase) / field.alignment;
            field.place = next * field.alignment + phase;
            bytes_ = field.place + field.range.end - field.range.begin;
        }
        bytes_ = (bytes_ + kStateAlignment - 1) / kStateAlignment * kStateAlignment;
    }

    static constexpr uint64_t kMostAlignment = 16; // of a load or store in PTX

    uint64_t bytes() const { return bytes_; }
    // The offset that an access to these bytes of a state adds to its address.
    int64_t shiftOf(const Range& range) const {
        for (const Field& field : fields_)
            if (range.begin >= field.range.begin && range.end <= field.range.end)
                return int64_t(field.place) - int64_t(field.range.begin);
        return 0;
    }

private:
    struct Field { // or several that some access touches together
        Range range;
        uint64_t alignment = 1, place = 0;
    };
    static void widen(uint64_t& alignment, uint64_t other) {
        alignment = std::max(alignment, std::min(other, kMostAlignment));
    }

    std::vector<Field> fields_;
    uint64_t bytes_ = 0;
};

// Rewrites addresses for packed states. A pointer into a state keeps its distance from the state's
// start; each access adds the distance by which its field has moved.
class Packing {
public:
    Packing(StateUses& uses, const PackedLayout& layout) : uses_(uses), layout_(layout) {}

    // Computes the new steps. False if a step does not determine the number of states.
    bool plan() {
        for (const auto& [pointer, place] : uses_.places)
            if (auto* step = llvm::dyn_cast<llvm::GetElementPtrInst>(pointer))
                if (!plan(*step, uses_.places.at(step->getPointerOperand()), place))
                    return false;
        return true;
    }

    void apply() {
        for (auto& [step, bytes] : steps_)
            replace(*step, bytes);
        for (const auto& [load, range] : uses_.loads) {
            load->setOperand(0, moved(*load, load->getPointerOperand(), range));
            load->setAlignment(std::min(load->getAlign(), kMost));
        }
        for (const auto& [store, range] : uses_.stores)
            if (auto* plain = llvm::dyn_cast<llvm::StoreInst>(store)) {
                plain->setOperand(1, moved(*plain, plain->getPointerOperand(), range));
                plain->setAlignment(std::min(plain->getAlign(), kMost));
            } else {
                auto* fill = llvm::cast<llvm::MemSetInst>(store);
                fill->setDest(moved(*fill, fill->getDest(), range));
                fill->setDestAlignment(llvm::Align(1));
            }
    }

private:
    static constexpr llvm::Align kMost{llvm::Align::Constant<PackedLayout::kMostAlignment>()};

    bool plan(llvm::GetElementPtrInst& step, const StateUses::Place& from,
              const StateUses::Place& to) {
        StateUses::Step bytes;
        if (!uses_.stepOf(llvm::cast<llvm::GEPOperator>(step), bytes))
            return false;
        const auto stride = int64_t(layout_.bytes());
        for (auto& [value, scale] : bytes.variable)
            if (scale.srem(kBytes) == 0)
                scale = llvm::APInt(scale.getBitWidth(),
                                    uint64_t(scale.sdiv(kBytes).getSExtValue() * stride), true);
        if (from.isIndexed) {
            if (bytes.constant <= -kBytes || bytes.constant >= kBytes)
                return false;
        } else {
            const int64_t total = int64_t(from.offset) + bytes.constant;
            const int64_t within = (total % kBytes + kBytes) % kBytes;
            if (to.isIndexed &&
                (within < int64_t(StateUses::kList) || within >= int64_t(StateUses::kListEnd)))
                return false;
            bytes.constant = (total - within) / kBytes * stride + within - int64_t(from.offset);
        }
        steps_.emplace_back(&step, std::move(bytes));
        return true;
    }

    void replace(llvm::GetElementPtrInst& step, const StateUses::Step& bytes) {
        llvm::IRBuilder<> builder(&step);
        Value* pointer = step.getPointerOperand();
        for (const auto& [value, scale] : bytes.variable)
            pointer = builder.CreateGEP(
                builder.getInt8Ty(), pointer,
                builder.CreateMul(builder.CreateSExtOrTrunc(value, builder.getInt64Ty()),
                                  builder.getInt64(scale.getZExtValue())));
        step.replaceAllUsesWith(builder.CreateGEP(builder.getInt8Ty(), pointer,
                                                  builder.getInt64(uint64_t(bytes.constant))));
        step.eraseFromParent();
    }

    Value* moved(llvm::Instruction& access, Value* pointer, const Range& range) const {
        const int64_t shift = layout_.shiftOf(range);
        llvm::IRBuilder<> builder(&access);
        return shift == 0 ? pointer
                          : builder.CreateGEP(builder.getInt8Ty(), pointer,
                                              builder.getInt64(uint64_t(shift)));
    }

    StateUses& uses_;
    const PackedLayout& layout_;
    std::vector<std::pair<llvm::GetElementPtrInst*, StateUses::Step>> steps_;
};

} // namespace

bool foldRayStates(const StateUses::Arrays& states) {
    Fields fields(states);
    return fields.collect() && fields.fold();
}

std::optional<uint64_t> packRayStates(const StateUses::Arrays& states) {
    JoinedLoads(states).separate();
    StateUses uses(states);
    if (!uses.collect())
        return std::nullopt;
    const PackedLayout layout(uses);
    Packing packing(uses, layout);
    if (!packing.plan())
        return std::nullopt;
    packing.apply();
    return layout.bytes();
}

} // namespace sunstone::compiler
