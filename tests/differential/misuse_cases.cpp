// SPDX-License-Identifier: Apache-2.0
// Wrong calls of the API and the codes they return. A crash of the library counts as an answer.
#include "lab.h"

#include <csetjmp>
#include <csignal>
#include <cstring>
#include <limits>

namespace differential {
namespace {

sigjmp_buf back;
void onSignal(int) {
    siglongjmp(back, 1);
}

class Misuse {
public:
    Misuse(const Lab& lab, Answer& answer) : lab_(lab), answer_(answer) {
        std::signal(SIGSEGV, onSignal);
        vertices_.upload(mesh_.vertices);
        address_ = vertices_.address();
        input_.type = OPTIX_BUILD_INPUT_TYPE_TRIANGLES;
        input_.triangleArray.vertexBuffers = &address_;
        input_.triangleArray.numVertices = 30;
        input_.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_FLOAT3;
        input_.triangleArray.flags = flags_;
        input_.triangleArray.numSbtRecords = 1;
        options_.operation = OPTIX_BUILD_OPERATION_BUILD;
        OPTIX_CHECK(optixAccelComputeMemoryUsage(lab.context(), &options_, &input_, 1, &sizes_));
        temp_.allocate(sizes_.tempSizeInBytes);
        output_.allocate(sizes_.outputSizeInBytes);
    }
    ~Misuse() { std::signal(SIGSEGV, SIG_DFL); }

    void contexts();
    void structures();
    void builds();
    void traversables();
    void modules();

private:
    template <class Call>
    void add(const char* name, Call call) {
        std::string result = "crash";
        if (sigsetjmp(back, 1) == 0)
            result = std::to_string(int(call())); // names differ between versions
        answer_.text += std::string(name) + " " + result + "\n";
    }
    // The result of optixAccelComputeMemoryUsage with a changed input.
    template <class Change>
    void size(const char* name, Change change) {
        OptixBuildInput input = input_;
        OptixAccelBuildOptions options = options_;
        change(input, options);
        OptixAccelBufferSizes sizes = {};
        add(name, [&] {
            return optixAccelComputeMemoryUsage(lab_.context(), &options, &input, 1, &sizes);
        });
    }
    OptixResult build(const OptixBuildInput* input, unsigned inputs, CUdeviceptr temp,
                      size_t tempSize, CUdeviceptr output, size_t outputSize,
                      const OptixAccelEmitDesc* emit = nullptr, unsigned emits = 0) {
        return optixAccelBuild(lab_.context(), nullptr, &options_, input, inputs, temp, tempSize,
                               output, outputSize, &handle_, emit, emits);
    }

    const Lab& lab_;
    Answer& answer_;
    Mesh mesh_ = randomTriangles(10, 0.4f, 401);
    DeviceBuffer vertices_, temp_, output_;
    CUdeviceptr address_ = 0;
    unsigned flags_[2] = {OPTIX_GEOMETRY_FLAG_NONE, OPTIX_GEOMETRY_FLAG_NONE}; // for two records, too
    OptixBuildInput input_ = {};
    OptixAccelBuildOptions options_ = {};
    OptixAccelBufferSizes sizes_ = {};
    OptixTraversableHandle handle_ = 0;
};

void Misuse::contexts() {
    unsigned value = 0;
    const OptixDeviceContext context = lab_.context();
    add("context_property_size", [&] {
        return optixDeviceContextGetProperty(context, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                             &value, 1);
    });
    add("context_property_unknown", [&] {
        return optixDeviceContextGetProperty(context, OptixDeviceProperty(0x7777), &value, 4);
    });
    add("context_property_null", [&] {
        return optixDeviceContextGetProperty(context, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                             nullptr, 4);
    });
    add("context_null_get_property", [&] {
        return optixDeviceContextGetProperty(nullptr, OPTIX_DEVICE_PROPERTY_LIMIT_MAX_TRACE_DEPTH,
                                             &value, 4);
    });
    add("context_log_level",
        [&] { return optixDeviceContextSetLogCallback(context, nullptr, nullptr, 9); });
    add("context_create_null", [&] { return optixDeviceContextCreate(nullptr, nullptr, nullptr); });
    add("context_cache_location_null",
        [&] { return optixDeviceContextSetCacheLocation(context, nullptr); });
    add("context_cache_low_above_high",
        [&] { return optixDeviceContextSetCacheDatabaseSizes(context, 200, 100); });
}

void Misuse::structures() {
    size("size_no_vertices", [](auto& i, auto&) { i.triangleArray.numVertices = 0; });
    size("size_vertex_count_no_multiple_of_3",
         [](auto& i, auto&) { i.triangleArray.numVertices = 29; });
    size("size_null_vertex_buffers",
         [](auto& i, auto&) { i.triangleArray.vertexBuffers = nullptr; });
    size("size_vertex_format_unknown",
         [](auto& i, auto&) { i.triangleArray.vertexFormat = OptixVertexFormat(0x1111); });
    size("size_vertex_format_none",
         [](auto& i, auto&) { i.triangleArray.vertexFormat = OPTIX_VERTEX_FORMAT_NONE; });
    size("size_stride_too_small", [](auto& i, auto&) { i.triangleArray.vertexStrideInBytes = 8; });
    size("size_stride_unaligned", [](auto& i, auto&) { i.triangleArray.vertexStrideInBytes = 13; });
    size("size_null_flags", [](auto& i, auto&) { i.triangleArray.flags = nullptr; });
    size("size_no_sbt_records", [](auto& i, auto&) { i.triangleArray.numSbtRecords = 0; });
    size("size_two_records_without_offsets",
         [](auto& i, auto&) { i.triangleArray.numSbtRecords = 2; });
    size("size_indices_without_format",
         [](auto& i, auto&) { i.triangleArray.numIndexTriplets = 4; });
    size("size_index_format_without_indices",
         [](auto& i, auto&) { i.triangleArray.indexFormat = OPTIX_INDICES_FORMAT_UNSIGNED_INT3; });
    size("size_input_type_unknown", [](auto& i, auto&) { i.type = OptixBuildInputType(0x1234); });
    size("size_both_preferences", [](auto&, auto& o) {
        o.buildFlags = OPTIX_BUILD_FLAG_PREFER_FAST_BUILD | OPTIX_BUILD_FLAG_PREFER_FAST_TRACE;
    });
    size("size_flag_unknown", [](auto&, auto& o) { o.buildFlags = 1u << 20; });
    size("size_operation_unknown", [](auto&, auto& o) { o.operation = OptixBuildOperation(7); });
    size("size_motion_without_interval", [](auto&, auto& o) {
        o.motionOptions.numKeys = 2;
        o.motionOptions.timeBegin = 1;
        o.motionOptions.timeEnd = 0;
    });
    size("size_motion_nan", [](auto&, auto& o) {
        o.motionOptions.numKeys = 2;
        o.motionOptions.timeEnd = std::numeric_limits<float>::quiet_NaN();
    });
    add("size_null_input", [&] {
        return optixAccelComputeMemoryUsage(lab_.context(), &options_, nullptr, 1, &sizes_);
    });
    add("size_no_inputs", [&] {
        OptixAccelBufferSizes sizes = {};
        return optixAccelComputeMemoryUsage(lab_.context(), &options_, &input_, 0, &sizes);
    });
    add("size_null_sizes", [&] {
        return optixAccelComputeMemoryUsage(lab_.context(), &options_, &input_, 1, nullptr);
    });
}

void Misuse::builds() {
    const CUdeviceptr temp = temp_.address(), output = output_.address();
    add("build_temp_too_small", [&] {
        return build(&input_, 1, temp, sizes_.tempSizeInBytes / 2, output,
                     sizes_.outputSizeInBytes);
    });
    add("build_output_too_small", [&] {
        return build(&input_, 1, temp, sizes_.tempSizeInBytes, output,
                     sizes_.outputSizeInBytes / 2);
    });
    add("build_output_unaligned", [&] {
        return build(&input_, 1, temp, sizes_.tempSizeInBytes, output + 16,
                     sizes_.outputSizeInBytes);
    });
    add("build_temp_unaligned", [&] {
        return build(&input_, 1, temp + 16, sizes_.tempSizeInBytes, output,
                     sizes_.outputSizeInBytes);
    });
    add("build_output_null", [&] {
        return build(&input_, 1, temp, sizes_.tempSizeInBytes, 0, sizes_.outputSizeInBytes);
    });
    add("build_vertices_unaligned", [&] {
        const CUdeviceptr odd = address_ + 2;
        OptixBuildInput input = input_;
        input.triangleArray.vertexBuffers = &odd;
        input.triangleArray.numVertices = 27;
        return build(&input, 1, temp, sizes_.tempSizeInBytes, output, sizes_.outputSizeInBytes);
    });
    add("build_vertices_null", [&] {
        const CUdeviceptr none = 0;
        OptixBuildInput input = input_;
        input.triangleArray.vertexBuffers = &none;
        return build(&input, 1, temp, sizes_.tempSizeInBytes, output, sizes_.outputSizeInBytes);
    });
    add("build_emit_null", [&] {
        return build(&input_, 1, temp, sizes_.tempSizeInBytes, output, sizes_.outputSizeInBytes,
                     nullptr, 1);
    });
    add("build_emit_unknown", [&] {
        const OptixAccelEmitDesc emit = {temp, OptixAccelPropertyType(0x99)};
        return build(&input_, 1, temp, sizes_.tempSizeInBytes, output, sizes_.outputSizeInBytes,
                     &emit, 1);
    });
    add("build_emit_size_without_flag", [&] {
        DeviceBuffer size(8);
        const OptixAccelEmitDesc emit = {size.address(), OPTIX_PROPERTY_TYPE_COMPACTED_SIZE};
        return build(&input_, 1, temp, sizes_.tempSizeInBytes, output, sizes_.outputSizeInBytes,
                     &emit, 1);
    });
    add("build_right", [&] {
        return build(&input_, 1, temp, sizes_.tempSizeInBytes, output, sizes_.outputSizeInBytes);
    });
    cudaDeviceSynchronize();
    add("compact_without_flag", [&] {
        OptixTraversableHandle other = 0;
        return optixAccelCompact(lab_.context(), nullptr, handle_, temp, sizes_.tempSizeInBytes,
                                 &other);
    });
    add("compact_null_handle_pointer", [&] {
        return optixAccelCompact(lab_.context(), nullptr, handle_, temp, sizes_.tempSizeInBytes,
                                 nullptr);
    });
    add("update_without_flag", [&] {
        OptixAccelBuildOptions options = options_;
        options.operation = OPTIX_BUILD_OPERATION_UPDATE;
        return optixAccelBuild(lab_.context(), nullptr, &options, &input_, 1, temp,
                               sizes_.tempSizeInBytes, output, sizes_.outputSizeInBytes, &handle_,
                               nullptr, 0);
    });
    cudaDeviceSynchronize();
}

void Misuse::traversables() {
    OptixTraversableHandle handle = 0;
    const OptixDeviceContext context = lab_.context();
    add("convert_unaligned", [&] {
        return optixConvertPointerToTraversableHandle(
            context, temp_.address() + 4, OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, &handle);
    });
    add("convert_type_unknown", [&] {
        return optixConvertPointerToTraversableHandle(context, temp_.address(),
                                                      OptixTraversableType(0x5), &handle);
    });
    add("convert_null_result", [&] {
        return optixConvertPointerToTraversableHandle(
            context, temp_.address(), OPTIX_TRAVERSABLE_TYPE_STATIC_TRANSFORM, nullptr);
    });
}

void Misuse::modules() {
    OptixModuleCompileOptions moduleOptions = {};
    OptixPipelineCompileOptions options = {};
    options.numPayloadValues = options.numAttributeValues = 2;
    OptixModule module = nullptr;
    const auto create = [&](const char* text, size_t size) {
        return optixModuleCreateFromPTX(lab_.context(), &moduleOptions, &options, text, size,
                                        nullptr, nullptr, &module);
    };
    add("module_empty", [&] { return create("", 0); });
    add("module_null_text", [&] { return create(nullptr, 10); });
    const char garbage[] = "this is no PTX at all";
    add("module_garbage", [&] { return create(garbage, sizeof(garbage) - 1); });
    add("module_payload_count", [&] {
        options.numPayloadValues = 40;
        const OptixResult result = create(garbage, sizeof(garbage) - 1);
        options.numPayloadValues = 2;
        return result;
    });
    add("module_attribute_count", [&] {
        options.numAttributeValues = 9;
        const OptixResult result = create(garbage, sizeof(garbage) - 1);
        options.numAttributeValues = 2;
        return result;
    });
    OptixProgramGroup group = nullptr;
    OptixProgramGroupOptions groupOptions = {};
    OptixProgramGroupDesc description = {};
    description.kind = OPTIX_PROGRAM_GROUP_KIND_RAYGEN;
    description.raygen.entryFunctionName = "__raygen__none";
    add("group_name_without_module", [&] {
        return optixProgramGroupCreate(lab_.context(), &description, 1, &groupOptions, nullptr,
                                       nullptr, &group);
    });
    add("group_kind_unknown", [&] {
        description.kind = OptixProgramGroupKind(0x77);
        return optixProgramGroupCreate(lab_.context(), &description, 1, &groupOptions, nullptr,
                                       nullptr, &group);
    });
    add("record_null", [&] { return optixSbtRecordPackHeader(nullptr, nullptr); });
}

} // namespace

std::vector<Case> misuseCases() {
    const auto of = [](void (Misuse::*part)()) {
        return [part](const Lab& lab, Answer& answer) {
            Misuse misuse(lab, answer);
            (misuse.*part)();
        };
    };
    return {{"misuse.contexts", of(&Misuse::contexts)},
            {"misuse.structures", of(&Misuse::structures)},
            {"misuse.builds", of(&Misuse::builds)},
            {"misuse.traversables", of(&Misuse::traversables)},
            {"misuse.modules", of(&Misuse::modules)}};
}

} // namespace differential
