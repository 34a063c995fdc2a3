// SPDX-License-Identifier: Apache-2.0
#include "bvh/micromap/micromap_binding.h"

#include "base/error.h"
#include "base/log.h"
#include "base/readable.h"
#include "bvh/micromap/micromap_array.h"
#include "bvh/micromap/micromap_refs.h"
#include "bvh/parallel.h"

#include <algorithm>
#include <atomic>

namespace sunstone::bvh {
namespace {

constexpr size_t kBindBlock = 1u << 14;

bool wantsMicromaps(const TriangleInput& input) {
    return input.micromaps.indexing != MicromapIndexing::kNone;
}

const MicromapArrayHeader& checkedArray(const void* array, size_t input) {
    if (!isReadable(array, sizeof(MicromapArrayHeader)) || !isMicromapArray(array))
        fail(Code::kInvalidValue, "build input ", input, ": there is no opacity micromap array at ",
             array);
    const auto& header = *static_cast<const MicromapArrayHeader*>(array);
    if (!isReadable(static_cast<const uint8_t*>(array) + header.usedSize - 1, 1))
        fail(Code::kInvalidValue, "build input ", input, ": the memory at ", array,
             " ends before the opacity micromap array in it");
    return header;
}

// Reads the indices of an input, and the array's entries for them.
class RefReader {
public:
    RefReader(const MicromapInput& input, const MicromapArrayHeader& array)
        : input_(input), indices_(static_cast<const uint8_t*>(input.indices)),
          stride_(input.indexStride ? input.indexStride : input.indexSize),
          refs_(reinterpret_cast<const MicromapRef*>(reinterpret_cast<const uint8_t*>(&array) +
                                                     array.refsOffset)),
          count_(array.numMicromaps) {}

    // `valid` becomes false if the index is out of range.
    MicromapRef read(uint64_t triangle, bool& valid) const {
        const int64_t index = input_.indexing == MicromapIndexing::kIndexed
                                  ? micromapIndexAt(indices_, input_.indexSize, stride_, triangle)
                                  : int64_t(triangle);
        return micromapRefOf(index, input_.indexOffset, refs_, count_, valid);
    }

private:
    const MicromapInput& input_;
    const uint8_t* indices_;
    uint64_t stride_;
    const MicromapRef* refs_;
    uint64_t count_;
};

} // namespace

uint64_t micromapTableSize(std::span<const TriangleInput> inputs) {
    uint64_t refs = 0;
    for (const TriangleInput& input : inputs)
        if (wantsMicromaps(input))
            refs += triangleCount(input);
    const bool any = std::any_of(inputs.begin(), inputs.end(), wantsMicromaps);
    return any ? inputs.size() * sizeof(MicromapRecord) + refs * sizeof(MicromapRef) : 0;
}

void bindMicromaps(uint8_t* block, std::span<const TriangleInput> inputs) {
    // An update that fails leaves the block unchanged.
    for (size_t i = 0; i < inputs.size(); ++i)
        if (wantsMicromaps(inputs[i]))
            checkedArray(inputs[i].micromaps.array, i);
    MicromapRecord* const records = micromapRecords(block);
    uint64_t offset = headerOf(block)->micromapsOffset + inputs.size() * sizeof(MicromapRecord);
    for (size_t i = 0; i < inputs.size(); ++i) {
        records[i] = {};
        records[i].indexing = uint32_t(inputs[i].micromaps.indexing);
        if (!wantsMicromaps(inputs[i]))
            continue;
        const MicromapInput& input = inputs[i].micromaps;
        const auto& array = *static_cast<const MicromapArrayHeader*>(input.array);
        records[i].array = uint64_t(input.array);
        records[i].arraySize = array.usedSize;
        records[i].numMicromaps = array.numMicromaps;
        records[i].refsOffset = offset;
        auto* const refs = reinterpret_cast<MicromapRef*>(block + offset);
        const RefReader reader(input, array);
        std::atomic<bool> allValid{true};
        auto body = [&](size_t begin, size_t end, size_t) {
            bool valid = true;
            for (size_t k = begin; k < end; ++k)
                refs[k] = reader.read(k, valid);
            if (!valid)
                allValid = false;
        };
        const uint32_t count = triangleCount(inputs[i]);
        parallelBlocks(count, kBindBlock, body);
        if (!allValid)
            log(LogLevel::kWarning, "bvh",
                message("build input ", i,
                        ": triangles with an opacity micromap index that the "
                        "array with its ",
                        array.numMicromaps,
                        " micromaps does not have are left "
                        "without one"));
        offset += uint64_t(count) * sizeof(MicromapRef);
    }
}

void checkMicromapUpdate(const BlockHeader& header, std::span<const TriangleInput> inputs) {
    checkMicromapUpdate(hasMicromaps(header.type) ? micromapRecords(&header) : nullptr,
                        header.options & kOptionMicromapUpdate, inputs);
}

void checkMicromapUpdate(const MicromapRecord* records, bool mayChange,
                         std::span<const TriangleInput> inputs) {
    for (size_t i = 0; i < inputs.size(); ++i) {
        const MicromapInput& now = inputs[i].micromaps;
        const uint32_t indexing = records ? records[i].indexing : 0;
        if (uint32_t(now.indexing) != indexing)
            fail(Code::kInvalidValue, "build input ", i,
                 " of an update has opacity micromap indexing mode ", uint32_t(now.indexing),
                 ", the build had ", indexing);
        if (indexing && !mayChange && uint64_t(now.array) != records[i].array)
            fail(Code::kInvalidValue, "build input ", i,
                 " of an update has another opacity micromap array than the build, which lacks "
                 "ALLOW_OPACITY_MICROMAP_UPDATE");
    }
}

void requireSameArray(const BlockHeader& header, size_t i, const void* array) {
    const MicromapRecord* record = hasMicromaps(header.type) ? micromapRecords(&header) + i : nullptr;
    if (!record || !record->refsOffset)
        fail(Code::kInvalidValue, "build input ", i, " has no opacity micromaps, but ", array,
             " is to replace its array");
    const MicromapArrayHeader& found = checkedArray(array, i);
    if (found.usedSize != record->arraySize || found.numMicromaps != record->numMicromaps)
        fail(Code::kInvalidValue, "the opacity micromap array at ", array,
             " is no copy of that of "
             "build input ",
             i);
}

} // namespace sunstone::bvh
