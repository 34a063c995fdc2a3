// SPDX-License-Identifier: Apache-2.0
#include "bvh/relocate.h"

#include "base/error.h"
#include "bvh/build.h"
#include "bvh/build_input.h"
#include "bvh/layout.h"

namespace sunstone::bvh {
namespace {

uint64_t checkSum(const uint64_t words[3]) {
    uint64_t sum = 0x9E3779B97F4A7C15ull;
    for (int i = 0; i < 3; ++i) {
        sum = (sum ^ words[i]) * 0xFF51AFD7ED558CCDull;
        sum ^= sum >> 32;
    }
    return sum;
}

} // namespace

RelocationInfo relocationInfo(const void* block) {
    if (!isBlock(block))
        fail(Code::kInvalidValue, block, " is no acceleration structure");
    const BlockHeader& header = *headerOf(block);
    RelocationInfo info{};
    info.words[0] = uint64_t(header.version) << 32 | header.magic;
    info.words[1] = uint64_t(header.numPrimitives) << 32 | uint32_t(header.type);
    info.words[2] = header.usedSize;
    info.words[3] = checkSum(info.words);
    return info;
}

bool isRelocatable(const RelocationInfo& info) {
    return info.words[0] == (uint64_t(kBlockVersion) << 32 | kBlockMagic) &&
           info.words[3] == checkSum(info.words);
}

uint64_t relocatedSize(const RelocationInfo& info) {
    return info.words[2];
}

bool holdsInstances(const RelocationInfo& info) {
    return uint32_t(info.words[1]) == uint32_t(BlockType::kInstances);
}

uint32_t relocatedPrimitives(const RelocationInfo& info) {
    return uint32_t(info.words[1] >> 32);
}

void relocate(const RelocationInfo& info, void* block, const uint64_t* children, size_t count) {
    if (!isRelocatable(info))
        fail(Code::kInvalidValue, "the relocation info is not from this version");
    const RelocationInfo here = relocationInfo(block);
    for (int i = 0; i < 4; ++i)
        if (here.words[i] != info.words[i])
            fail(Code::kInvalidValue, "the structure at ", block,
                 " is no copy of the one that the relocation info is from");
    if (!children && count == 0)
        return;
    if (!holdsInstances(info) || count != relocatedPrimitives(info) || !children)
        fail(Code::kInvalidValue, count, " instance handles for a structure with ",
             holdsInstances(info) ? relocatedPrimitives(info) : 0, " instances");
    for (size_t i = 0; i < count; ++i)
        if (children[i] != 0 && !leadsToBlock(children[i]))
            fail(Code::kInvalidValue, "instance handle ", i, " = ",
                 reinterpret_cast<const void*>(children[i]), " leads to no acceleration structure");
    auto* records = reinterpret_cast<InstanceData*>(static_cast<uint8_t*>(block) +
                                                    headerOf(block)->instancesOffset);
    // An instance that was never hit stays so: it has no place in the tree.
    for (size_t i = 0; i < count; ++i)
        records[i].child = children[i];
}

} // namespace sunstone::bvh
