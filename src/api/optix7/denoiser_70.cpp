// SPDX-License-Identifier: Apache-2.0
// The denoiser of OptiX 7.0 to 7.2: created for a kind of input, then given a model, and invoked
// with an array of images: the colours, the guides of the kind of input, and (7.2, AOV models) more
// layers to denoise.
#include "api/optix7/denoiser.h"
#include "api/optix7/entry_points.h"
#include "base/readable.h"

#include <vector>

namespace sunstone::optix7 {
namespace {

constexpr int kUserModel = 0x2321; // OPTIX_DENOISER_MODEL_KIND_USER

unsigned guidesOf(const denoise::Model& model) {
    return unsigned(model.usesAlbedo) + unsigned(model.usesNormal);
}

// The images of one call, grouped as in later releases.
struct Layers {
    OptixDenoiserGuideLayer guides{};
    std::vector<OptixDenoiserLayer> layers;
};

Layers layersOf(const denoise::Model& model, const OptixImage2D* inputs, unsigned numInputs,
                const OptixImage2D* outputs) {
    const unsigned guides = guidesOf(model);
    if (numInputs < 1 + guides)
        fail(Code::kInvalidValue, "numInputLayers = ", numInputs, ", but the kind of input has ",
             1 + guides, " layers");
    if (numInputs > 1 + guides && !denoise::takesLayers(model.kind))
        fail(Code::kInvalidValue, "numInputLayers = ", numInputs, ", but this model takes the ",
             1 + guides, " of its kind of input only");
    Layers out;
    unsigned next = 1;
    if (model.usesAlbedo)
        out.guides.albedo = inputs[next++];
    if (model.usesNormal)
        out.guides.normal = inputs[next++];
    out.layers.push_back({inputs[0], {}, outputs[0]});
    for (; next < numInputs; ++next)
        out.layers.push_back({inputs[next], {}, outputs[next - guides]});
    return out;
}

} // namespace

OptixResult denoiserCreate70(OptixDeviceContext context, const DenoiserOptions70* options,
                             OptixDenoiser* denoiser) {
    std::shared_ptr<DeviceContext> owner = peek(context);
    return guarded(owner, "optixDenoiserCreate", [&] {
        contextOf(context);
        requireNonNull(denoiser, "denoiser");
        *denoiser = nullptr;
        requireNonNull(options, "options");
        const int kind = options->inputKind;
        if (kind != DenoiserOptions70::kColor && kind != DenoiserOptions70::kColorAlbedo &&
            kind != DenoiserOptions70::kColorAlbedoNormal)
            fail(Code::kInvalidValue, "options->inputKind = ", unsigned(kind), " is unknown");
        auto object = std::make_shared<DenoiserObject>();
        object->context = owner;
        object->model.usesAlbedo = kind != DenoiserOptions70::kColor;
        object->model.usesNormal = kind == DenoiserOptions70::kColorAlbedoNormal;
        *denoiser = static_cast<OptixDenoiser>(denoisers().add(object));
    });
}

OptixResult denoiserSetModel(OptixDenoiser denoiser, int kind, const void* data, size_t size) {
    return guarded(peek(denoiser), "optixDenoiserSetModel", [&] {
        std::shared_ptr<DenoiserObject> object = denoiserOf(denoiser);
        denoise::Model model = object->model;
        if (kind == kUserModel) {
            requireNonNull(data, "data");
            model = checkUserModel(data, size);
            if (model.usesAlbedo != object->model.usesAlbedo ||
                model.usesNormal != object->model.usesNormal)
                fail(Code::kInvalidValue, "the model uses ", guidesOf(model),
                     " guide layers, other ones than the denoiser's kind of input");
        } else {
            model.kind = checkKind(OptixDenoiserModelKind(kind), object->context->abi);
        }
        std::lock_guard lock(object->mutex);
        object->model = model;
        object->filter = denoise::makeFilter(model);
        object->setups.clear(); // setups of the previous model
    });
}

OptixResult denoiserInvoke70(OptixDenoiser denoiser, CUstream stream,
                             const OptixDenoiserParams* params, CUdeviceptr denoiserState,
                             size_t denoiserStateSizeInBytes, const OptixImage2D* inputLayers,
                             unsigned numInputLayers, unsigned inputOffsetX, unsigned inputOffsetY,
                             const OptixImage2D* outputLayer, CUdeviceptr scratch,
                             size_t scratchSizeInBytes) {
    return guarded(peek(denoiser), "optixDenoiserInvoke", [&] {
        std::shared_ptr<DenoiserObject> object = denoiserOf(denoiser);
        requireNonNull(params, "params");
        requireNonNull(inputLayers, "inputLayers");
        requireNonNull(outputLayer, "outputLayer");
        if (!isReadable(inputLayers, size_t(numInputLayers) * sizeof(OptixImage2D)))
            fail(Code::kInvalidValue, "inputLayers = ", static_cast<const void*>(inputLayers),
                 " is not an array of numInputLayers = ", numInputLayers, " images");
        const Layers given = layersOf(object->model, inputLayers, numInputLayers, outputLayer);
        const InvokePlace place{stream,       denoiserState, denoiserStateSizeInBytes, inputOffsetX,
                                inputOffsetY, scratch,       scratchSizeInBytes};
        invoke(*object, place, *params, given.guides, given.layers.data(),
               unsigned(given.layers.size()));
    });
}

} // namespace sunstone::optix7
