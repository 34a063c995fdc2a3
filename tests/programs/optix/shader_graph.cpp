// SPDX-License-Identifier: Apache-2.0
// Materials as data: each is an expression over the surface, whose operations are direct callables
// that call one another through the table, recursively; a continuation callable traces a shadow
// ray. Two instances of the operations stand in the table, with records that scale differently.
#include "common.h"

#include <optix_function_table_definition.h>
#include <optix_stack_size.h>

#include <cmath>

#include "device/shader_graph.h"

namespace {

constexpr unsigned kWide = 64, kHigh = 16;
enum Operation { kConstant, kU, kV, kAdd, kMultiply, kScaled, kOperations };

// Four materials; the root of each is its last node.
const std::vector<std::vector<Node>> kMaterials = {
    {{kConstant, 0, 0, 2.5f}},
    {{kU, 0, 0, 0}, {kV, 0, 0, 0}, {kAdd, 0, 1, 0}, {kMultiply, 2, 2, 0}},
    {{kU, 0, 0, 0},
     {kConstant, 0, 0, 3},
     {kMultiply, 0, 1, 0},
     {kScaled, 2, 0, 0},
     {kAdd, 3, 0, 0}},
    {{kV, 0, 0, 0},
     {kMultiply, 0, 0, 0},
     {kMultiply, 1, 1, 0},
     {kMultiply, 2, 2, 0},
     {kScaled, 3, 0, 0},
     {kScaled, 4, 0, 0}},
};
const float kScales[2] = {10, 0.25f};

float evaluate(const std::vector<Node>& nodes, int node, float u, float v, float scale) {
    const Node& n = nodes[node];
    const auto child = [&](int i) { return evaluate(nodes, i, u, v, scale); };
    switch (n.operation) {
    case kConstant:
        return n.constant;
    case kU:
        return u;
    case kV:
        return v;
    case kAdd:
        return child(n.left) + child(n.right);
    case kMultiply:
        return child(n.left) * child(n.right);
    default:
        return scale * child(n.left);
    }
}

bool run() {
    OptixDeviceContext context = makeContext();
    auto options = pipelineOptions(1, 2, OPTIX_TRAVERSABLE_GRAPH_FLAG_ALLOW_SINGLE_GAS);
    OptixModule module = makeModule(context, options);
    std::vector<OptixProgramGroup> groups = {
        raygenGroup(context, module, "__raygen__grid"), missGroup(context, module, "__miss__grid"),
        missGroup(context, module, "__miss__shadow"),
        hitGroup(context, module, "__closesthit__graph", nullptr, nullptr)};
    const char* names[] = {"constant", "u", "v", "add", "multiply", "scaled"};
    for (const char* name : names) {
        OptixProgramGroupDesc description = {};
        description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
        const std::string function = std::string("__direct_callable__") + name;
        description.callables.moduleDC = module;
        description.callables.entryFunctionNameDC = function.c_str();
        groups.push_back(makeGroup(context, description));
    }
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_CALLABLES;
    description.callables.moduleCC = module;
    description.callables.entryFunctionNameCC = "__continuation_callable__shade";
    groups.push_back(makeGroup(context, description));
    OptixPipeline pipeline = makePipeline(context, options, groups, 2);
    OptixStackSizes sizes = {};
    for (OptixProgramGroup group : groups)
        OPTIX_TRY(optixUtilAccumulateStackSizes(group, &sizes));
    unsigned fromTraversal = 0, fromState = 0, continuation = 0;
    OPTIX_TRY(
        optixUtilComputeStackSizes(&sizes, 2, 1, 8, &fromTraversal, &fromState, &continuation));
    OPTIX_TRY(optixPipelineSetStackSize(pipeline, fromTraversal, fromState, continuation, 1));

    // Four strips of one unit, one build input and so one material each; roofs over two of them.
    std::vector<float3> corners;
    for (float x : {0.f, 1.f, 2.f, 3.f})
        corners.insert(
            corners.end(),
            {{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}});
    for (float x : {1.f, 3.f})
        corners.insert(
            corners.end(),
            {{x, 0, 2}, {x + 1, 0, 2}, {x + 1, 1, 2}, {x, 0, 2}, {x + 1, 1, 2}, {x, 1, 2}});
    Buffer vertices(corners), memory;
    std::vector<CUdeviceptr> addresses;
    std::vector<OptixBuildInput> inputs(6);
    const unsigned flags = OPTIX_GEOMETRY_FLAG_NONE;
    for (unsigned i = 0; i < 6; ++i)
        addresses.push_back(vertices.ptr() + i * 6 * sizeof(float3));
    for (unsigned i = 0; i < 6; ++i) {
        inputs[i].type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        inputs[i].triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        inputs[i].triangleArray.vertexBuffers = &addresses[i];
        inputs[i].triangleArray.numVertices = 6;
        inputs[i].triangleArray.flags = &flags;
        inputs[i].triangleArray.numSbtRecords = 1;
    }
    const OptixTraversableHandle scene = buildAccel(context, inputs, memory);

    std::vector<Buffer> nodes;
    for (const auto& list : kMaterials)
        nodes.emplace_back(list);
    std::vector<Record<MaterialData>> hits;
    for (unsigned i = 0; i < 6; ++i) {
        const unsigned m = i % 4;
        // The second set of operations stands behind the continuation callable.
        hits.push_back(
            packed(groups[3], MaterialData{nodes[m].as<Node>(), int(kMaterials[m].size()) - 1,
                                           m % 2 ? 7 : 0}));
    }
    std::vector<Record<float>> heads, callables;
    for (unsigned i = 0; i < 3; ++i)
        heads.push_back(packed(groups[i], 0.0f));
    for (unsigned i = 0; i < kOperations; ++i)
        callables.push_back(packed(groups[4 + i], kScales[0]));
    callables.push_back(packed(groups[4 + kOperations], 0.0f));
    for (unsigned i = 0; i < kOperations; ++i)
        callables.push_back(packed(groups[4 + i], kScales[1]));
    Buffer headBuffer(heads), hitBuffer(hits), callableBuffer(callables);
    OptixShaderBindingTable sbt = {};
    sbt.raygenRecord = headBuffer.ptr();
    sbt.missRecordBase = headBuffer.ptr() + sizeof heads[0];
    sbt.missRecordStrideInBytes = sizeof heads[0];
    sbt.missRecordCount = 2;
    sbt.hitgroupRecordBase = hitBuffer.ptr();
    sbt.hitgroupRecordStrideInBytes = sizeof hits[0];
    sbt.hitgroupRecordCount = unsigned(hits.size());
    sbt.callablesRecordBase = callableBuffer.ptr();
    sbt.callablesRecordStrideInBytes = sizeof callables[0];
    sbt.callablesRecordCount = unsigned(callables.size());

    Buffer out(kWide * kHigh * 4);
    Buffer params(std::vector<Params>{{scene, out.as<float>()}});
    OPTIX_TRY(optixLaunch(pipeline, nullptr, params.ptr(), sizeof(Params), &sbt, kWide, kHigh, 1));
    const auto seen = out.download<float>();
    unsigned wrong = 0;
    for (unsigned i = 0; i < kWide * kHigh; ++i) {
        const float u = (i % kWide + 0.5f) / kWide * 4, v = (i / kWide + 0.5f) / kHigh;
        const unsigned m = unsigned(u);
        const float base =
            evaluate(kMaterials[m], int(kMaterials[m].size()) - 1, u, v, kScales[m % 2]);
        const float right = m % 2 ? -base : base;
        if (!(std::fabs(seen[i] - right) <= 1e-4f * std::fabs(right) + 1e-6f) && wrong++ == 0)
            std::printf("(%g, %g): %g in place of %g\n", u, v, seen[i], right);
    }
    std::printf("%u wrong\n", wrong);
    OPTIX_TRY(optixDeviceContextDestroy(context));
    return wrong == 0;
}

} // namespace

int main() {
    return runChecked(run);
}
