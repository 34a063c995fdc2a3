// SPDX-License-Identifier: Apache-2.0
// Opacity micromaps by the GPU's builder (run on the CPU device): arrays and tables equal the
// CPU's; mismatches are reported.
#include "bvh/gpu/testing/device.h"
#include "bvh/micromap/micromap_array.h"
#include "bvh/micromap/micromap_binding.h"

#include <gtest/gtest.h>

namespace sunstone::bvh::gpu {
namespace {

using namespace bvh::testing;
using namespace gpu::testing;

// Micromaps of random levels, formats and states; every third has one state everywhere.
struct Maps {
    std::vector<MicromapHistogramEntry> histogram;
    std::vector<MicromapDesc> descriptions;
    std::vector<uint8_t> states;

    Maps(uint32_t count, uint32_t seed) {
        Random random(seed);
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t level = random.below(6);
            const auto format =
                random.below(2) ? MicromapFormat::kTwoState : MicromapFormat::kFourState;
            histogram.push_back({1, level, format});
            const bool uniform = i % 3 == 0;
            const uint8_t fill = uint8_t(filledByte(random.below(2), format));
            descriptions.push_back(
                {uint32_t(states.size()), uint16_t(level), uint16_t(uint32_t(format))});
            for (uint64_t k = 0; k < micromapBytes(level, format); ++k)
                states.push_back(uniform ? fill : uint8_t(random.below(256)));
        }
    }
    MicromapArrayInput input() const { return {histogram, states.data(), descriptions.data(), 0}; }
};

std::shared_ptr<Buffer> buildArray(const MicromapArrayInput& input, uint64_t statesSize) {
    auto memory = std::make_shared<Buffer>(micromapArraySizes(input.histogram).output);
    Device::get().builder().buildMicromapArray(nullptr, input, statesSize, memory->address(),
                                               memory->size());
    if (Device::get().driver().ctxSynchronize())
        fail(Code::kCudaError, "the build failed");
    return memory;
}

TEST(GpuMicromaps, ArraysAreThoseOfTheCpu) {
    for (const uint32_t count : {0u, 1u, 5u, 700u}) {
        SCOPED_TRACE(count);
        const Maps maps(count, 3 + count);
        const auto gpu = buildArray(maps.input(), maps.states.size());
        const auto cpu = alignedBuffer(gpu->size());
        buildMicromapArray(maps.input(), cpu.get(), gpu->size());
        EXPECT_EQ(std::memcmp(cpu.get(), gpu->data(), gpu->size()), 0);
        EXPECT_TRUE(isRelocatable(micromapRelocationInfo(gpu->data()), kGpuBlockMagic));
    }
    EXPECT_TRUE(Device::get().builder().takeFailures().empty());
}

TEST(GpuMicromaps, DescriptionsThatDoNotFitAreTold) {
    const auto expectFailure = [](const Maps& maps, uint64_t statesSize) {
        const auto array = buildArray(maps.input(), statesSize);
        EXPECT_FALSE(isMicromapArray(array->data()));
        const std::vector<std::string> told = Device::get().builder().takeFailures();
        ASSERT_EQ(told.size(), 1u);
        EXPECT_NE(told[0].find("opacity micromap array"), std::string::npos) << told[0];
    };
    const Maps good(300, 1);
    expectFailure(good, good.states.size() - 1);
    Maps bad = good;
    bad.descriptions[290].level ^= 1;
    expectFailure(bad, bad.states.size());
    bad = good;
    bad.descriptions[7].format = 3;
    expectFailure(bad, bad.states.size());
    bad = good;
    bad.descriptions[8].level = 13;
    expectFailure(bad, bad.states.size());
    bad = good;
    bad.descriptions[9].byteOffset = 0xFFFFFFF0u;
    expectFailure(bad, bad.states.size());
    const MicromapArrayInput input = good.input();
    Buffer small(128);
    EXPECT_THROW(Device::get().builder().buildMicromapArray(nullptr, input, 0, small.address(),
                                                            small.size()),
                 Error);
}

// The micromaps of each triangle in a structure.
void expectSameTables(const BuildInputs& inputs, const BuildOptions& options, const void* gpu) {
    const Structure cpu = makeStructure(inputs, options);
    const auto* const wanted = micromapRecords(cpu.block());
    const auto* const header = headerOf(gpu);
    ASSERT_NE(header->micromapsOffset, 0u);
    const auto* const bytes = static_cast<const uint8_t*>(gpu);
    const auto* const found =
        reinterpret_cast<const MicromapRecord*>(bytes + header->micromapsOffset);
    for (size_t i = 0; i < inputs.triangles.size(); ++i) {
        EXPECT_EQ(wanted[i].array, found[i].array);
        EXPECT_EQ(wanted[i].arraySize, found[i].arraySize);
        EXPECT_EQ(wanted[i].numMicromaps, found[i].numMicromaps);
        EXPECT_EQ(wanted[i].indexing, found[i].indexing);
        ASSERT_EQ(wanted[i].refsOffset != 0, found[i].refsOffset != 0);
        if (wanted[i].refsOffset)
            EXPECT_EQ(std::memcmp(static_cast<const uint8_t*>(cpu.block()) + wanted[i].refsOffset,
                                  bytes + found[i].refsOffset,
                                  inputs.triangles[i].numTriangles * sizeof(MicromapRef)),
                      0)
                << "input " << i;
    }
}

void haveThoseTheyHaveOnTheCpu(uint32_t keys) {
    const Maps maps(100, 9);
    const auto array = buildArray(maps.input(), maps.states.size());
    const Mesh a = soup(90, 0.3f, 1), b = soup(120, 0.3f, 2), c = soup(60, 0.3f, 3),
               d = soup(50, 0.3f, 4);
    std::vector<int32_t> words;
    std::vector<uint16_t> halves;
    for (int i = 0; i < 120; ++i)
        words.push_back(i % 7 == 0 ? -1 - i % 5 : i); // -5 and indices from 100 on are invalid
    for (int i = 0; i < 60; ++i) {
        halves.push_back(uint16_t(i % 5 == 0 ? -1 - i % 4 : i));
        halves.push_back(0xABCD);
    }
    TriangleInput inputs[4] = {a.input(), b.input(), c.input(), d.input()};
    inputs[0].micromaps = {MicromapIndexing::kLinear, array->data()};
    inputs[1].micromaps = {MicromapIndexing::kIndexed, array->data(), words.data(), 4, 0, 0};
    inputs[2].micromaps = {MicromapIndexing::kIndexed, array->data(), halves.data(), 2, 4, 30};
    BuildInputs all;
    all.triangles = inputs;
    std::vector<const void*> vertices[4]; // at each key
    for (int i = 0; i < 4; ++i) {
        vertices[i].assign(keys, inputs[i].vertices);
        inputs[i].keyVertices = vertices[i].data();
    }
    BuildOptions options;
    options.allowUpdate = options.allowMicromapUpdate = true;
    options.motion = {keys, 0, 0, 1};
    const GpuStructure s = buildOnDevice(all, options);
    EXPECT_EQ(isMoving(s.header().type), keys > 1);
    expectSameTables(all, options, s.memory->data());
    // An update may change indices and arrays.
    for (int32_t& w : words)
        w = (w + 3) % 90;
    const Maps others(100, 10);
    const auto second = buildArray(others.input(), others.states.size());
    inputs[0].micromaps.array = second->data();
    Buffer temp(Builder::computeMemoryUsage(all, options).tempUpdate);
    const auto update = [&](const BuildOptions& with) {
        Device::get().builder().update(nullptr, all, with, temp.address(), temp.size(),
                                       s.memory->address(), s.memory->size());
        EXPECT_EQ(Device::get().driver().ctxSynchronize(), CUDA_SUCCESS);
    };
    update(options);
    expectSameTables(all, options, s.memory->data());
    EXPECT_TRUE(Device::get().builder().takeFailures().empty());
    inputs[0].micromaps.indexing = MicromapIndexing::kNone;
    EXPECT_THROW(update(options), Error);
}

TEST(GpuMicromaps, TrianglesHaveThoseTheyHaveOnTheCpu) {
    haveThoseTheyHaveOnTheCpu(1);
}
TEST(GpuMicromaps, TrianglesThatMoveHaveThoseTheyHaveOnTheCpu) {
    haveThoseTheyHaveOnTheCpu(3);
}

TEST(GpuMicromaps, UpdatesWithoutTheOptionKeepTheirArrays) {
    const Maps maps(40, 9);
    const auto array = buildArray(maps.input(), maps.states.size()),
               other = buildArray(maps.input(), maps.states.size());
    const Mesh mesh = soup(40, 0.3f, 1);
    TriangleInput in = mesh.input();
    in.micromaps = {MicromapIndexing::kLinear, array->data()};
    BuildInputs inputs;
    inputs.triangles = {&in, 1};
    BuildOptions options;
    options.allowUpdate = true;
    const GpuStructure s = buildOnDevice(inputs, options);
    Buffer temp(Builder::computeMemoryUsage(inputs, options).tempUpdate);
    const auto update = [&] {
        Device::get().builder().update(nullptr, inputs, options, temp.address(), temp.size(),
                                       s.memory->address(), s.memory->size());
    };
    EXPECT_NO_THROW(update());
    EXPECT_EQ(Device::get().driver().ctxSynchronize(), CUDA_SUCCESS);
    in.micromaps.array = other->data();
    EXPECT_THROW(update(), Error);
}

TEST(GpuMicromaps, WhatIsNoArrayIsTold) {
    const Mesh mesh = soup(40, 0.3f, 1);
    const Buffer garbage(4096);
    TriangleInput in = mesh.input();
    in.micromaps = {MicromapIndexing::kLinear, garbage.data()};
    BuildInputs inputs;
    inputs.triangles = {&in, 1};
    const MemoryUsage usage = Builder::computeMemoryUsage(inputs, {});
    Buffer temp(usage.temp), output(usage.output);
    const Builder& builder = Device::get().builder();
    builder.build(nullptr, inputs, {}, temp.address(), usage.temp, output.address(), usage.output);
    ASSERT_EQ(Device::get().driver().ctxSynchronize(), CUDA_SUCCESS);
    EXPECT_NE(headerOf(output.data())->magic, kGpuBlockMagic);
    const std::vector<std::string> told = builder.takeFailures();
    ASSERT_EQ(told.size(), 1u);
    EXPECT_NE(told[0].find("opacityMicromapArray"), std::string::npos) << told[0];
}

} // namespace
} // namespace sunstone::bvh::gpu
