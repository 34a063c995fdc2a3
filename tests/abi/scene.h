// SPDX-License-Identifier: Apache-2.0
// The scene that all clients render: a quad of two build inputs, one of them moved by a
// pre-transform, in two instances; a hit writes barycentrics, primitive and instance, a miss a
// constant.
#pragma once

#include "client.h"

#include <deque>

namespace tests::abi {

// Variants of the scene.
struct Variant {
    unsigned rayFlags = 0;
    unsigned geometryFlags = 0;
    unsigned instanceStride = 0; // 7.6
    bool showTime = false;
    bool overrideMotionBlur = false; // 7.0
};

// A context of release R, and the objects to render with it.
template <class R>
class Client {
public:
    Client() : table_(R::kAbi) {
        Guarded<typename R::ContextOptions> options;
        set(options->logCallbackFunction, &Log::callback);
        set(options->logCallbackData, &log_);
        set(options->logCallbackLevel, 4);
        if constexpr (R::kAbi >= 41)
            set(options->validationMode, 0);
        expect(call("DeviceContextCreate", (void*)nullptr, (const void*)options, &context_));
    }
    ~Client() { expect(call("DeviceContextDestroy", context_)); }

    void* context() const { return context_; }
    const Table& table() const { return table_; }
    std::string log() const { return log_.text; }
    template <class... Arguments>
    int call(const std::string& name, Arguments... arguments) const {
        return table_.call(name, arguments...);
    }
    void expect(int result, int expected = kSuccess) const {
        EXPECT_EQ(expected, result) << "ABI " << R::kAbi << "\n" << log_.text;
    }

    static Guarded<typename R::CompileOptions> compileOptions() {
        Guarded<typename R::CompileOptions> options;
        set(options->usesMotionBlur, 0);
        set(options->traversableGraphFlags, 0u);
        set(options->numPayloadValues, 2);
        set(options->numAttributeValues, 2);
        set(options->exceptionFlags, 0u);
        set(options->pipelineLaunchParamsVariableName, "params");
        if constexpr (R::kAbi >= 36)
            set(options->usesPrimitiveTypeFlags, 0u);
        if constexpr (R::kAbi == 47) {
            set(options->reserved, 0u);
            set(options->reserved2, 0u);
        }
        if constexpr (R::kAbi >= 68)
            set(options->allowOpacityMicromaps, 0);
        return options;
    }
    static Guarded<typename R::ModuleOptions> moduleOptions() {
        Guarded<typename R::ModuleOptions> options;
        set(options->maxRegisterCount, 0);
        set(options->optLevel, R::kOptLevel3);
        set(options->debugLevel, R::kDebugNone);
        if constexpr (R::kAbi >= 41) {
            set(options->boundValues, nullptr);
            set(options->numBoundValues, 0u);
        }
        if constexpr (R::kAbi >= 55) {
            set(options->numPayloadTypes, 0u);
            set(options->payloadTypes, nullptr);
        }
        return options;
    }

    int makeModule(const std::string& ptx, void** module,
                   Guarded<typename R::ModuleOptions>&& moduleOptions,
                   Guarded<typename R::CompileOptions>&& compileOptions) const {
        char log[4096];
        size_t logSize = sizeof(log);
        return call("ModuleCreateFromPTX", context_, (const void*)moduleOptions,
                    (const void*)compileOptions, ptx.c_str(), ptx.size(), log, &logSize, module);
    }
    int makeGroups(Guarded<ProgramGroupDesc>& descs, unsigned count, void** groups) const {
        Guarded<typename R::GroupOptions> options;
        if constexpr (R::kAbi >= 55)
            set(options->payloadType, nullptr);
        return call("ProgramGroupCreate", context_, (const void*)descs, count, (const void*)options,
                    (char*)nullptr, (size_t*)nullptr, groups);
    }
    static Guarded<typename R::LinkOptions> linkOptions() {
        Guarded<typename R::LinkOptions> options;
        set(options->maxTraceDepth, 1u);
        set(options->debugLevel, R::kDebugNone);
        if constexpr (R::kAbi < 36)
            set(options->overrideUsesMotionBlur, 0);
        return options;
    }
    int makePipeline(void** groups, unsigned count, void** pipeline,
                     Guarded<typename R::CompileOptions>&& compile = compileOptions(),
                     bool overrideMotionBlur = false) const {
        Guarded<typename R::LinkOptions> link = linkOptions();
        if constexpr (R::kAbi < 36)
            set(link->overrideUsesMotionBlur, int(overrideMotionBlur));
        return call("PipelineCreate", context_, (const void*)compile, (const void*)link, groups,
                    count, (char*)nullptr, (size_t*)nullptr, pipeline);
    }

    // Waits for queued work only with calls of this API: destroying a context waits.
    void wait() const {
        void* other = nullptr;
        expect(call("DeviceContextCreate", (void*)nullptr, (const void*)nullptr, &other));
        expect(call("DeviceContextDestroy", other));
    }
    // Builds a structure; the buffers stay with the client.
    Handle build(Guarded<BuildInput>& inputs, unsigned count, const AccelEmitDesc* emits = nullptr,
                 unsigned numEmits = 0) {
        AccelBuildOptions options{};
        options.operation = 0x2161;
        AccelBufferSizes sizes{};
        expect(call("AccelComputeMemoryUsage", context_, &options, (const void*)inputs, count,
                    &sizes));
        Memory temp(sizes.temp);
        lastOutput_ = memory_.size();
        memory_.emplace_back(sizes.output);
        Handle handle = 0;
        expect(call("AccelBuild", context_, (void*)nullptr, &options, (const void*)inputs, count,
                    temp.address(), sizes.temp, memory_.back().address(), sizes.output, &handle,
                    (const void*)emits, numEmits));
        wait();
        return handle;
    }
    // The output buffer of the last build.
    Memory& lastOutput() { return memory_[lastOutput_]; }
    template <class T>
    DevicePointer keep(const std::vector<T>& values) {
        memory_.emplace_back(values);
        return memory_.back().address();
    }
    Handle buildQuad(unsigned geometryFlags = 0);
    Handle buildInstances(Handle child, std::vector<Instance> instances, unsigned stride = 0);
    Handle buildScene(const Variant& variant);
    Image render(unsigned width, unsigned height, const Variant& variant = {});

private:
    Table table_;
    Log log_;
    void* context_ = nullptr;
    std::deque<Memory> memory_;
    size_t lastOutput_ = 0;
};

template <class R>
Handle Client<R>::buildQuad(unsigned geometryFlags) {
    const DevicePointer vertices = keep(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    const DevicePointer indices = keep(std::vector<uint32_t>{0, 1, 2, 1, 3, 2});
    // The second triangle's vertices lie to the left; its pre-transform moves it into place.
    const DevicePointer move = keep(std::vector<float>{1, 0, 0, 0.25f, 0, 1, 0, 0, 0, 0, 1, 0.5f});
    Guarded<DevicePointer> buffers;
    set(*buffers.get(), vertices);
    Guarded<unsigned> flags;
    set(*flags.get(), geometryFlags);
    Guarded<BuildInput> inputs(2);
    for (unsigned i = 0; i < 2; ++i) {
        set(inputs[i].type, 0x2141);
        TriangleArray70& t = inputs[i].triangles.common;
        set(t.vertexBuffers, buffers.get());
        set(t.numVertices, 4u);
        set(t.vertexFormat, 0x2121);
        set(t.vertexStride, 0u);
        set(t.indexBuffer, indices + i * 12);
        set(t.numIndexTriplets, 1u);
        set(t.indexFormat, 0x2103);
        set(t.indexStride, 0u);
        set(t.preTransform, i == 1 ? move : 0);
        set(t.flags, flags.get());
        set(t.numSbtRecords, 1u);
        set(t.sbtIndexOffsetBuffer, 0);
        set(t.sbtIndexOffsetSize, 0u);
        set(t.sbtIndexOffsetStride, 0u);
        set(t.primitiveIndexOffset, i * 10);
        if constexpr (R::kAbi >= 36)
            set(t.transformFormat, i == 1 ? 0x21E1 : 0);
        if constexpr (R::kAbi >= 68)
            inputs[i].triangles.micromap = {};
    }
    return build(inputs, 2);
}

template <class R>
Handle Client<R>::buildInstances(Handle child, std::vector<Instance> instances, unsigned stride) {
    for (Instance& instance : instances)
        instance.handle = child;
    Guarded<BuildInput> input;
    set(input->type, 0x2143);
    const size_t step = stride ? stride : sizeof(Instance);
    std::vector<char> bytes(step * instances.size());
    for (size_t i = 0; i < instances.size(); ++i)
        std::memcpy(&bytes[i * step], &instances[i], sizeof(Instance));
    const DevicePointer address = keep(bytes);
    if constexpr (R::kAbi < 41) {
        set(input->instances70.instances, address);
        set(input->instances70.numInstances, unsigned(instances.size()));
        set(input->instances70.aabbs, 0);
        set(input->instances70.numAabbs, 0u);
    } else {
        set(input->instances72.instances, address);
        set(input->instances72.numInstances, unsigned(instances.size()));
        if constexpr (R::kAbi >= 68)
            set(input->instances72.instanceStride, stride);
    }
    return build(input, 1);
}

template <class R>
Handle Client<R>::buildScene(const Variant& variant) {
    std::vector<Instance> instances(2);
    const float left[12] = {0.5f, 0, 0, 0, 0, 0.9f, 0, 0.05f, 0, 0, 1, 0};
    const float right[12] = {0.4f, 0.1f, 0, 0.5f, 0, 0.5f, 0, 0.3f, 0, 0, 1, 1};
    std::memcpy(instances[0].transform, left, sizeof(left));
    std::memcpy(instances[1].transform, right, sizeof(right));
    for (unsigned i = 0; i < 2; ++i) {
        instances[i].instanceId = 5 + i;
        instances[i].visibilityMask = 255;
        instances[i].sbtOffset = 2 * i;
    }
    return buildInstances(buildQuad(variant.geometryFlags), instances, variant.instanceStride);
}

template <class R>
Image Client<R>::render(unsigned width, unsigned height, const Variant& variant) {
    void* module = nullptr;
    expect(makeModule(scenePtx(R::kAbi, variant.rayFlags, variant.showTime), &module,
                      moduleOptions(), compileOptions()));
    Guarded<ProgramGroupDesc> descs(3);
    const char* names[] = {"__raygen__main", "__miss__main", "__closesthit__main"};
    const int kinds[] = {0x2421, 0x2422, 0x2424};
    for (int i = 0; i < 3; ++i) {
        set(descs[i].kind, kinds[i]);
        set(descs[i].flags, 0u);
        for (auto& program : descs[i].programs)
            program = {nullptr, nullptr};
        descs[i].programs[0] = {module, names[i]};
    }
    void* groups[3] = {};
    expect(makeGroups(descs, 3, groups));
    StackSizes sizes{};
    expect(call("ProgramGroupGetStackSize", groups[2], &sizes));
    EXPECT_GT(sizes.cssCH, 0u);
    EXPECT_EQ(sizes.cssRG, 0u);
    void* pipeline = nullptr;
    expect(makePipeline(groups, 3, &pipeline, compileOptions(), variant.overrideMotionBlur));
    expect(call("PipelineSetStackSize", pipeline, 0u, 0u, 4096u, 2u));

    struct alignas(16) Record {
        char header[32];
        unsigned data[4];
    };
    // Raygen, miss, and four hit records: instance offset + index of the build input.
    std::vector<Record> records(6);
    for (unsigned i = 0; i < 6; ++i) {
        expect(call("SbtRecordPackHeader", groups[i < 2 ? i : 2], (void*)records[i].header));
        records[i].data[0] = 31 * i;
    }
    const DevicePointer base = keep(records);
    Guarded<ShaderBindingTable> sbt;
    std::memset(sbt.get(), 0, sizeof(ShaderBindingTable));
    sbt->raygenRecord = base;
    sbt->missRecordBase = base + sizeof(Record);
    sbt->missRecordStride = sizeof(Record);
    sbt->missRecordCount = 1;
    sbt->hitgroupRecordBase = base + 2 * sizeof(Record);
    sbt->hitgroupRecordStride = sizeof(Record);
    sbt->hitgroupRecordCount = 4;

    Image image{width, height, std::vector<uint32_t>(size_t(width) * height * 2)};
    Memory output(image.words.size() * 4);
    const DevicePointer params = keep(std::vector<uint64_t>{output.address(), buildScene(variant)});
    expect(call("Launch", pipeline, (void*)nullptr, params, size_t(16), (const void*)sbt, width,
                height, 1u));
    wait();
    std::memcpy(image.words.data(), output.as<char>(), output.size());
    expect(call("PipelineDestroy", pipeline));
    for (void* group : groups)
        expect(call("ProgramGroupDestroy", group));
    expect(call("ModuleDestroy", module));
    return image;
}

} // namespace tests::abi
