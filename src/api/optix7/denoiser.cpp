// SPDX-License-Identifier: Apache-2.0
// The denoiser (OptiX 7.4, sections 3.11 and 5.12 to 5.16).
#include "api/optix7/denoiser.h"

#include "api/optix7/entry_points.h"
#include "denoise/model.h"

#include <algorithm>

namespace sunstone::optix7 {

HandleTable<DenoiserObject>& denoisers() {
    static auto* table = new HandleTable<DenoiserObject>;
    return *table;
}

std::shared_ptr<DenoiserObject> denoiserOf(OptixDenoiser handle) {
    if (!handle)
        fail(Code::kInvalidValue, "denoiser is null");
    std::shared_ptr<DenoiserObject> object = denoisers().find(handle);
    if (!object)
        fail(Code::kInvalidValue, "denoiser = ", static_cast<const void*>(handle),
             " is not a live denoiser");
    return object;
}

std::shared_ptr<DeviceContext> peek(OptixDenoiser handle) {
    std::shared_ptr<DenoiserObject> object = denoisers().find(handle);
    return object ? object->context : nullptr;
}

denoise::Kind checkKind(OptixDenoiserModelKind kind, Abi abi) {
    switch (kind) {
    case OPTIX_DENOISER_MODEL_KIND_LDR:
        return denoise::Kind::kLimited;
    case OPTIX_DENOISER_MODEL_KIND_HDR:
        return denoise::Kind::kHighRange;
    case OPTIX_DENOISER_MODEL_KIND_AOV:
        if (abi >= kAbi72)
            return denoise::Kind::kLayers;
        break;
    case OPTIX_DENOISER_MODEL_KIND_TEMPORAL:
        if (abi >= kAbi73)
            return denoise::Kind::kTemporal;
        break;
    case OPTIX_DENOISER_MODEL_KIND_TEMPORAL_AOV:
        if (abi >= kAbi73)
            return denoise::Kind::kTemporalLayers;
        break;
    case OPTIX_DENOISER_MODEL_KIND_UPSCALE2X:
        if (abi >= kAbi75)
            return denoise::Kind::kTwice;
        break;
    case OPTIX_DENOISER_MODEL_KIND_TEMPORAL_UPSCALE2X:
        if (abi >= kAbi75)
            return denoise::Kind::kTemporalTwice;
        break;
    }
    fail(Code::kInvalidValue, "modelKind = ", unsigned(kind), " is unknown in OptiX ",
         releaseOf(abi));
}

denoise::Model checkUserModel(const void* data, size_t size) {
    denoise::Model model;
    std::string reason;
    if (!denoise::parseModel(data, size, model, reason))
        throw ResultError(OPTIX_ERROR_INVALID_FILE_FORMAT,
                          "the data is no denoiser model: " + reason);
    return model;
}

namespace {

constexpr unsigned kMaxSide = 1u << 20;

const denoise::Filter& filterOf(const DenoiserObject& denoiser) {
    if (!denoiser.filter)
        throw ResultError(OPTIX_ERROR_DENOISER_MODEL_NOT_SET,
                          "optixDenoiserSetModel was not called for this denoiser");
    return *denoiser.filter;
}

OptixDenoiser makeDenoiser(std::shared_ptr<DeviceContext> context, const denoise::Model& model) {
    auto object = std::make_shared<DenoiserObject>();
    object->context = std::move(context);
    object->model = model;
    object->filter = denoise::makeFilter(model);
    return static_cast<OptixDenoiser>(denoisers().add(object));
}

void checkSide(const char* name, unsigned value) {
    if (value == 0 || value > kMaxSide)
        fail(Code::kInvalidValue, name, " = ", value, " is not 1 to ", kMaxSide);
}

void checkMemory(device::Device& device, const std::string& name, CUdeviceptr address, size_t size,
                 size_t needed) {
    if (size < needed)
        fail(Code::kInvalidValue, name, "SizeInBytes = ", size, ", but ", needed,
             " bytes are needed");
    void* pointer = reinterpret_cast<void*>(address);
    if (!pointer || !device.isAccessible(pointer, needed))
        fail(Code::kInvalidValue, name, " = ", pointer, " is not device memory of ", needed,
             " bytes");
}

const float* checkFloats(device::Device& device, const char* name, CUdeviceptr address,
                         size_t count) {
    void* pointer = reinterpret_cast<void*>(address);
    if (!pointer || address % sizeof(float) != 0 ||
        !device.isAccessible(pointer, count * sizeof(float)))
        fail(Code::kInvalidValue, name, " = ", pointer, " is not device memory of ", count,
             " floats");
    return static_cast<const float*>(pointer);
}

denoise::Format checkFormat(const std::string& name, OptixPixelFormat format) {
    switch (format) {
    case OPTIX_PIXEL_FORMAT_HALF2:
        return denoise::Format::kHalf2;
    case OPTIX_PIXEL_FORMAT_HALF3:
        return denoise::Format::kHalf3;
    case OPTIX_PIXEL_FORMAT_HALF4:
        return denoise::Format::kHalf4;
    case OPTIX_PIXEL_FORMAT_FLOAT2:
        return denoise::Format::kFloat2;
    case OPTIX_PIXEL_FORMAT_FLOAT3:
        return denoise::Format::kFloat3;
    case OPTIX_PIXEL_FORMAT_FLOAT4:
        return denoise::Format::kFloat4;
    case OPTIX_PIXEL_FORMAT_UCHAR3:
        return denoise::Format::kByte3;
    case OPTIX_PIXEL_FORMAT_UCHAR4:
        return denoise::Format::kByte4;
    case OPTIX_PIXEL_FORMAT_INTERNAL_GUIDE_LAYER:
        fail(Code::kInvalidValue, name,
             ".format is INTERNAL_GUIDE_LAYER, which is for internal "
             "guide layers only");
    }
    fail(Code::kInvalidValue, name, ".format = ", unsigned(format), " is unknown",
         format == 0 ? "; the options and the model of the denoiser need this image" : "");
}

// The requirements for a kind of image.
struct ImageRule {
    unsigned leastChannels;
    bool allowsBytes;
};
constexpr ImageRule kColorRule{3, true};
constexpr ImageRule kStatisticsRule{3, false};

denoise::Image checkImage(device::Device& device, const std::string& name, const OptixImage2D& from,
                          ImageRule rule) {
    denoise::Image image;
    image.format = checkFormat(name, from.format);
    if (denoise::channelsOf(image.format) < rule.leastChannels)
        fail(Code::kInvalidValue, name, ".format has ", denoise::channelsOf(image.format),
             " channels, at least ", rule.leastChannels, " are needed");
    if (!rule.allowsBytes && denoise::channelSizeOf(image.format) == 1)
        fail(Code::kInvalidValue, name,
             ".format is of type unsigned char, it must be half or "
             "float");
    checkSide((name + ".width").c_str(), from.width);
    checkSide((name + ".height").c_str(), from.height);
    size_t pixel = denoise::pixelSizeOf(image.format);
    if (from.pixelStrideInBytes != 0 && from.pixelStrideInBytes != pixel)
        fail(Code::kInvalidValue, name, ".pixelStrideInBytes = ", from.pixelStrideInBytes,
             " is neither 0 nor the ", pixel, " bytes of a pixel");
    if (from.rowStrideInBytes < pixel * from.width)
        fail(Code::kInvalidValue, name, ".rowStrideInBytes = ", from.rowStrideInBytes,
             " is less than a row of ", pixel * from.width, " bytes");
    size_t size = size_t(from.height - 1) * from.rowStrideInBytes + pixel * from.width;
    void* data = reinterpret_cast<void*>(from.data);
    if (!data || !device.isAccessible(data, size))
        fail(Code::kInvalidValue, name, ".data = ", data, " is not device memory of ", size,
             " bytes");
    image.data = static_cast<uint8_t*>(data);
    image.width = from.width;
    image.height = from.height;
    image.rowStride = from.rowStrideInBytes;
    image.pixelStride = pixel;
    return image;
}

// Requires `factor` times the input's width and height.
void requireSize(const std::string& name, const denoise::Image& image, const denoise::Image& input,
                 unsigned factor = 1) {
    if (image.width != factor * input.width || image.height != factor * input.height)
        fail(Code::kInvalidValue, name, " has ", image.width, " x ", image.height,
             " pixels, layers[0].input has ", input.width, " x ", input.height,
             factor == 1 ? "" : "; it must be twice as wide and high");
}

bool overlap(const denoise::Image& a, const denoise::Image& b) {
    auto end = [](const denoise::Image& image) {
        return image.pixel(0, image.height - 1) + image.width * image.pixelStride;
    };
    return a.data < end(b) && b.data < end(a);
}

// Checks one call of optixDenoiserInvoke and converts it to an engine request.
class InvokeCheck {
public:
    InvokeCheck(DenoiserObject& denoiser, const OptixDenoiserParams& params)
        : model_(denoiser.model), factor_(denoiser.filter->factor()), abi_(denoiser.context->abi),
          device_(*denoiser.context->engine->device), params_(params) {
        request_.filter = denoiser.filter;
    }

    engine::DenoiseRequest take(const OptixDenoiserGuideLayer& guides,
                                const OptixDenoiserLayer* layers, unsigned count, unsigned offsetX,
                                unsigned offsetY) {
        frame_.offsetX = offsetX;
        frame_.offsetY = offsetY;
        frame_.isLimited = model_.kind == denoise::Kind::kLimited;
        frame_.isTemporal = denoise::isTemporal(model_.kind);
        // Clients before 7.5 always pass a previous image: in a first frame the noisy one.
        frame_.hasPrevious = abi_ < kAbi75 || params_.temporalModeUsePreviousLayers != 0;
        checkParams();
        if (count == 0 || (count > 1 && !denoise::takesLayers(model_.kind)))
            fail(Code::kInvalidValue, "numLayers = ", count, ", but this kind of denoiser takes ",
                 denoise::takesLayers(model_.kind) ? "at least 1" : "1");
        for (unsigned i = 0; i < count; ++i)
            addLayer(layers[i], message("layers[", i, "]"));
        checkGuides(guides);
        return std::move(request_);
    }

private:
    void checkParams() {
        if (!(params_.blendFactor >= 0.0f && params_.blendFactor <= 1.0f))
            fail(Code::kInvalidValue, "params->blendFactor = ", params_.blendFactor,
                 " is not 0 to 1");
        frame_.blend = params_.blendFactor;
        bool takesLayers = denoise::takesLayers(model_.kind);
        if (params_.denoiseAlpha > 2)
            fail(Code::kInvalidValue, "params->denoiseAlpha = ", params_.denoiseAlpha,
                 " is not 0, 1 or 2");
        // "Separately" is an additional pass, but an AOV uses the beauty's weights.
        if (params_.denoiseAlpha != 0)
            frame_.alpha = params_.denoiseAlpha == 1 && takesLayers ? denoise::AlphaMode::kTogether
                                                                    : denoise::AlphaMode::kSeparate;
        if (params_.hdrIntensity && !frame_.isLimited)
            request_.inputs.intensity =
                checkFloats(device_, "params->hdrIntensity", params_.hdrIntensity, 1);
        if (params_.hdrAverageColor && takesLayers)
            request_.inputs.averageColor =
                checkFloats(device_, "params->hdrAverageColor", params_.hdrAverageColor, 3);
    }

    void addLayer(const OptixDenoiserLayer& from, const std::string& name) {
        denoise::Layer layer;
        layer.input = checkImage(device_, name + ".input", from.input, kColorRule);
        layer.output = checkImage(device_, name + ".output", from.output, kColorRule);
        if (!frame_.layers.empty())
            requireSize(name + ".input", layer.input, frame_.layers[0].input);
        checkWindow(name, layer);
        if (frame_.isTemporal && frame_.hasPrevious) {
            layer.previous =
                checkImage(device_, name + ".previousOutput", from.previousOutput, kColorRule);
            requireSize(name + ".previousOutput", layer.previous, layer.input, factor_);
        }
        if (factor_ != 1 && overlap(layer.input, layer.output))
            fail(Code::kInvalidValue, name,
                 ".input and output share memory, but an upscaling denoiser's output is larger");
        bool inPlace = layer.output.data == layer.input.pixel(frame_.offsetX, frame_.offsetY);
        if (inPlace && frame_.blend != 0.0f && layer.input.format != layer.output.format)
            fail(Code::kInvalidValue, name,
                 ".input and output share memory; with a blendFactor "
                 "their formats must be the same");
        frame_.layers.push_back(layer);
    }

    void checkWindow(const std::string& name, const denoise::Layer& layer) const {
        const denoise::Image &in = layer.input, &out = layer.output;
        if (out.width % factor_ != 0 || out.height % factor_ != 0)
            fail(Code::kInvalidValue, name, ".output of ", out.width, " x ", out.height,
                 " pixels is not twice as wide and high as what it shows of the input");
        if (frame_.offsetX >= in.width || out.width / factor_ > in.width - frame_.offsetX ||
            frame_.offsetY >= in.height || out.height / factor_ > in.height - frame_.offsetY)
            fail(Code::kInvalidValue, name, ".output of ", out.width, " x ", out.height,
                 " pixels at inputOffset (", frame_.offsetX, ", ", frame_.offsetY,
                 ") is not inside the input of ", in.width, " x ", in.height,
                 factor_ == 1 ? "" : ", of which each pixel becomes 2 x 2");
    }

    void checkGuides(const OptixDenoiserGuideLayer& guides) {
        const denoise::Image& input = frame_.layers[0].input;
        auto guide = [&](const char* name, const OptixImage2D& from, ImageRule rule) {
            denoise::Image image = checkImage(device_, name, from, rule);
            requireSize(name, image, input);
            return image;
        };
        // A guide that was not requested at creation is ignored.
        if (model_.usesAlbedo)
            frame_.albedo = guide("guideLayer->albedo", guides.albedo, {3, true});
        if (model_.usesNormal)
            frame_.normal =
                guide("guideLayer->normal", guides.normal, {frame_.isTemporal ? 3u : 2u, false});
        if (frame_.isTemporal && frame_.hasPrevious)
            frame_.flow = guide("guideLayer->flow", guides.flow, {2, false});
    }

    const denoise::Model& model_;
    unsigned factor_; // output pixels per input pixel, in each direction
    Abi abi_;
    device::Device& device_;
    const OptixDenoiserParams& params_;
    engine::DenoiseRequest request_;
    denoise::Frame& frame_ = request_.frame;
};

// The setup of a state memory.
DenoiserObject::Setup setupOf(DenoiserObject& denoiser, CUdeviceptr state) {
    std::lock_guard lock(denoiser.mutex);
    if (denoiser.setups.empty())
        throw ResultError(OPTIX_ERROR_DENOISER_NOT_INITIALIZED,
                          "optixDenoiserSetup was not called for this denoiser");
    auto found = denoiser.setups.find(state);
    if (found == denoiser.setups.end())
        fail(Code::kInvalidValue, "denoiserState = ", reinterpret_cast<void*>(state),
             " was not passed to optixDenoiserSetup");
    return found->second;
}

// Scratch memory of the statistics functions: a number of words, plus words per pixel. The formulas
// are in the 7.4 manual; from 7.5 on clients query the sizes.
struct ScratchWords {
    size_t fixed, perPixel;
    size_t bytes(size_t pixels) const { return sizeof(int) * (fixed + perPixel * pixels); }
};
constexpr ScratchWords kIntensityScratch{2, 1};
constexpr ScratchWords kAverageColorScratch{3, 3};

// Checks the arguments that both statistics functions share.
denoise::Image checkStatistics(DenoiserObject& denoiser, const OptixImage2D* inputImage,
                               CUdeviceptr scratch, size_t scratchSize, ScratchWords needed) {
    requireNonNull(inputImage, "inputImage");
    device::Device& device = *denoiser.context->engine->device;
    denoise::Image image = checkImage(device, "inputImage", *inputImage, kStatisticsRule);
    checkMemory(device, "scratch", scratch, scratchSize,
                needed.bytes(size_t(image.width) * image.height));
    return image;
}

} // namespace

OptixResult denoiserCreate(OptixDeviceContext context, OptixDenoiserModelKind modelKind,
                           const OptixDenoiserOptions* options, OptixDenoiser* denoiser) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixDenoiserCreate", [&] {
        contextOf(context);
        requireNonNull(denoiser, "denoiser");
        *denoiser = nullptr;
        requireNonNull(options, "options");
        denoise::Model model;
        model.kind = checkKind(modelKind, owner->abi);
        model.usesAlbedo = options->guideAlbedo != 0;
        model.usesNormal = options->guideNormal != 0;
        *denoiser = makeDenoiser(owner, model);
    });
}

OptixResult denoiserCreateWithUserModel(OptixDeviceContext context, const void* userData,
                                        size_t userDataSizeInBytes, OptixDenoiser* denoiser) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixDenoiserCreateWithUserModel", [&] {
        contextOf(context);
        requireNonNull(denoiser, "denoiser");
        *denoiser = nullptr;
        requireNonNull(userData, "userData");
        *denoiser = makeDenoiser(owner, checkUserModel(userData, userDataSizeInBytes));
    });
}

OptixResult denoiserDestroy(OptixDenoiser denoiser) {
    // Queued work shares ownership of its data, so destruction does not wait.
    return guarded(peek(denoiser), "optixDenoiserDestroy", [&] {
        denoiserOf(denoiser);
        denoisers().remove(denoiser);
    });
}

OptixResult denoiserComputeMemoryResources(const OptixDenoiser denoiser, unsigned outputWidth,
                                           unsigned outputHeight, OptixDenoiserSizes* returnSizes) {
    return guarded(peek(denoiser), "optixDenoiserComputeMemoryResources", [&] {
        std::shared_ptr<DenoiserObject> object = denoiserOf(denoiser);
        requireNonNull(returnSizes, "returnSizes");
        checkSide("outputWidth", outputWidth);
        checkSide("outputHeight", outputHeight);
        const denoise::Filter& filter = filterOf(*object);
        object->context->engine->backend->prepareDenoiser(denoise::guidePlanesOf(object->model));
        unsigned overlap = filter.overlap();
        returnSizes->stateSizeInBytes = engine::kDenoiserStateSize;
        returnSizes->withOverlapScratchSizeInBytes =
            filter.scratchSize(outputWidth + 2 * overlap, outputHeight + 2 * overlap);
        // 7.0 calls the two "minimum" and "recommended": the recommended size must suffice for
        // tiles, too.
        returnSizes->withoutOverlapScratchSizeInBytes =
            object->context->abi < kAbi71 ? returnSizes->withOverlapScratchSizeInBytes
                                          : filter.scratchSize(outputWidth, outputHeight);
        returnSizes->overlapWindowSizeInPixels = overlap;
        const size_t pixels = size_t(outputWidth + 2 * overlap) * (outputHeight + 2 * overlap);
        returnSizes->computeAverageColorSizeInBytes = kAverageColorScratch.bytes(pixels);
        returnSizes->computeIntensitySizeInBytes = kIntensityScratch.bytes(pixels);
        returnSizes->internalGuideLayerPixelSizeInBytes = 0; // the stored layer is the output
                                                             // itself
    });
}

OptixResult denoiserSetup(OptixDenoiser denoiser, CUstream stream, unsigned inputWidth,
                          unsigned inputHeight, CUdeviceptr denoiserState,
                          size_t denoiserStateSizeInBytes, CUdeviceptr scratch,
                          size_t scratchSizeInBytes) {
    return guarded(peek(denoiser), "optixDenoiserSetup", [&] {
        std::shared_ptr<DenoiserObject> object = denoiserOf(denoiser);
        device::Device& device = *object->context->engine->device;
        checkSide("inputWidth", inputWidth);
        checkSide("inputHeight", inputHeight);
        checkMemory(device, "denoiserState", denoiserState, denoiserStateSizeInBytes,
                    engine::kDenoiserStateSize);
        checkMemory(device, "scratch", scratch, scratchSizeInBytes,
                    filterOf(*object).scratchSize(inputWidth, inputHeight));
        const engine::DenoiserSetup setup{reinterpret_cast<void*>(denoiserState), inputWidth,
                                          inputHeight, stream};
        const engine::ContextPtr& engine = object->context->engine;
        engine->backend->setupDenoiser(engine, setup);
        std::lock_guard lock(object->mutex);
        object->setups[denoiserState] = {inputWidth, inputHeight};
    });
}

void invoke(DenoiserObject& denoiser, const InvokePlace& place, const OptixDenoiserParams& params,
            const OptixDenoiserGuideLayer& guideLayer, const OptixDenoiserLayer* layers,
            unsigned numLayers) {
    device::Device& device = *denoiser.context->engine->device;
    const denoise::Filter& filter = filterOf(denoiser);
    DenoiserObject::Setup setup = setupOf(denoiser, place.state);
    checkMemory(device, "denoiserState", place.state, place.stateSize, engine::kDenoiserStateSize);
    engine::DenoiseRequest request =
        InvokeCheck(denoiser, params)
            .take(guideLayer, layers, numLayers, place.inputOffsetX, place.inputOffsetY);
    const denoise::Image& input = request.frame.layers[0].input;
    if (input.width > setup.width || input.height > setup.height)
        fail(Code::kInvalidValue, "layers[0].input has ", input.width, " x ", input.height,
             " pixels, more than the ", setup.width, " x ", setup.height, " of optixDenoiserSetup");
    checkMemory(device, "scratch", place.scratch, place.scratchSize,
                filter.scratchSize(input.width, input.height));
    request.inputs.state = reinterpret_cast<const void*>(place.state);
    request.inputs.width = input.width;
    request.inputs.height = input.height;
    request.scratch = reinterpret_cast<void*>(place.scratch);
    request.stream = place.stream;
    const engine::ContextPtr& engine = denoiser.context->engine;
    engine->backend->denoise(engine, std::move(request));
}

OptixResult denoiserInvoke(OptixDenoiser denoiser, CUstream stream,
                           const OptixDenoiserParams* params, CUdeviceptr denoiserState,
                           size_t denoiserStateSizeInBytes,
                           const OptixDenoiserGuideLayer* guideLayer,
                           const OptixDenoiserLayer* layers, unsigned numLayers,
                           unsigned inputOffsetX, unsigned inputOffsetY, CUdeviceptr scratch,
                           size_t scratchSizeInBytes) {
    return guarded(peek(denoiser), "optixDenoiserInvoke", [&] {
        std::shared_ptr<DenoiserObject> object = denoiserOf(denoiser);
        requireNonNull(params, "params");
        requireNonNull(guideLayer, "guideLayer");
        requireNonNull(layers, "layers");
        const InvokePlace place{stream,       denoiserState, denoiserStateSizeInBytes, inputOffsetX,
                                inputOffsetY, scratch,       scratchSizeInBytes};
        invoke(*object, place, *params, *guideLayer, layers, numLayers);
    });
}

OptixResult denoiserComputeIntensity(OptixDenoiser denoiser, CUstream stream,
                                     const OptixImage2D* inputImage, CUdeviceptr outputIntensity,
                                     CUdeviceptr scratch, size_t scratchSizeInBytes) {
    return guarded(peek(denoiser), "optixDenoiserComputeIntensity", [&] {
        std::shared_ptr<DenoiserObject> object = denoiserOf(denoiser);
        denoise::Image image =
            checkStatistics(*object, inputImage, scratch, scratchSizeInBytes, kIntensityScratch);
        device::Device& device = *object->context->engine->device;
        checkFloats(device, "outputIntensity", outputIntensity, 1);
        const engine::ContextPtr& engine = object->context->engine;
        engine->backend->imageStatistics(
            engine, {engine::StatisticsRequest::kIntensity, image, reinterpret_cast<void*>(scratch),
                     reinterpret_cast<float*>(outputIntensity), stream});
    });
}

OptixResult denoiserComputeAverageColor(OptixDenoiser denoiser, CUstream stream,
                                        const OptixImage2D* inputImage,
                                        CUdeviceptr outputAverageColor, CUdeviceptr scratch,
                                        size_t scratchSizeInBytes) {
    return guarded(peek(denoiser), "optixDenoiserComputeAverageColor", [&] {
        std::shared_ptr<DenoiserObject> object = denoiserOf(denoiser);
        denoise::Image image =
            checkStatistics(*object, inputImage, scratch, scratchSizeInBytes, kAverageColorScratch);
        device::Device& device = *object->context->engine->device;
        checkFloats(device, "outputAverageColor", outputAverageColor, 3);
        const engine::ContextPtr& engine = object->context->engine;
        engine->backend->imageStatistics(engine,
                                         {engine::StatisticsRequest::kAverageColor, image,
                                          reinterpret_cast<void*>(scratch),
                                          reinterpret_cast<float*>(outputAverageColor), stream});
    });
}

} // namespace sunstone::optix7
