// SPDX-License-Identifier: Apache-2.0
// Fuzzing of acceleration structures: all kinds of inputs, updates, compaction, relocation,
// transforms; with OptiX 7.6 also the opacity micromaps of build inputs (calls_micromap.cpp has
// their arrays).
#include "world.h"

#include <algorithm>

namespace fuzz {
namespace {

constexpr unsigned kMostKeys = 3;
constexpr unsigned kBuildFlags = FUZZ_76 ? 256 : 64; // the known ones are below
constexpr unsigned kGeometryFlags = FUZZ_76 ? 8 : 4;

std::vector<float> floats(World& w, size_t count) {
    std::vector<float> values(count);
    bool wild = w.chance(15);
    for (float& value : values)
        value = wild ? w.anyFloat() : w.coordinate();
    return values;
}

// A host array of device addresses, one for each key, each with `size` bytes of `values`.
const CUdeviceptr* keys(World& w, unsigned count, const std::vector<float>& values, size_t size) {
    std::vector<CUdeviceptr> addresses;
    for (unsigned i = 0; i < std::max(count, 1u); ++i) {
        CUdeviceptr at = w.memory(std::max(size, values.size() * 4), 16);
        std::memcpy(reinterpret_cast<void*>(at), values.data(), values.size() * 4);
        addresses.push_back(w.chance(98) ? at : w.address(size, 16));
    }
    return w.chance(98) ? w.keep(addresses) : nullptr;
}

struct Records {
    const unsigned* flags;
    unsigned count;
    CUdeviceptr buffer = 0;
    unsigned size = 0, stride = 0;
};

Records records(World& w, unsigned primitives) {
    Records r;
    r.count = 1 + w.below(3);
    std::vector<unsigned> flags(r.count);
    for (unsigned& f : flags)
        f = w.chance(90) ? w.below(kGeometryFlags) : w.any32();
    r.flags = w.chance(97) ? w.keep(flags) : nullptr;
    if (w.chance(40)) {
        r.size = w.oneOf({1u, 2u, 4u, 4u, 3u});
        r.stride = w.chance(80) ? 0 : r.size * (1 + w.below(3));
        std::vector<uint8_t> bytes(size_t(primitives) * std::max(r.size, r.stride) + 4);
        for (unsigned i = 0; i < primitives; ++i) // the low byte of each number
            bytes[size_t(i) * (r.stride ? r.stride : r.size)] =
                uint8_t(w.chance(98) ? w.below(r.count) : w.below(256));
        r.buffer = w.chance(95) ? w.upload(bytes) / 4 * 4 : w.address(bytes.size(), 4);
    }
    if (w.chance(3))
        r.count = w.any32();
    if (r.count > flags.size() && r.flags) // flags are a host array of so many words
        r.count = unsigned(flags.size());
    return r;
}

#if FUZZ_76
// Micromaps for a triangle input: of an array of this sequence, or none.
OptixBuildInputOpacityMicromap micromaps(World& w, unsigned primitives) {
    OptixBuildInputOpacityMicromap m{};
    if (w.chance(60))
        return m;
    m.indexingMode = w.enumerator({OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_LINEAR,
                                   OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED,
                                   OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED,
                                   OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_NONE});
    m.opacityMicromapArray = !w.arrays.empty() && w.chance(90)
                                 ? w.arrays[w.below(uint32_t(w.arrays.size()))].address
                                 : w.address(1 << 10);
    if (m.indexingMode == OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_NONE && w.chance(80))
        m.opacityMicromapArray = 0;
    if (m.indexingMode == OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED || w.chance(4)) {
        m.indexSizeInBytes = w.oneOf({2u, 4u, 4u, 4u, w.below(9)});
        m.indexStrideInBytes = w.chance(80) ? 0 : w.below(12);
        const size_t stride = std::max(m.indexSizeInBytes, m.indexStrideInBytes);
        std::vector<uint8_t> bytes(primitives * stride + 4);
        for (unsigned i = 0; i < primitives; ++i) { // small numbers and the predefined ones
            const int32_t index = w.chance(97) ? int32_t(w.below(8)) - 4 : int32_t(w.any32());
            std::memcpy(bytes.data() + i * stride, &index, std::min<size_t>(m.indexSizeInBytes, 4));
        }
        m.indexBuffer = w.chance(97) ? w.upload(bytes) / 4 * 4 : w.address(bytes.size(), 4);
    }
    m.indexOffset = w.chance(90) ? 0 : w.any32();
    std::vector<OptixOpacityMicromapUsageCount> counts(w.below(3));
    for (auto& entry : counts)
        entry = {w.any32(), w.chance(95) ? w.below(6) : w.any32(),
                 w.enumerator({OPTIX_OPACITY_MICROMAP_FORMAT_2_STATE,
                               OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE})};
    m.micromapUsageCounts = counts.empty() || w.chance(2) ? nullptr : w.keep(counts);
    m.numMicromapUsageCounts = unsigned(counts.size());
    return m;
}

OptixBuildInput spheres(World& w, unsigned keyCount) {
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_SPHERES;
    OptixBuildInputSphereArray& s = input.sphereArray;
    const unsigned count = 1 + w.below(40);
    s.vertexStrideInBytes = w.oneOf({0u, 12u, 16u, 7u});
    s.vertexBuffers = keys(w, keyCount, floats(w, size_t(count) * 4), 0);
    s.numVertices = w.chance(97) ? count : w.below(2 * count);
    s.radiusStrideInBytes = w.oneOf({0u, 4u, 8u});
    s.singleRadius = int(w.chance(50) ? w.below(2) : w.any32());
    s.radiusBuffers = keys(w, keyCount, floats(w, size_t(count) * 2), 0);
    Records r = records(w, count);
    s.flags = r.flags;
    s.numSbtRecords = r.count;
    s.sbtIndexOffsetBuffer = r.buffer;
    s.sbtIndexOffsetSizeInBytes = r.size;
    s.sbtIndexOffsetStrideInBytes = r.stride;
    s.primitiveIndexOffset = w.chance(90) ? 0 : w.any32();
    return input;
}
#endif

OptixBuildInput triangles(World& w, unsigned keyCount) {
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& t = input.triangleArray;
    t.vertexFormat = w.enumerator({OPTIX_VERTEX_FORMAT_FLOAT3, OPTIX_VERTEX_FORMAT_FLOAT3,
                                   OPTIX_VERTEX_FORMAT_FLOAT2, OPTIX_VERTEX_FORMAT_HALF3,
                                   OPTIX_VERTEX_FORMAT_HALF2, OPTIX_VERTEX_FORMAT_SNORM16_3,
                                   OPTIX_VERTEX_FORMAT_SNORM16_2, OPTIX_VERTEX_FORMAT_NONE});
    unsigned count = 3 * (1 + w.below(40));
    t.vertexStrideInBytes = w.oneOf({0u, 12u, 16u, 20u});
    t.vertexBuffers = keys(w, keyCount, floats(w, size_t(count) * 5), 0);
    t.numVertices = w.nearly(count);
    if (t.numVertices > count && w.chance(60)) // absurd numbers need absurd scratch memory
        t.numVertices = count;
    unsigned primitives = count / 3;
    if (w.chance(50)) {
        bool isShort = w.chance(50);
        t.indexFormat =
            isShort ? OPTIX_INDICES_FORMAT_UNSIGNED_SHORT3 : OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
        primitives = w.below(60);
        std::vector<uint32_t> wide(size_t(primitives) * 3 + 1);
        std::vector<uint16_t> narrow(wide.size() + 1);
        bool wild = w.chance(5);
        for (size_t i = 0; i < wide.size(); ++i)
            wide[i] = narrow[i] = uint16_t(wild ? w.any32() : w.below(count));
        t.indexBuffer = isShort ? w.upload(narrow) / 4 * 4 : w.upload(wide) / 4 * 4;
        if (w.chance(4))
            t.indexBuffer = w.address(size_t(primitives) * 12, 4);
        t.numIndexTriplets = w.chance(97) ? primitives : w.below(200);
        t.indexStrideInBytes = w.chance(90) ? 0 : w.below(20);
    }
    if (w.chance(20)) {
        t.transformFormat = w.enumerator({OPTIX_TRANSFORM_FORMAT_MATRIX_FLOAT12});
        t.preTransform = w.chance(95) ? w.upload(floats(w, 12)) / 16 * 16 : w.address(48, 16);
    }
    Records r = records(w, primitives);
    t.flags = r.flags;
    t.numSbtRecords = r.count;
    t.sbtIndexOffsetBuffer = r.buffer;
    t.sbtIndexOffsetSizeInBytes = r.size;
    t.sbtIndexOffsetStrideInBytes = r.stride;
    t.primitiveIndexOffset = w.chance(90) ? 0 : w.any32();
#if FUZZ_76
    t.opacityMicromap = micromaps(w, primitives);
#endif
    return input;
}

OptixBuildInput boxes(World& w, unsigned keyCount) {
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_CUSTOM_PRIMITIVES;
    OptixBuildInputCustomPrimitiveArray& c = input.customPrimitiveArray;
    unsigned count = 1 + w.below(30);
    c.strideInBytes = w.oneOf({0u, 24u, 32u});
    c.aabbBuffers = keys(w, keyCount, floats(w, size_t(count) * 8), 0);
    c.numPrimitives = w.chance(97) ? count : w.below(2 * count);
    Records r = records(w, count);
    c.flags = r.flags;
    c.numSbtRecords = r.count;
    c.sbtIndexOffsetBuffer = r.buffer;
    c.sbtIndexOffsetSizeInBytes = r.size;
    c.sbtIndexOffsetStrideInBytes = r.stride;
    c.primitiveIndexOffset = w.chance(90) ? 0 : w.any32();
    return input;
}

OptixBuildInput curves(World& w, unsigned keyCount) {
    OptixBuildInput input{};
    input.type = OPTIX_BUILD_INPUT_TYPE_CURVES;
    OptixBuildInputCurveArray& c = input.curveArray;
    c.curveType = w.enumerator(
        {OPTIX_PRIMITIVE_TYPE_ROUND_LINEAR, OPTIX_PRIMITIVE_TYPE_ROUND_QUADRATIC_BSPLINE,
         OPTIX_PRIMITIVE_TYPE_ROUND_CUBIC_BSPLINE, OPTIX_PRIMITIVE_TYPE_ROUND_CATMULLROM});
    unsigned vertices = 4 + w.below(30);
    c.numPrimitives = w.below(vertices - 2);
    c.vertexBuffers = keys(w, keyCount, floats(w, size_t(vertices) * 4), 0);
    c.widthBuffers = keys(w, keyCount, floats(w, vertices), 0);
    c.numVertices = w.chance(97) ? vertices : w.below(2 * vertices);
    c.vertexStrideInBytes = w.oneOf({0u, 12u, 16u, 7u});
    c.widthStrideInBytes = w.oneOf({0u, 4u});
    std::vector<uint32_t> indices(c.numPrimitives + 1);
    for (size_t i = 0; i < indices.size(); ++i)
        indices[i] = w.chance(97) ? w.below(vertices - 3) : w.any32();
    c.indexBuffer = w.chance(97) ? w.upload(indices) / 4 * 4 : w.address(indices.size() * 4, 4);
    c.indexStrideInBytes = w.chance(95) ? 0 : w.below(9);
    c.flag = w.chance(95) ? w.below(4) : w.any32();
    c.endcapFlags = w.chance(95) ? w.below(2) : w.any32();
    return input;
}

OptixBuildInput instances(World& w, OptixTraversableHandle self) {
    OptixBuildInput input{};
    input.type =
        w.chance(80) ? OPTIX_BUILD_INPUT_TYPE_INSTANCES : OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS;
    unsigned count = w.below(12);
    std::vector<OptixInstance> list(count);
    for (OptixInstance& i : list) {
        std::vector<float> matrix = floats(w, 12);
        bool isPlain = w.chance(60);
        for (int k = 0; k < 12; ++k)
            i.transform[k] = isPlain && k % 4 != 3 ? (k % 5 == 0) : matrix[k];
        i.instanceId = w.chance(90) ? w.below(100) : w.any32();
        i.sbtOffset = w.chance(90) ? w.below(4) : w.any32();
        i.visibilityMask = w.chance(90) ? 255 : w.any32();
        i.flags = w.chance(90) ? 0 : w.chance(60) ? w.below(128) : w.any32();
        i.traversableHandle = w.chance(3) ? self : w.traversable();
    }
    CUdeviceptr at = w.memory(list.size() * sizeof(OptixInstance), 16);
    if (count != 0)
        std::memcpy(reinterpret_cast<void*>(at), list.data(), list.size() * sizeof(OptixInstance));
    if (input.type == OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS) {
        std::vector<CUdeviceptr> pointers(count);
        for (unsigned i = 0; i < count; ++i)
            pointers[i] = w.chance(98) ? at + i * sizeof(OptixInstance) : w.address(80, 16);
        at = w.upload(pointers);
    }
    input.instanceArray.instances =
        w.chance(97) ? at : w.address(count * sizeof(OptixInstance), 16);
    input.instanceArray.numInstances = w.chance(97) ? count : w.any32();
#if FUZZ_76
    if (w.chance(5))
        input.instanceArray.instanceStride = w.oneOf({80u, 96u, 16u, 81u, w.any32()});
#endif
    return input;
}

OptixAccelBuildOptions buildOptions(World& w, unsigned& keyCount) {
    OptixAccelBuildOptions options{};
    options.buildFlags =
        w.chance(90) ? w.below(kBuildFlags) & ~(w.chance(90) ? 1u << 4 : 0u) : w.any32();
    if ((options.buildFlags & 12) == 12 && w.chance(80))
        options.buildFlags &= ~4u; // one preference
    options.operation = w.chance(97) ? OPTIX_BUILD_OPERATION_BUILD : OptixBuildOperation(w.any32());
    keyCount = 1;
    if (w.chance(12)) {
        keyCount = w.below(kMostKeys + 1);
        options.motionOptions.numKeys = uint16_t(w.chance(95) ? keyCount : w.any32());
        options.motionOptions.flags = uint16_t(w.chance(90) ? w.below(4) : w.any32());
        options.motionOptions.timeBegin = w.chance(90) ? 0.0f : w.anyFloat();
        options.motionOptions.timeEnd = w.chance(90) ? 1.0f : w.anyFloat();
        if (options.motionOptions.numKeys > keyCount) // host arrays hold this many addresses
            options.motionOptions.numKeys = uint16_t(keyCount);
    }
    return options;
}

OptixResult build(World& w, OptixDeviceContext context, OptixAccelBuildOptions options,
                  const std::vector<OptixBuildInput>& inputs, CUdeviceptr output, size_t outputSize,
                  size_t tempSize, OptixTraversableHandle& handle) {
    OptixAccelEmitDesc emit[3] = {};
    for (OptixAccelEmitDesc& e : emit) {
        e.type = w.enumerator({OPTIX_PROPERTY_TYPE_AABBS, OPTIX_PROPERTY_TYPE_COMPACTED_SIZE});
        e.result = w.address(24, 8);
    }
    unsigned emits = w.chance(60) ? 0 : w.below(4);
    return optixAccelBuild(context, w.stream(), w.chance(98) ? &options : nullptr,
                           w.chance(98) ? inputs.data() : nullptr, unsigned(inputs.size()),
                           w.address(tempSize), w.nearlySize(tempSize), output, outputSize,
                           w.chance(98) ? &handle : nullptr, w.chance(97) ? emit : nullptr, emits);
}

// Queries the sizes, then builds with them.
void buildNew(World& w) {
    if (w.mapped() > (size_t(64) << 20))
        return;
    unsigned keyCount = 1;
    OptixAccelBuildOptions options = buildOptions(w, keyCount);
    OptixDeviceContext context = w.context();
    CUdeviceptr output = w.memory(size_t(1) << 18);
    std::vector<OptixBuildInput> inputs;
    constexpr unsigned kKinds = FUZZ_76 ? 11 : 10;
    unsigned kind = w.below(kKinds);
    for (unsigned i = 0, count = 1 + w.below(3); i < count; ++i) {
        OptixBuildInput input = kind < 4   ? triangles(w, keyCount)
                                : kind < 6 ? boxes(w, keyCount)
                                : kind < 7 ? curves(w, keyCount)
#if FUZZ_76
                                : kind == 10 ? spheres(w, keyCount)
#endif
                                             : instances(w, output | 1);
        inputs.push_back(input);
        if (w.chance(3))
            kind = w.below(kKinds); // kinds do not mix
        if (kind >= 7 && kind < 10 && w.chance(95))
            break;
    }
    if (w.chance(2))
        inputs.clear();
    if (w.chance(2) && !inputs.empty())
        inputs[0].type = OptixBuildInputType(w.any32());
    OptixAccelBufferSizes sizes{};
    OptixResult result = optixAccelComputeMemoryUsage(
        context, w.chance(98) ? &options : nullptr, w.chance(98) ? inputs.data() : nullptr,
        unsigned(inputs.size()), w.chance(98) ? &sizes : nullptr);
    w.done("optixAccelComputeMemoryUsage", result);
    if (sizes.outputSizeInBytes > (size_t(4) << 20) || sizes.tempSizeInBytes > (size_t(4) << 20))
        return;
    if (sizes.outputSizeInBytes > (size_t(1) << 18) || w.chance(50))
        output = w.address(sizes.outputSizeInBytes);
    size_t outputSize = w.nearlySize(sizes.outputSizeInBytes);
    OptixTraversableHandle handle = 0;
    result = build(w, context, options, inputs, output, outputSize, sizes.tempSizeInBytes, handle);
    w.done("optixAccelBuild", result,
           std::to_string(inputs.size()) + " inputs of type " +
               std::to_string(inputs.empty() ? 0 : unsigned(inputs[0].type)));
    if (result == OPTIX_SUCCESS)
        w.structures.push_back({handle, context, options.buildFlags, options.operation, inputs,
                                output, sizes.outputSizeInBytes});
}
const Call kBuild{"optixAccelBuild", 18, buildNew};

void update(World& w) {
    if (w.structures.empty() || w.mapped() > (size_t(64) << 20))
        return;
    Structure s = w.structures[w.below(uint32_t(w.structures.size()))];
    OptixAccelBuildOptions options{};
    options.buildFlags = w.chance(85) ? s.buildFlags : w.any32();
    options.operation = OPTIX_BUILD_OPERATION_UPDATE;
    if (w.chance(5) && !s.inputs.empty())
        s.inputs.push_back(s.inputs[0]);
    if (w.chance(5) && !s.inputs.empty() && s.inputs[0].type == OPTIX_BUILD_INPUT_TYPE_TRIANGLES)
        s.inputs[0] = triangles(w, 1);
    OptixAccelBufferSizes sizes{};
    w.done("optixAccelComputeMemoryUsage",
           optixAccelComputeMemoryUsage(s.context, &options, s.inputs.data(),
                                        unsigned(s.inputs.size()), &sizes));
    if (sizes.tempUpdateSizeInBytes > (size_t(4) << 20))
        return;
    OptixTraversableHandle handle = 0;
    w.done("optixAccelBuild",
           build(w, w.chance(95) ? s.context : w.context(), options, s.inputs, s.output,
                 s.outputSize, sizes.tempUpdateSizeInBytes, handle),
           "update");
}
const Call kUpdate{"optixAccelBuild (update)", 4, update};

void compact(World& w) {
    OptixTraversableHandle input = w.traversable(), handle = 0;
    size_t size = w.chance(80) ? 1 << 16 : w.below(1 << 12);
    CUdeviceptr output = w.address(size);
    OptixDeviceContext context = w.context();
    OptixResult result = optixAccelCompact(context, w.stream(), input, output, w.nearlySize(size),
                                           w.chance(97) ? &handle : nullptr);
    if (result == OPTIX_SUCCESS)
        w.structures.push_back({handle, context, 3, 0, {}, output, size});
    w.done("optixAccelCompact", result);
}
const Call kCompact{"optixAccelCompact", 4, compact};

// Relocates with the objects that a structure refers to, moved or not.
OptixResult relocateCall(World& w, OptixDeviceContext context, const RelocationInfo* info,
                         [[maybe_unused]] const Structure* source, CUdeviceptr target, size_t size,
                         OptixTraversableHandle* handle) {
    unsigned count = w.below(5);
#if FUZZ_76
    if (source && w.chance(50)) { // data that fits the structure
        count = 0;
        for (const OptixBuildInput& input : source->inputs)
            if (input.type == OPTIX_BUILD_INPUT_TYPE_INSTANCES ||
                input.type == OPTIX_BUILD_INPUT_TYPE_INSTANCE_POINTERS)
                count = std::min(input.instanceArray.numInstances, 100u);
    }
#endif
    std::vector<OptixTraversableHandle> children(count);
    for (OptixTraversableHandle& child : children)
        child = w.traversable();
    const CUdeviceptr handles = count && w.chance(95) ? w.upload(children) : 0;
    count = w.chance(95) ? count : w.any32();
#if FUZZ_76
    std::vector<OptixRelocateInput> inputs(source && w.chance(80) ? source->inputs.size()
                                                                  : w.below(4));
    for (size_t i = 0; i < inputs.size(); ++i) {
        inputs[i].type =
            source && i < source->inputs.size() && w.chance(95)
                ? source->inputs[i].type
                : w.enumerator({OPTIX_BUILD_INPUT_TYPE_TRIANGLES, OPTIX_BUILD_INPUT_TYPE_INSTANCES,
                                OPTIX_BUILD_INPUT_TYPE_CURVES});
        if (inputs[i].type == OPTIX_BUILD_INPUT_TYPE_TRIANGLES) {
            const bool known = !w.arrays.empty() && w.chance(80);
            inputs[i].triangleArray = {w.below(4),
                                       {known ? w.arrays[w.below(uint32_t(w.arrays.size()))].address
                                        : w.chance(80) ? 0
                                                       : w.address(1 << 10)}};
        } else {
            inputs[i].instanceArray = {count, handles};
        }
    }
    const bool none = w.chance(20);
    return optixAccelRelocate(context, w.stream(), info,
                              none || w.chance(2) ? nullptr : inputs.data(),
                              none ? 0 : inputs.size(), target, size, handle);
#else
    return optixAccelRelocate(context, w.stream(), info, handles, count, target, size, handle);
#endif
}

void relocate(World& w) {
    RelocationInfo info{};
    OptixDeviceContext context = w.context();
    OptixTraversableHandle from = w.traversable(), handle = 0;
    w.done("optixAccelGetRelocationInfo",
           optixAccelGetRelocationInfo(context, from, w.chance(97) ? &info : nullptr));
    if (w.chance(10))
        w.garble(&info, sizeof(info));
    int fits = 0;
#if FUZZ_76
    auto* const check = optixCheckRelocationCompatibility;
#else
    auto* const check = optixAccelCheckRelocationCompatibility;
#endif
    w.done("optix*CheckRelocationCompatibility",
           check(w.context(), w.chance(97) ? &info : nullptr, w.chance(97) ? &fits : nullptr));
    // The target is a copy of a structure of this sequence, or other bytes.
    w.wait();
    size_t size = 1 << 12;
    CUdeviceptr target = w.memory(size);
    const Structure* source = nullptr;
    for (const Structure& s : w.structures)
        if (s.handle == from && w.chance(90)) {
            source = &s;
            size = s.outputSize;
            target = w.memory(size);
            std::memcpy(reinterpret_cast<void*>(target), reinterpret_cast<void*>(s.output), size);
        }
    OptixResult result = relocateCall(w, context, w.chance(97) ? &info : nullptr, source,
                                      w.chance(95) ? target : w.address(size), w.nearlySize(size),
                                      w.chance(97) ? &handle : nullptr);
    if (result == OPTIX_SUCCESS && handle)
        w.structures.push_back({handle, context, 0, 0, {}, target, size});
    w.done("optixAccelRelocate", result);
}
const Call kRelocate{"optixAccelRelocate", 4, relocate};

void convert(World& w) {
    auto type = w.enumerator({OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM,
                              OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM,
                              OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM});
    OptixTraversableHandle child = w.traversable(), handle = 0;
    CUdeviceptr at = 0;
    OptixMotionOptions motion{2, uint16_t(w.below(4)), 0.0f, 1.0f};
    if (w.chance(10))
        motion = {uint16_t(w.below(4)), uint16_t(w.any32()), w.anyFloat(), w.anyFloat()};
    std::vector<float> numbers = floats(w, 32);
    if (type == OPTIX_TRAVERSABLE_TYPE_MATRIX_MOTION_TRANSFORM) {
        OptixMatrixMotionTransform t{child, motion, {}, {}};
        std::memcpy(t.transform, numbers.data(), sizeof(t.transform));
        at = w.memory(sizeof(t) + 96, 64); // a third and fourth key
        std::memcpy(reinterpret_cast<void*>(at), &t, sizeof(t));
    } else if (type == OPTIX_TRAVERSABLE_TYPE_SRT_MOTION_TRANSFORM) {
        OptixSRTMotionTransform t{child, motion, {}, {}};
        std::memcpy(t.srtData, numbers.data(), sizeof(t.srtData));
        at = w.memory(sizeof(t) + 128, 64);
        std::memcpy(reinterpret_cast<void*>(at), &t, sizeof(t));
    } else {
        OptixStaticTransform t{child, {}, {}, {}};
        std::memcpy(t.transform, numbers.data(), sizeof(t.transform));
        std::memcpy(t.invTransform, numbers.data() + 12, sizeof(t.invTransform));
        at = w.memory(sizeof(t), 64);
        if (w.chance(4))
            t.child = at | 2; // perhaps itself
        std::memcpy(reinterpret_cast<void*>(at), &t, sizeof(t));
    }
    OptixResult result =
        optixConvertPointerToTraversableHandle(w.context(), w.chance(95) ? at : w.address(128, 64),
                                               type, w.chance(97) ? &handle : nullptr);
    if (result == OPTIX_SUCCESS)
        w.transforms.push_back(handle);
    w.done("optixConvertPointerToTraversableHandle", result);
}
const Call kConvert{"optixConvertPointerToTraversableHandle", 3, convert};

} // namespace
} // namespace fuzz
