// SPDX-License-Identifier: Apache-2.0
#include "bvh/relocate.h"

#include "base/error.h"
#include "bvh/build/build.h"
#include "bvh/input/build_input.h"
#include "bvh/layout.h"
#include "bvh/micromap/micromap_array.h"
#include "bvh/micromap/micromap_binding.h"

#include <algorithm>

namespace sunstone::bvh {
namespace {

// Type and number of build inputs share a word.
constexpr uint32_t kInputsShift = 10;
constexpr uint64_t kMostInputs = (1u << (32 - kInputsShift)) - 1;

uint64_t checkSum(const uint64_t words[3]) {
    uint64_t sum = 0x9E3779B97F4A7C15ull;
    for (int i = 0; i < 3; ++i) {
        sum = (sum ^ words[i]) * 0xFF51AFD7ED558CCDull;
        sum ^= sum >> 32;
    }
    return sum;
}

} // namespace

RelocationInfo makeRelocationInfo(uint32_t magic, uint32_t version, uint32_t count,
                                  uint32_t details, uint64_t size) {
    RelocationInfo info{};
    info.words[0] = uint64_t(version) << 32 | magic;
    info.words[1] = uint64_t(count) << 32 | details;
    info.words[2] = size;
    info.words[3] = checkSum(info.words);
    return info;
}

void requireCopy(const RelocationInfo& info, const RelocationInfo& here, const void* block) {
    for (int i = 0; i < 4; ++i)
        if (here.words[i] != info.words[i])
            fail(Code::kInvalidValue, "the memory at ", block,
                 " holds no copy of what the relocation info is from");
}

RelocationInfo relocationInfo(const void* block) {
    if (!isBlock(block))
        fail(Code::kInvalidValue, block, " is no acceleration structure");
    return relocationInfo(*headerOf(block));
}

RelocationInfo relocationInfo(const BlockHeader& header) {
    return makeRelocationInfo(header.magic, header.version, header.numPrimitives,
                              uint32_t(std::min<uint64_t>(header.numInputs, kMostInputs))
                                      << kInputsShift |
                                  uint32_t(header.type),
                              header.usedSize);
}

bool isRelocatable(const RelocationInfo& info) {
    return isRelocatable(info, kBlockMagic);
}

bool isRelocatable(const RelocationInfo& info, uint32_t magic) {
    return (info.words[0] == (uint64_t(kBlockVersion) << 32 | magic) ||
            info.words[0] == (uint64_t(kMicromapVersion) << 32 | kMicromapMagic)) &&
           info.words[3] == checkSum(info.words);
}

uint64_t relocatedSize(const RelocationInfo& info) {
    return info.words[2];
}

BlockType relocatedType(const RelocationInfo& info) {
    return BlockType(info.words[1] & ((1u << kInputsShift) - 1));
}

bool holdsInstances(const RelocationInfo& info) {
    return kindOf(relocatedType(info)) == BlockType::kInstances;
}

bool hasInputs(const RelocationInfo& info, uint64_t count) {
    return uint32_t(info.words[1]) >> kInputsShift == std::min(count, kMostInputs);
}

uint32_t relocatedPrimitives(const RelocationInfo& info) {
    return uint32_t(info.words[1] >> 32);
}

namespace {

void requireStructure(const RelocationInfo& info, const void* block) {
    if (!isRelocatable(info) || holdsMicromaps(info))
        fail(Code::kInvalidValue, "the relocation info is not that of an acceleration structure of "
                                  "this version");
    requireCopy(info, relocationInfo(block), block);
}

} // namespace

void relocate(const RelocationInfo& info, void* block, const uint64_t* children, size_t count) {
    requireStructure(info, block);
    if (!children && count == 0)
        return;
    if (!holdsInstances(info) || count != relocatedPrimitives(info) || !children)
        fail(Code::kInvalidValue, count, " instance handles for a structure with ",
             holdsInstances(info) ? relocatedPrimitives(info) : 0, " instances");
    for (size_t i = 0; i < count; ++i)
        if (children[i] != 0 && !leadsToBlock(children[i]))
            fail(Code::kInvalidValue, "instance handle ", i, " = ",
                 reinterpret_cast<const void*>(children[i]), " leads to no acceleration structure");
    auto* records = reinterpret_cast<InstanceRecord*>(static_cast<uint8_t*>(block) +
                                                      headerOf(block)->instancesOffset);
    // An inactive instance stays inactive, because it has no place in the tree.
    for (size_t i = 0; i < count; ++i)
        records[i].child = children[i];
}

void relocateMicromaps(const RelocationInfo& info, void* block, const void* const* arrays,
                       size_t count) {
    requireStructure(info, block);
    const BlockHeader& header = *headerOf(block);
    const bool triangles = kindOf(header.type) == BlockType::kTriangles;
    if (!triangles || count != header.numInputs)
        fail(Code::kInvalidValue, count, " opacity micromap arrays for a structure with ",
             triangles ? header.numInputs : 0, " build inputs of triangles");
    for (size_t i = 0; i < count; ++i)
        if (arrays[i])
            requireSameArray(header, i, arrays[i]);
    for (size_t i = 0; i < count; ++i)
        if (arrays[i])
            micromapRecords(block)[i].array = uint64_t(arrays[i]);
}

} // namespace sunstone::bvh
