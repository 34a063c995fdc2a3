// SPDX-License-Identifier: Apache-2.0
// Renders cut-out leaves twice: in the left half of the picture with only the any-hit program, in
// the right half with opacity micromaps, which replace it except near the outline. Both give the
// same picture; the program prints the time of each. Needs OptiX 7.6. Read triangle first.
#include "arguments.h"
#include "foliage.h"
#include "optix_setup.h"
#include "png_image.h"

#include <optix_function_table_definition.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string_view>

std::string_view opacity_ptx(); // the PTX of opacity.cu, built into this program

namespace {

struct Options {
    std::string output = "opacity.png";
    unsigned width = 960, height = 540, samplesPerAxis = 2, leaves = 9000, level = 5, repeats = 3;
};

// An array with the micromaps of a leaf's two triangles.
DeviceBuffer buildMicromaps(OptixDeviceContext context, const Mask& mask, unsigned level) {
    std::vector<unsigned char> states;
    std::vector<OptixOpacityMicromapDesc> descriptions;
    for (unsigned triangle = 0; triangle < 2; ++triangle) {
        descriptions.push_back({unsigned(states.size()), (unsigned short)level,
                                OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE});
        const std::vector<unsigned char> bytes = packStates(leafStates(mask, triangle, level));
        states.insert(states.end(), bytes.begin(), bytes.end());
    }
    DeviceBuffer deviceStates, deviceDescriptions;
    deviceStates.upload(states);
    deviceDescriptions.upload(descriptions);
    const OptixOpacityMicromapHistogramEntry histogram = {2, level,
                                                          OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE};
    OptixOpacityMicromapArrayBuildInput input = {};
    input.flags = OPTIX_OPACITY_MICROMAP_FLAG_PREFER_FAST_TRACE;
    input.inputBuffer = deviceStates.address();
    input.perMicromapDescBuffer = deviceDescriptions.address();
    input.numMicromapHistogramEntries = 1;
    input.micromapHistogramEntries = &histogram;
    OptixMicromapBufferSizes sizes = {};
    OPTIX_CHECK(optixOpacityMicromapArrayComputeMemoryUsage(context, &input, &sizes));
    DeviceBuffer array(sizes.outputSizeInBytes), temporary(sizes.tempSizeInBytes);
    const OptixMicromapBuffers buffers = {array.address(), array.size(), temporary.address(),
                                          temporary.size()};
    OPTIX_CHECK(optixOpacityMicromapArrayBuild(context, nullptr, &input, &buffers));
    CUDA_CHECK(cudaDeviceSynchronize());
    return array;
}

// `micromaps` may be empty. The ground needs none: its index means opaque.
Accel buildScene(OptixDeviceContext context, const Foliage& foliage, const DeviceBuffer& micromaps,
                 unsigned level) {
    DeviceBuffer vertices, indices, materials, micromapIndices;
    vertices.upload(foliage.vertices);
    indices.upload(foliage.indices);
    materials.upload(foliage.materials);
    const unsigned triangles = unsigned(foliage.materials.size());
    const CUdeviceptr vertexAddress = vertices.address();
    const unsigned flags[kMaterialCount] = {OPTIX_GEOMETRY_FLAG_NONE,
                                            OPTIX_GEOMETRY_FLAG_DISABLE_ANYHIT};
    OptixBuildInput input = {};
    input.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
    OptixBuildInputTriangleArray& array = input.triangleArray;
    array.vertexBuffers = &vertexAddress;
    array.numVertices = unsigned(foliage.vertices.size());
    array.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
    array.indexBuffer = indices.address();
    array.numIndexTriplets = triangles;
    array.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3;
    array.flags = flags;
    array.numSbtRecords = kMaterialCount;
    array.sbtIndexOffsetBuffer = materials.address();
    array.sbtIndexOffsetSizeInBytes = sizeof(unsigned);

    std::vector<short> micromapOf;
    for (unsigned i = 0; i < triangles; ++i)
        micromapOf.push_back(foliage.materials[i] == kLeaf
                                 ? short(i & 1)
                                 : short(OPTIX_OPACITY_MICROMAP_PREDEFINED_INDEX_FULLY_OPAQUE));
    const OptixOpacityMicromapUsageCount usage = {triangles - 2, level,
                                                  OPTIX_OPACITY_MICROMAP_FORMAT_4_STATE};
    if (micromaps.size()) {
        micromapIndices.upload(micromapOf);
        array.opacityMicromap.indexingMode = OPTIX_OPACITY_MICROMAP_ARRAY_INDEXING_MODE_INDEXED;
        array.opacityMicromap.opacityMicromapArray = micromaps.address();
        array.opacityMicromap.indexBuffer = micromapIndices.address();
        array.opacityMicromap.indexSizeInBytes = sizeof(short);
        array.opacityMicromap.numMicromapUsageCounts = 1;
        array.opacityMicromap.micromapUsageCounts = &usage;
    }
    return buildAccel(context, input);
}

struct Frame {
    std::vector<float> pixels; // four a pixel; the fourth counts any-hit calls
    double milliseconds;
    double anyHitsPerPixel;
};

Frame render(OptixPipeline pipeline, const OptixShaderBindingTable& sbt, Params params,
             const Options& options) {
    DeviceBuffer image(size_t(options.width) * options.height * sizeof(float4));
    params.image = image.as<float4>();
    DeviceBuffer deviceParams;
    deviceParams.upload(&params, sizeof(params));
    Frame frame{{}, 1e30, 0};
    for (unsigned i = 0; i < options.repeats; ++i) {
        const auto start = std::chrono::steady_clock::now();
        OPTIX_CHECK(optixLaunch(pipeline, nullptr, deviceParams.address(), sizeof(params), &sbt,
                                options.width, options.height, 1));
        CUDA_CHECK(cudaDeviceSynchronize());
        const std::chrono::duration<double, std::milli> took =
            std::chrono::steady_clock::now() - start;
        frame.milliseconds = std::min(frame.milliseconds, took.count());
    }
    frame.pixels = image.download<float>();
    for (size_t i = 3; i < frame.pixels.size(); i += 4)
        frame.anyHitsPerPixel += frame.pixels[i];
    frame.anyHitsPerPixel /= double(options.width) * options.height;
    return frame;
}

// Combines the left half of one picture with the right half of the other; returns the number of
// differing pixels of the whole pictures.
size_t compose(std::vector<float>& left, const std::vector<float>& right, unsigned width) {
    size_t different = 0;
    for (size_t i = 0; i < left.size(); i += 4) {
        different += !std::equal(&left[i], &left[i] + 3, &right[i]);
        const size_t x = i / 4 % width;
        if (x >= width / 2)
            std::copy(&right[i], &right[i] + 3, &left[i]);
        if (x == width / 2)
            std::fill(&left[i], &left[i] + 3, 1.0f);
    }
    return different;
}

void renderBoth(OptixDeviceContext context, const Options& options) {
    const Foliage foliage = makeFoliage(options.leaves);
    const std::vector<unsigned char> texels = makeLeafMask(256);
    const DeviceBuffer micromaps = buildMicromaps(context, {texels.data(), 256}, options.level);
    const Accel plain = buildScene(context, foliage, DeviceBuffer(), options.level);
    const Accel mapped = buildScene(context, foliage, micromaps, options.level);

    Program program(context, opacity_ptx(), 4, 2, unsigned(OPTIX_PRIMITIVE_TYPE_FLAGS_TRIANGLE),
                    "params", OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS, true);
    const auto raygenRecord = makeRecord(program.addRaygen("__raygen__camera"));
    const std::vector<SbtRecord<NoData>> missRecords = {
        makeRecord(program.addMiss("__miss__sky")), makeRecord(program.addMiss("__miss__shadow"))};
    const std::vector<SbtRecord<NoData>> hitRecords = {
        makeRecord(program.addHitgroup("__closesthit__leaf", "__anyhit__mask", nullptr)),
        makeRecord(program.addHitgroup(nullptr, "__anyhit__mask", nullptr)),
        makeRecord(program.addHitgroup("__closesthit__ground", nullptr, nullptr)),
        makeRecord(program.addHitgroup(nullptr, nullptr, nullptr))};
    DeviceBuffer raygen, miss, hit, normals, mask;
    raygen.upload(&raygenRecord, sizeof(raygenRecord));
    miss.upload(missRecords);
    hit.upload(hitRecords);
    normals.upload(foliage.normals);
    mask.upload(texels);
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = raygen.address();
    sbt.missRecordBase = miss.address();
    sbt.missRecordStrideInBytes = sizeof(missRecords[0]);
    sbt.missRecordCount = unsigned(missRecords.size());
    sbt.hitgroupRecordBase = hit.address();
    sbt.hitgroupRecordStrideInBytes = sizeof(hitRecords[0]);
    sbt.hitgroupRecordCount = unsigned(hitRecords.size());
    OptixPipeline pipeline = program.link(kMaxTraceDepth);

    Params params = {};
    params.normals = normals.as<float3>();
    params.mask = {mask.as<unsigned char>(), 256};
    params.camera = makeCamera(vec(0.0f, 2.6f, 10.5f), vec(0.0f, 1.9f, 0.0f), vec(0.0f, 1.0f, 0.0f),
                               36.0f, float(options.width) / float(options.height));
    params.lightDirection = normalize(vec(-0.6f, 1.0f, 0.5f));
    params.samplesPerAxis = options.samplesPerAxis;
    params.scene = plain.handle;
    Frame left = render(pipeline, sbt, params, options);
    params.scene = mapped.handle;
    const Frame right = render(pipeline, sbt, params, options);

    const size_t different = compose(left.pixels, right.pixels, options.width);
    std::printf("any-hit program:   %8.1f ms, %6.2f calls a pixel\n", left.milliseconds,
                left.anyHitsPerPixel);
    std::printf("opacity micromaps: %8.1f ms, %6.2f calls a pixel\n", right.milliseconds,
                right.anyHitsPerPixel);
    if (different != 0)
        std::printf("%zu pixels differ\n", different);
    writePng(options.output, options.width, options.height, toSrgb(left.pixels, false));
    std::printf("wrote %s\n", options.output.c_str());
}

int run(int argc, char** argv) {
    Options options;
    Arguments arguments("Cuts leaves out of squares, with an any-hit program and with micromaps.");
    arguments.add("-o,--output", options.output, "picture to write");
    arguments.add("--width", options.width, 2, 8192, "pixels across");
    arguments.add("--height", options.height, 1, 8192, "pixels down");
    arguments.add("--samples-per-axis", options.samplesPerAxis, 1, 16,
                  "rays for a pixel, square root");
    arguments.add("--leaves", options.leaves, 0, 1000000, "leaves on seven plants");
    arguments.add("--level", options.level, 0, 12, "each triangle has 4^level micro-triangles");
    arguments.add("--repeats", options.repeats, 1, 100, "launches; the fastest counts");
    if (arguments.parse(argc, argv) == Arguments::Result::kHelp)
        return 0;
    OptixDeviceContext context = createContext();
    renderBoth(context, options);
    OPTIX_CHECK(optixDeviceContextDestroy(context));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return runSample("opacity", [&] { return run(argc, argv); });
}
