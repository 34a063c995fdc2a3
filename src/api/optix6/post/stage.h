// SPDX-License-Identifier: Apache-2.0
// Post-processing stages: filters of images whose inputs and outputs are buffers, and whose
// settings are variables with fixed names. The manual names neither stages nor variables; these are
// the ones that programs use. docs/classic.md has the table.
#pragma once

#include "api/optix6/buffer.h"
#include "api/optix6/variable.h"
#include "engine/denoiser.h"

#include <optional>
#include <string_view>

namespace sunstone::optix6 {

enum class StageKind : uint8_t { kToneMapper, kDenoiser, kStructurePredictor };

class PostProcessingStage : public Scoped {
public:
    static constexpr Kind kKind = Kind::kPostProcessingStage;
    // Creates the variables; the table of handles does not contain them yet.
    PostProcessingStage(const std::shared_ptr<Context>& context, StageKind stage);

    // The kind of a stage name that the application passes; none if the name is unknown.
    static std::optional<StageKind> kindOf(std::string_view name);
    static std::string knownNames();
    const char* stageName() const;

    // The predefined variable of this name. Throws if there is none, and at the second call.
    std::shared_ptr<Variable> declare(const std::string& name);
    // Filters, and waits for the result. Throws Failure if variables are missing or do not fit.
    void run();
    // Frees the memory of the filter, because the next run is on another device.
    void dropMemory() { small_ = {}, scratch_ = {}, copy_ = {}, isMeasured_ = false; }

private:
    struct Images {
        denoise::Image input, output, albedo, normal; // without data: absent
    };

    // Functions that read variables.
    const Variable& variable(const char* name) const;
    double number(const char* name, double fallback, double least, double most) const;
    std::shared_ptr<Buffer> bufferOf(const char* name, bool isRequired) const;
    denoise::Image image(const char* name, bool isRequired) const;
    void requireSize(const char* name, const denoise::Image& image, uint32_t width,
                     uint32_t height) const;
    std::optional<Images> images(uint32_t block) const;
    template <class... Parts>
    [[noreturn]] void refuseIt(RTresult result, const char* name, const Parts&... parts) const {
        refuse(result, "variable \"", name, "\" of stage \"", stageName(), "\" ", parts...);
    }

    void mapTones(const Images& images);
    void denoise(const Images& images);
    void predictStructure(const Images& images);
    // Input shared by the denoiser and the predictor: guides, range and brightness of the colours.
    denoise::Frame frameOf(const Images& images);
    void measure(const denoise::Image& image);
    void noteTrainingData();

    void reserve(size_t scratchBytes);
    void submit(const std::shared_ptr<const denoise::Filter>& filter, const denoise::Frame& frame);
    void submitTiles(const std::shared_ptr<const denoise::Filter>& filter,
                     const denoise::Frame& whole, uint32_t tileWidth, uint32_t tileHeight);

    const StageKind stage_;
    std::vector<const Variable*> declared_;
    bool toldOfTrainingData_ = false;
    // Memory of the filter, kept between runs.
    struct Small {
        alignas(128) uint8_t state[engine::kDenoiserStateSize];
        float intensity;
    };
    SharedMemory small_, scratch_, copy_;
    bool isMeasured_ = false; // small().intensity is valid
    Small& small() const { return *static_cast<Small*>(small_.get()); }
};

} // namespace sunstone::optix6
