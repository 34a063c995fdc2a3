// SPDX-License-Identifier: Apache-2.0
// Relocation with the GPU's kernel on the CPU device: copies work at their new address, instances
// get new children in stream order, and memory that is not a copy is reported and left unchanged.
#include "bvh/gpu/testing/device.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sunstone::bvh::gpu {
namespace {

using testing::Buffer;
using testing::Device;
using testing::GpuStructure;

std::vector<std::string> relocate(const RelocationInfo& info, const Buffer& block,
                                  const std::vector<uint64_t>& children = {}) {
    const Device& device = Device::get();
    const Buffer handles(children.size() * sizeof(uint64_t));
    std::copy(children.begin(), children.end(), reinterpret_cast<uint64_t*>(handles.data()));
    device.builder().relocate(nullptr, info, block.address(), handles.address(), children.size());
    EXPECT_EQ(device.driver().ctxSynchronize(), CUDA_SUCCESS);
    return device.builder().takeFailures();
}

std::unique_ptr<Buffer> copyOf(const GpuStructure& s) {
    auto copy = std::make_unique<Buffer>(s.memory->size());
    std::memcpy(copy->data(), s.memory->data(), copy->size());
    return copy;
}

uint32_t hitAt(uint64_t handle, float x) {
    QueryRay ray{};
    ray.origin[0] = x;
    ray.origin[2] = -9;
    ray.direction[2] = 1;
    ray.tmax = 100;
    QueryHit hit{};
    uint32_t instance = 0;
    return testing::nearest(handle, ray, hit, &instance) ? instance : ~0u;
}

GpuStructure twoInstancesOf(uint64_t child) {
    InstanceDesc descs[2] = {};
    for (int i = 0; i < 2; ++i) {
        descs[i].transform[0] = descs[i].transform[5] = descs[i].transform[10] = 1;
        descs[i].transform[3] = 10.0f * float(i);
        descs[i].visibilityMask = 255;
        descs[i].traversableHandle = child;
    }
    InstanceInput input;
    input.instances = descs;
    input.numInstances = 2;
    BuildInputs inputs;
    inputs.instances = &input;
    return testing::buildOnDevice(inputs);
}

TEST(GpuRelocate, InstancesFindTheirMovedChildren) {
    const bvh::testing::Mesh mesh = bvh::testing::roughSphere(3, 1);
    GpuStructure sphere = testing::buildOnDevice(mesh.input());
    const GpuStructure both = twoInstancesOf(sphere.handle());
    const auto info = relocationInfo(sphere.header()), infoOfBoth = relocationInfo(both.header());
    EXPECT_TRUE(isRelocatable(info, kGpuBlockMagic));
    EXPECT_FALSE(isRelocatable(info)) << "not where structures are those of the CPU";
    EXPECT_EQ(relocatedSize(info), sphere.memory->size());
    EXPECT_TRUE(holdsInstances(infoOfBoth));
    EXPECT_EQ(relocatedPrimitives(infoOfBoth), 2u);

    const auto moved = copyOf(sphere), movedBoth = copyOf(both);
    EXPECT_TRUE(relocate(info, *moved).empty());
    const uint64_t child = moved->address() | devlib::kTagGas,
                   parent = movedBoth->address() | devlib::kTagIas;
    EXPECT_TRUE(relocate(infoOfBoth, *movedBoth).empty());
    EXPECT_EQ(hitAt(parent, 10), 1u) << "the old child is still there";
    EXPECT_TRUE(relocate(infoOfBoth, *movedBoth, {child, 0}).empty());
    std::memset(sphere.memory->data(), 0, sphere.memory->size());
    EXPECT_EQ(hitAt(parent, 0), 0u);
    EXPECT_EQ(hitAt(parent, 10), ~0u) << "an instance without child is never hit";
}

TEST(GpuRelocate, WhatIsNoCopyIsToldAndLeftAlone) {
    const bvh::testing::Mesh mesh = bvh::testing::roughSphere(3, 1),
                             other = bvh::testing::roughSphere(2, 1);
    const GpuStructure sphere = testing::buildOnDevice(mesh.input());
    const GpuStructure another = testing::buildOnDevice(other.input());
    const auto info = relocationInfo(sphere.header());
    const auto wrong = copyOf(another);
    const Buffer noise(sphere.memory->size(), 0x5A);
    for (const Buffer* target : {static_cast<const Buffer*>(wrong.get()), &noise}) {
        const std::vector<std::string> told = relocate(info, *target);
        ASSERT_EQ(told.size(), 1u);
        EXPECT_NE(told[0].find("no copy"), std::string::npos);
    }
    EXPECT_EQ(std::memcmp(wrong->data(), another.memory->data(), wrong->size()), 0);
}

TEST(GpuRelocate, HandlesOfNothingAreRefused) {
    const bvh::testing::Mesh mesh = bvh::testing::roughSphere(3, 1);
    const GpuStructure sphere = testing::buildOnDevice(mesh.input());
    const GpuStructure both = twoInstancesOf(sphere.handle());
    const auto moved = copyOf(both);
    const auto info = relocationInfo(both.header());
    const std::vector<std::string> told =
        relocate(info, *moved, {sphere.handle() + 8, devlib::kTagGas});
    ASSERT_EQ(told.size(), 2u);
    EXPECT_NE(told[0].find("no traversable"), std::string::npos);
    EXPECT_EQ(hitAt(moved->address() | devlib::kTagIas, 10), 1u) << "they keep their children";
}

} // namespace
} // namespace sunstone::bvh::gpu
