// SPDX-License-Identifier: Apache-2.0
// Stages: their names, and the values of their variables. run.cpp has the filters.
#include "api/optix6/post/stage.h"

#include "api/optix6/context.h"

#include <algorithm>
#include <cmath>

namespace sunstone::optix6 {

namespace {

struct StageFacts {
    const char* name;
    std::vector<const char*> variables;
};

// By StageKind.
const StageFacts& factsOf(StageKind stage) {
    static const auto* facts = new std::vector<StageFacts>{
        {"TonemapperSimple", {"input_buffer", "output_buffer", "exposure", "gamma"}},
        {"DLDenoiser",
         {"input_buffer", "output_buffer", "input_albedo_buffer", "input_normal_buffer", "blend",
          "hdr", "maxmem", "overlap", "training_data_buffer"}},
        {"DLSSIMPredictor",
         {"input_buffer", "output_buffer", "input_albedo_buffer", "input_normal_buffer", "hdr",
          "training_data_buffer"}}};
    return (*facts)[size_t(stage)];
}
constexpr StageKind kStages[] = {StageKind::kToneMapper, StageKind::kDenoiser,
                                 StageKind::kStructurePredictor};

constexpr uint64_t kMostSide = 1u << 20;

bool imageFormat(RTformat format, denoise::Format& result) {
    switch (format) {
    case RT_FORMAT_FLOAT3:
        result = denoise::Format::kFloat3;
        return true;
    case RT_FORMAT_FLOAT4:
        result = denoise::Format::kFloat4;
        return true;
    case RT_FORMAT_HALF3:
        result = denoise::Format::kHalf3;
        return true;
    case RT_FORMAT_HALF4:
        result = denoise::Format::kHalf4;
        return true;
    default:
        return false;
    }
}

} // namespace

PostProcessingStage::PostProcessingStage(const std::shared_ptr<Context>& context, StageKind stage)
    : Scoped(kKind, context), stage_(stage) {
    for (const char* name : factsOf(stage).variables)
        scope.add(std::make_shared<Variable>(context, name));
}

std::optional<StageKind> PostProcessingStage::kindOf(std::string_view name) {
    for (const StageKind stage : kStages)
        if (name == factsOf(stage).name)
            return stage;
    return {};
}

std::string PostProcessingStage::knownNames() {
    std::string names;
    for (const StageKind stage : kStages)
        names += std::string(names.empty() ? "" : ", ") + factsOf(stage).name;
    return names;
}

const char* PostProcessingStage::stageName() const {
    return factsOf(stage_).name;
}

std::shared_ptr<Variable> PostProcessingStage::declare(const std::string& name) {
    std::shared_ptr<Variable> found = scope.find(name);
    if (!found)
        refuse(RT_ERROR_INVALID_VALUE, "name = \"", name, "\" is no variable of stage \"",
               stageName(), "\", whose variables are predefined");
    if (std::find(declared_.begin(), declared_.end(), found.get()) != declared_.end())
        refuse(RT_ERROR_VARIABLE_REDECLARED, "variable \"", name, "\" of stage \"", stageName(),
               "\" exists");
    declared_.push_back(found.get());
    return found;
}

// ---- Values of variables -----------------------------------------------------------------------

const Variable& PostProcessingStage::variable(const char* name) const {
    return *scope.find(name);
}

double PostProcessingStage::number(const char* name, double fallback, double least,
                                   double most) const {
    const Variable& given = variable(name);
    double value = fallback;
    const auto read = [&](auto element) {
        given.get(given.type, &element, sizeof element);
        value = double(element);
    };
    switch (given.type) {
    case RT_OBJECTTYPE_UNKNOWN:
        return fallback;
    case RT_OBJECTTYPE_FLOAT:
        read(float());
        break;
    case RT_OBJECTTYPE_INT:
        read(int());
        break;
    case RT_OBJECTTYPE_UNSIGNED_INT:
        read(0u);
        break;
    default:
        refuseIt(RT_ERROR_TYPE_MISMATCH, name, "needs a float, an int or an unsigned int");
    }
    if (!(value >= least && value <= most))
        refuseIt(RT_ERROR_INVALID_VALUE, name, "= ", value, " is outside ", least, "..", most);
    return value;
}

// Null: the variable has no value.
std::shared_ptr<Buffer> PostProcessingStage::bufferOf(const char* name, bool isRequired) const {
    const Variable& given = variable(name);
    const std::shared_ptr<Object> object = given.object.lock();
    if (object && object->kind != Kind::kBuffer)
        refuseIt(RT_ERROR_TYPE_MISMATCH, name, "needs a buffer, not a ", nameOf(object->kind));
    if (!object && !given.bytes.empty())
        refuseIt(RT_ERROR_TYPE_MISMATCH, name, "needs a buffer, not data");
    if (!object && isRequired)
        refuseIt(RT_ERROR_INVALID_VALUE, name,
                 given.type == RT_OBJECTTYPE_UNKNOWN ? "has no value" : "has a destroyed buffer");
    const auto buffer = std::static_pointer_cast<Buffer>(object);
    if (buffer && buffer->isMapped())
        refuseIt(RT_ERROR_ALREADY_MAPPED, name, "has buffer ", buffer->handle(),
                 ", which is mapped");
    return buffer;
}

// Without data: the variable has no value, or the buffer no elements.
denoise::Image PostProcessingStage::image(const char* name, bool isRequired) const {
    const std::shared_ptr<Buffer> buffer = bufferOf(name, isRequired);
    denoise::Image image;
    if (!buffer)
        return image;
    buffer->validate();
    if (!imageFormat(buffer->format, image.format))
        refuseIt(RT_ERROR_INVALID_VALUE, name, "has a buffer of format ", nameOf(buffer->format),
                 ", but RT_FORMAT_FLOAT3, FLOAT4, HALF3 or HALF4 is needed");
    if (buffer->dimensions != 2 || buffer->mipLevels != 1)
        refuseIt(RT_ERROR_INVALID_VALUE, name, "has a buffer of ", buffer->dimensions,
                 " dimensions and ", buffer->mipLevels, " levels, but two and one are needed");
    const uint64_t width = buffer->extent(0, 0), height = buffer->extent(1, 0);
    if (width > kMostSide || height > kMostSide)
        refuseIt(RT_ERROR_INVALID_VALUE, name, "has a buffer of ", width, " x ", height,
                 " elements, but ", kMostSide, " are the most in each direction");
    if (!buffer->data() && width != 0)
        refuseIt(RT_ERROR_MEMORY_ALLOCATION_FAILED, name, "has a buffer without memory");
    image.data = buffer->data();
    image.width = uint32_t(width);
    image.height = uint32_t(height);
    image.pixelStride = denoise::pixelSizeOf(image.format);
    image.rowStride = width * image.pixelStride;
    return image;
}

void PostProcessingStage::requireSize(const char* name, const denoise::Image& image, uint32_t width,
                                      uint32_t height) const {
    if (image.width != width || image.height != height)
        refuseIt(RT_ERROR_INVALID_VALUE, name, "has a buffer of ", image.width, " x ", image.height,
                 " elements, but ", width, " x ", height, " are needed");
}

// No result: there is nothing to do. `block`: input pixels for one output pixel, in each direction.
std::optional<PostProcessingStage::Images> PostProcessingStage::images(uint32_t block) const {
    Images all;
    all.input = image("input_buffer", true);
    all.output = image("output_buffer", true);
    const uint32_t width = all.input.width, height = all.input.height;
    requireSize("output_buffer", all.output, (width + block - 1) / block,
                (height + block - 1) / block);
    if (scope.find("input_albedo_buffer")) {
        all.albedo = image("input_albedo_buffer", false);
        all.normal = image("input_normal_buffer", false);
        if (all.albedo)
            requireSize("input_albedo_buffer", all.albedo, width, height);
        if (all.normal)
            requireSize("input_normal_buffer", all.normal, width, height);
        if (all.normal && !all.albedo)
            refuseIt(RT_ERROR_INVALID_VALUE, "input_normal_buffer",
                     "needs \"input_albedo_buffer\" too");
    }
    if (!all.input)
        return {};
    return all;
}

void PostProcessingStage::noteTrainingData() {
    if (!bufferOf("training_data_buffer", false) || toldOfTrainingData_)
        return;
    toldOfTrainingData_ = true;
    context()->report(1, "POST-PROCESSING",
                      message("stage \"", stageName(),
                              "\": the training data is not used, the filter is built in"));
}

void PostProcessingStage::run() {
    const bool predicts = stage_ == StageKind::kStructurePredictor;
    const std::optional<Images> all = images(predicts ? 16 : 1);
    if (!all)
        return;
    device::Device& device = *context()->engine->device;
    try {
        if (stage_ == StageKind::kToneMapper)
            mapTones(*all);
        else if (predicts)
            predictStructure(*all);
        else
            denoise(*all);
    } catch (...) { // queued work uses the stage's memory
        device.synchronizeAll();
        throw;
    }
    device.synchronize(nullptr);
    bufferOf("output_buffer", true)->noteChange();
}

} // namespace sunstone::optix6
