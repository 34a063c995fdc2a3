// SPDX-License-Identifier: Apache-2.0
// Numbers, flags, limits, names and the function table of each ABI.
#include "scene.h"

#include <random>
#include <set>

namespace tests::abi {
namespace {

template <class R>
class Rules : public testing::Test {
protected:
    static constexpr int kAbi = R::kAbi;
    // The result of making a module with one change to its options.
    template <class Change>
    int moduleWith(Change change) const {
        auto module = Client<R>::moduleOptions();
        auto compile = Client<R>::compileOptions();
        change(*module.get(), *compile.get());
        void* made = nullptr;
        const int result =
            client_.makeModule(scenePtx(kAbi), &made, std::move(module), std::move(compile));
        EXPECT_EQ(result == kSuccess, made != nullptr);
        return result;
    }
    int optLevel(int level) const {
        return moduleWith([&](auto& module, auto&) { set(module.optLevel, level); });
    }
    int debugLevel(int level) const {
        return moduleWith([&](auto& module, auto&) { set(module.debugLevel, level); });
    }
    int payloadValues(int count) const {
        return moduleWith([&](auto&, auto& compile) { set(compile.numPayloadValues, count); });
    }
    // The result of the memory-usage query for one input.
    int usage(Guarded<BuildInput>& input, unsigned buildFlags = 0) const {
        AccelBuildOptions options{};
        options.buildFlags = buildFlags;
        options.operation = 0x2161;
        AccelBufferSizes sizes{};
        return client_.call("AccelComputeMemoryUsage", client_.context(), &options,
                            (const void*)input, 1u, &sizes);
    }
    int boxUsage(unsigned geometryFlags, unsigned buildFlags) const {
        Guarded<BuildInput> input;
        set(input->type, 0x2142);
        input->customs = {};
        input->customs.numPrimitives = 1;
        input->customs.flags = &geometryFlags;
        input->customs.numSbtRecords = 1;
        return usage(input, buildFlags);
    }
    int instanceUsage(unsigned count) const {
        Guarded<BuildInput> input;
        set(input->type, 0x2143);
        if (kAbi < 41)
            input->instances70 = {0, count, 0xA5A5A5A5u, 0, 0, 0xA5A5A5A5u};
        else
            input->instances72 = {0, count, kAbi < 68 ? 0xA5A5A5A5u : 0};
        return usage(input);
    }
    unsigned property(int id) const {
        unsigned value = 0;
        EXPECT_EQ(kSuccess, client_.call("DeviceContextGetProperty", client_.context(), id,
                                         (void*)&value, sizeof(value)));
        return value;
    }
    std::string errorName(int result) const {
        return client_.table().template function<const char*(int)>("GetErrorName")(result);
    }

    Client<R> client_;
};
using Releases =
    testing::Types<Release70, Release71, Release72, Release73, Release74, Release75, Release76>;
TYPED_TEST_SUITE(Rules, Releases);

TYPED_TEST(Rules, TableHasItsSize) {
    constexpr size_t kSize = TypeParam::kTableSize, kSlots = kSize / sizeof(void*);
    EXPECT_EQ(kSlots, slotsOf(this->kAbi).size());
    void* table[64] = {};
    for (size_t wrong : {size_t(0), kSize - 8, kSize - 1, kSize + 1, kSize + 8, sizeof(table)})
        EXPECT_EQ(7802, queryFunction()(this->kAbi, 0, nullptr, nullptr, table, wrong)) << wrong;
    for (void* slot : table)
        EXPECT_EQ(nullptr, slot) << "written by a refused call";
    ASSERT_EQ(kSuccess, queryFunction()(this->kAbi, 0, nullptr, nullptr, table, kSize));
    for (size_t i = 0; i < std::size(table); ++i)
        EXPECT_EQ(i < kSlots, table[i] != nullptr) << "slot " << i;
}

// Every slot, called with null arguments or invalid handles, returns an error.
TYPED_TEST(Rules, SlotsRefuseGarbage) {
    using Slot = int(const void*, size_t, size_t, size_t, size_t, size_t, size_t, size_t, size_t,
                     size_t, size_t, size_t);
    const std::vector<std::string> names = slotsOf(this->kAbi);
    const std::vector<void*>& slots = this->client_.table().slots();
    void* const context = this->client_.context();
    for (size_t i = 2; i < names.size(); ++i) {
        // A null context selects the CPU, and null options are allowed.
        if (names[i] == "DeviceContextCreate" || names[i].starts_with("reserved"))
            continue;
        const auto call = [&](const void* first) {
            return reinterpret_cast<Slot*>(slots[i])(first, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
        };
        for (const void* first : {(const void*)nullptr, (const void*)0x10, (const void*)~0ull})
            EXPECT_NE(kSuccess, call(first)) << names[i];
        if (names[i] != "DeviceContextDestroy" && names[i] != "DeviceContextSetLogCallback" &&
            !names[i].starts_with("DeviceContextSetCache"))
            EXPECT_NE(kSuccess, call(context)) << names[i];
    }
}

TYPED_TEST(Rules, ErrorNames) {
    EXPECT_EQ(this->kAbi < 68 ? "OPTIX_ERROR_ACCEL_NOT_COMPATIBLE" : "OPTIX_ERROR_NOT_COMPATIBLE",
              this->errorName(7400));
    EXPECT_EQ("OPTIX_ERROR_INVALID_PTX", this->errorName(7200));
    EXPECT_EQ(this->kAbi < 60 ? "Unrecognized OptixResult code"
                              : "OPTIX_ERROR_DEVICE_OUT_OF_MEMORY",
              this->errorName(7807));
    EXPECT_EQ("Unrecognized OptixResult code", this->errorName(7808));
}

TYPED_TEST(Rules, Limits) {
    const bool old = this->kAbi < 36;
    EXPECT_EQ(old ? (1u << 24) - 1 : (1u << 28) - 1, this->property(0x2006)) << "instance id";
    EXPECT_EQ(old ? (1u << 24) - 1 : (1u << 28) - 1, this->property(0x2009)) << "SBT offset";
    EXPECT_EQ(8u, this->property(0x2007)) << "visibility mask";
    const unsigned instances = this->property(0x2004);
    if (old)
        EXPECT_EQ(1u << 24, instances);
    else
        EXPECT_LT(1u << 24, instances);
    EXPECT_EQ(kSuccess, this->instanceUsage(instances));
    EXPECT_EQ(kInvalidValue, this->instanceUsage(instances + 1));
}

TYPED_TEST(Rules, OptimisationAndDebugLevels) {
    const bool old = this->kAbi < 36;
    for (int level : {1, 2, 3})
        EXPECT_EQ(old ? kSuccess : kInvalidValue, this->optLevel(level)) << level;
    for (int level : {0x2340, 0x2341, 0x2342, 0x2343})
        EXPECT_EQ(old ? kInvalidValue : kSuccess, this->optLevel(level)) << level;
    for (int level : {-1, 4, 0x2339, 0x2344})
        EXPECT_EQ(kInvalidValue, this->optLevel(level)) << level;
    EXPECT_EQ(kSuccess, this->optLevel(0));

    for (int level : {1, 2})
        EXPECT_EQ(old ? kSuccess : kInvalidValue, this->debugLevel(level)) << level;
    for (int level : {0x2350, 0x2351, 0x2352})
        EXPECT_EQ(old ? kInvalidValue : kSuccess, this->debugLevel(level)) << level;
    EXPECT_EQ(this->kAbi < 55 ? kInvalidValue : kSuccess, this->debugLevel(0x2353));
    for (int level : {-1, 3, 0x234F, 0x2354})
        EXPECT_EQ(kInvalidValue, this->debugLevel(level)) << level;
    EXPECT_EQ(kSuccess, this->debugLevel(0));
}

TYPED_TEST(Rules, PayloadWords) {
    const int most = this->kAbi < 55 ? 8 : 32;
    EXPECT_EQ(kSuccess, this->payloadValues(most));
    EXPECT_EQ(kInvalidValue, this->payloadValues(most + 1));
    EXPECT_EQ(kInvalidValue, this->payloadValues(-1));
}

TYPED_TEST(Rules, PrimitiveTypeFlags) {
    if constexpr (TypeParam::kAbi >= 36) {
        const auto with = [&](unsigned flags) {
            return this->moduleWith(
                [&](auto&, auto& compile) { set(compile.usesPrimitiveTypeFlags, flags); });
        };
        EXPECT_EQ(kSuccess, with(1u | 1u << 31));
        EXPECT_EQ(this->kAbi < 55 ? kInvalidValue : kSuccess, with(1u << 4)) << "Catmull-Rom";
        EXPECT_EQ(this->kAbi < 60 ? kInvalidValue : kSuccess, with(1u << 6)) << "spheres";
        EXPECT_EQ(kInvalidValue, with(1u << 7));
    }
}

TYPED_TEST(Rules, BoundValues) {
    if constexpr (TypeParam::kAbi >= 41) {
        const uint64_t value = 1;
        BoundValueEntry entry{0, 8, &value, nullptr};
        const auto with = [&](size_t offset) {
            entry.offset = offset;
            return this->moduleWith([&](auto& module, auto&) {
                set(module.boundValues, &entry);
                set(module.numBoundValues, 1u);
            });
        };
        EXPECT_EQ(kSuccess, with(8));
        EXPECT_EQ(kInvalidValue, with(9)) << "beyond the 16 bytes of the variable";
    }
}

TYPED_TEST(Rules, BuildAndGeometryFlags) {
    EXPECT_EQ(kSuccess, this->boxUsage(3, 1 | 2 | 4 | 16));
    EXPECT_EQ(this->kAbi < 47 ? kInvalidValue : kSuccess, this->boxUsage(0, 32));
    EXPECT_EQ(this->kAbi < 68 ? kInvalidValue : kSuccess, this->boxUsage(0, 64));
    EXPECT_EQ(this->kAbi < 68 ? kInvalidValue : kSuccess, this->boxUsage(0, 128));
    EXPECT_EQ(kInvalidValue, this->boxUsage(0, 256));
    EXPECT_EQ(this->kAbi < 60 ? kInvalidValue : kSuccess, this->boxUsage(4, 0));
    EXPECT_EQ(kInvalidValue, this->boxUsage(8, 0));
}

TYPED_TEST(Rules, BuildInputTypes) {
    Guarded<BuildInput> input;
    for (int type : {0x2140, 0x2145, 0x2146, 0x2147}) {
        set(input->type, type);
        const bool known = type == 0x2145 ? this->kAbi >= 36 : type == 0x2146 && this->kAbi >= 60;
        if (known)
            continue;
        EXPECT_EQ(kInvalidValue, this->usage(input)) << type;
        EXPECT_NE(std::string::npos, this->client_.log().find("is unknown in OptiX 7."))
            << this->client_.log();
    }
}

// Until 7.3 an instance may disable its transform.
TYPED_TEST(Rules, DisabledTransforms) {
    Client<TypeParam>& client = this->client_;
    std::vector<Instance> instances(1);
    const float scale[12] = {8, 0, 0, 0, 0, 8, 0, 0, 0, 0, 8, 0};
    std::memcpy(instances[0].transform, scale, sizeof(scale));
    instances[0].visibilityMask = 255;
    instances[0].flags = 64 | 0xA5A5A500;
    instances[0].handle = client.buildQuad();
    const DevicePointer address = client.keep(instances);
    Guarded<BuildInput> input;
    set(input->type, 0x2143);
    if (this->kAbi < 41)
        input->instances70 = {address, 1, 0, 0, 0, 0};
    else
        input->instances72 = {address, 1, 0};
    Memory box(6 * sizeof(float));
    const AccelEmitDesc emit{box.address(), 0x2182};
    client.build(input, 1, &emit, 1);
    const float* bounds = box.template as<float>();
    EXPECT_NEAR(this->kAbi < 55 ? 1.25f : 10.0f, bounds[3], 1e-4f);
    EXPECT_NEAR(this->kAbi < 55 ? 0.5f : 4.0f, bounds[5], 1e-4f);
}

TEST(RulesOf76, InstanceStride) {
    Client<Release76> client;
    AccelBuildOptions options{};
    options.operation = 0x2161;
    AccelBufferSizes sizes{};
    Guarded<BuildInput> input;
    const auto usage = [&](int type, unsigned stride) {
        set(input->type, type);
        input->instances72 = {0, 3, stride};
        return client.call("AccelComputeMemoryUsage", client.context(), &options,
                           (const void*)input, 1u, &sizes);
    };
    for (unsigned stride : {0u, 80u, 96u, 1u << 20})
        EXPECT_EQ(kSuccess, usage(0x2143, stride)) << stride;
    for (unsigned stride : {1u, 16u, 64u, 84u, 88u, ~0u})
        EXPECT_EQ(kInvalidValue, usage(0x2143, stride)) << stride;
    EXPECT_EQ(kSuccess, usage(0x2144, 5)) << "pointers have no stride";
}

TEST(RulesOf76, RelocateInputs) {
    Client<Release76> client;
    const Handle quad = client.buildQuad();
    Memory copy(client.lastOutput().size());
    std::memcpy(copy.as<char>(), client.lastOutput().as<char>(), copy.size());
    RelocationInfo info{};
    client.expect(client.call("AccelGetRelocationInfo", client.context(), quad, &info));
    Guarded<RelocateInput76> inputs(2);
    for (int i = 0; i < 2; ++i) {
        set(inputs[size_t(i)].type, 0x2141);
        set(inputs[size_t(i)].triangles.numSbtRecords, 1u);
        set(inputs[size_t(i)].triangles.opacityMicromapArray, 0);
    }
    Handle moved = 0;
    const auto relocate = [&](const void* given, size_t count) {
        return client.call("AccelRelocate", client.context(), (void*)nullptr, (const void*)&info,
                           given, count, copy.address(), copy.size(), &moved);
    };
    EXPECT_EQ(kInvalidValue, relocate(nullptr, 2));
    EXPECT_EQ(kInvalidValue, relocate(inputs, 0));
    set(inputs[0].type, 0x2143);
    EXPECT_EQ(kInvalidValue, relocate(inputs, 2)) << "built of triangles";
    set(inputs[0].type, 0x2141);
    client.expect(relocate(inputs, 2));
    client.wait();
    EXPECT_NE(0u, moved);
    client.expect(relocate(nullptr, 0));
    client.wait();
    info.info[2] ^= 1;
    EXPECT_EQ(kInvalidValue, relocate(nullptr, 0)) << "not an info";
    int compatible = -1;
    client.expect(client.call("CheckRelocationCompatibility", client.context(), (const void*)&info,
                              &compatible));
    EXPECT_EQ(0, compatible);
}

TYPED_TEST(Rules, Relocation) {
    Client<TypeParam>& client = this->client_;
    const Handle first = client.buildQuad();
    const Handle second = client.buildQuad();
    std::vector<Instance> instances(2);
    for (Instance& instance : instances) {
        const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        std::memcpy(instance.transform, identity, sizeof(identity));
        instance.visibilityMask = 255;
    }
    const Handle parent = client.buildInstances(first, instances);
    Memory& original = client.lastOutput();
    RelocationInfo info{};
    client.expect(client.call("AccelGetRelocationInfo", client.context(), parent, &info));
    int compatible = -1;
    const char* check =
        this->kAbi < 68 ? "AccelCheckRelocationCompatibility" : "CheckRelocationCompatibility";
    client.expect(client.call(check, client.context(), (const void*)&info, &compatible));
    EXPECT_EQ(1, compatible);

    Memory copy(original.size());
    std::memcpy(copy.template as<char>(), original.template as<char>(), copy.size());
    const DevicePointer children = client.keep(std::vector<Handle>{second, second});
    Handle moved = 0;
    const auto relocate = [&](DevicePointer handles, unsigned count) {
        if constexpr (TypeParam::kAbi < 68) {
            return client.call("AccelRelocate", client.context(), (void*)nullptr,
                               (const void*)&info, handles, size_t(count), copy.address(),
                               copy.size(), &moved);
        } else {
            Guarded<RelocateInput76> input;
            set(input->type, 0x2143);
            set(input->instances.numInstances, count);
            set(input->instances.traversableHandles, handles);
            return client.call("AccelRelocate", client.context(), (void*)nullptr,
                               (const void*)&info, (const void*)input, size_t(1), copy.address(),
                               copy.size(), &moved);
        }
    };
    EXPECT_EQ(kInvalidValue, relocate(children, 3));
    EXPECT_EQ(kInvalidValue, relocate(children + 1, 2)) << "misaligned";
    client.expect(relocate(children, 2));
    client.wait();
    EXPECT_NE(0u, moved);
    EXPECT_NE(parent, moved);
}

// Two clients in one process: each keeps its own limits and names.
TEST(RulesOfTwo, DoNotMix) {
    Client<Release70> old;
    Client<Release76> young;
    unsigned a = 0, b = 0;
    // Also through the other client's table: the table that created a context determines its
    // features.
    old.expect(young.call("DeviceContextGetProperty", old.context(), 0x2006, (void*)&a, size_t(4)));
    old.expect(old.call("DeviceContextGetProperty", young.context(), 0x2006, (void*)&b, size_t(4)));
    EXPECT_EQ((1u << 24) - 1, a);
    EXPECT_EQ((1u << 28) - 1, b);
    using Name = const char*(int);
    EXPECT_STREQ("OPTIX_ERROR_ACCEL_NOT_COMPATIBLE",
                 old.table().function<Name>("GetErrorName")(7400));
    EXPECT_STREQ("OPTIX_ERROR_NOT_COMPATIBLE", young.table().function<Name>("GetErrorName")(7400));
}

TEST(RulesOfTwo, OtherAbisAreRefused) {
    void* table[64] = {};
    const std::set<int> served = {22, 36, 41, 47, 55, 60, 68};
    std::mt19937 random(7);
    for (int i = -1; i < 200; ++i)
        for (int abi : {i, int(random())})
            if (!served.count(abi))
                EXPECT_EQ(7801, queryFunction()(abi, 0, nullptr, nullptr, table, 344)) << abi;
    for (void* slot : table)
        EXPECT_EQ(nullptr, slot);
}

} // namespace
} // namespace tests::abi
