// SPDX-License-Identifier: Apache-2.0
// Texture and surface references. A variable of type .texref or .surfref holds the handle of an
// object, and code that names the variable uses the object. Each change of a reference makes a new
// object and stores its handle in the variable. An unusable reference holds 0, which reads as
// zeros. The results of all calls were recorded on a GPU, which accepts meaningless values.
#include "api/cuda/driver/memory/textures.h"
#include "api/cuda/driver/modules/module.h"

#include "base/handles.h"
#include "base/log.h"

#include <algorithm>
#include <cstring>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

constexpr size_t kBaseAlignment = 512, kMostTexels = size_t(1) << 28;

struct Reference : Handled {
    std::weak_ptr<Module> module;
    std::string name;
    uint64_t* variable = nullptr; // in the module; null: a reference made by the program
    bool isBound = false;
    CUDA_RESOURCE_DESC resource = {};
    CUDA_TEXTURE_DESC texture = {};
    CUarray_format format = CU_AD_FORMAT_FLOAT;
    unsigned channels = 1;
    uint64_t object = 0; // texture or surface that the variable names

    ~Reference() { drop(); }
    void drop() {
        texture::removeTexture(object);
        texture::removeSurface(object);
        object = 0;
    }
};
struct TextureReference : Reference {};
struct SurfaceReference : Reference {};

template <class T>
HandleTable<T>& references() {
    static auto* table = new HandleTable<T>;
    return *table;
}

// The reference for a name; one for each variable.
template <class T, class Handle>
void get(Handle* handle, CUmodule moduleHandle, const char* name, ptx::Type type) {
    require(handle && name && *name, "reference or name is null or empty");
    const std::shared_ptr<Module> module = moduleOf(moduleHandle);
    void* address = nullptr;
    uint64_t size = 0;
    if (module->referenceType(name) != type || !module->variable(name, &address, &size))
        refuse(CUDA_ERROR_NOT_FOUND, "the module has no such reference: ", name);
    references<T>().removeIf([](const T& r) { return r.variable && r.module.expired(); });
    std::shared_ptr<T> found = references<T>().findIf(
        [&](const T& r) { return r.variable == address && !r.module.expired(); });
    if (!found) {
        found = std::make_shared<T>();
        found->module = module;
        found->name = name;
        found->variable = static_cast<uint64_t*>(address);
        std::fill_n(found->texture.addressMode, 3, CU_TR_ADDRESS_MODE_CLAMP);
        references<T>().add(found);
    }
    *handle = static_cast<Handle>(found->handle());
}

template <class T>
std::shared_ptr<T> find(const void* handle) {
    std::shared_ptr<T> found = references<T>().find(handle);
    if (!found || (found->variable && found->module.expired()))
        refuse(CUDA_ERROR_INVALID_HANDLE, handle, " is not a live reference");
    return found;
}

// Makes the object for the reference's current state.
void apply(TextureReference& reference) {
    if (!reference.variable)
        return;
    cpu::streams().synchronizeAll(); // queued work uses the previous object
    uint64_t made = 0;
    CUDA_TEXTURE_DESC description = reference.texture;
    for (CUfilter_mode* mode : {&description.filterMode, &description.mipmapFilterMode})
        if (*mode != CU_TR_FILTER_MODE_LINEAR)
            *mode = CU_TR_FILTER_MODE_POINT;
    try {
        if (reference.isBound)
            made = createTexture(reference.resource, description, nullptr);
    } catch (const Error& error) {
        log(LogLevel::kWarning, "cuda",
            message("texture reference ", reference.name, " reads as zeros: ", error.what()));
    }
    reference.drop();
    reference.object = made;
    *reference.variable = made;
}

// Calls `change` with a reference, then applies the change.
template <class Change>
CUresult set(const char* function, CUtexref handle, Change&& change) {
    return guarded(function, Needs::kObject, [&] {
        const auto reference = find<TextureReference>(handle);
        change(*reference);
        apply(*reference);
    });
}
// Writes to *out the result of `value` for a reference.
template <class T, class Value>
CUresult ask(const char* function, CUtexref handle, T* out, Value&& value) {
    return guarded(function, Needs::kObject, [&] {
        require(out, "the result is null");
        *out = value(*find<TextureReference>(handle));
    });
}

// Writes to *out a property of the bound resource; for other kinds of resource it throws
// CUDA_ERROR_INVALID_VALUE and *out is null.
template <class T, class Value>
CUresult askBound(const char* function, CUtexref handle, T* out,
                  std::initializer_list<CUresourcetype> types, Value&& value) {
    return guarded(function, Needs::kObject, [&] {
        require(out, "the result is null");
        *out = T{};
        const auto reference = find<TextureReference>(handle);
        require(reference->isBound && std::find(types.begin(), types.end(),
                                                reference->resource.resType) != types.end(),
                "the reference is not bound to that");
        *out = value(reference->resource);
    });
}

void bind(Reference& reference, CUresourcetype type, const CUDA_ARRAY3D_DESCRIPTOR& shape) {
    reference.isBound = true;
    reference.resource = {};
    reference.resource.resType = type;
    reference.format = shape.Format;
    reference.channels = shape.NumChannels;
}

void checkDimension(int dimension) {
    require(dimension >= 0 && dimension < 3, "dimension must be 0, 1 or 2");
}

} // namespace

SUNSTONE_EXPORT CUresult cuModuleGetTexRef(CUtexref* reference, CUmodule module, const char* name) {
    return guarded("cuModuleGetTexRef", Needs::kObject,
                   [&] { get<TextureReference>(reference, module, name, ptx::Type::kTexref); });
}
SUNSTONE_EXPORT CUresult cuModuleGetSurfRef(CUsurfref* reference, CUmodule module,
                                            const char* name) {
    return guarded("cuModuleGetSurfRef", Needs::kObject,
                   [&] { get<SurfaceReference>(reference, module, name, ptx::Type::kSurfref); });
}
SUNSTONE_EXPORT CUresult cuTexRefCreate(CUtexref* reference) {
    return guarded("cuTexRefCreate", Needs::kContext, [&] {
        require(reference, "reference is null");
        auto made = std::make_shared<TextureReference>();
        std::fill_n(made->texture.addressMode, 3, CU_TR_ADDRESS_MODE_CLAMP);
        *reference = static_cast<CUtexref>(references<TextureReference>().add(made));
    });
}
SUNSTONE_EXPORT CUresult cuTexRefDestroy(CUtexref reference) {
    return guarded("cuTexRefDestroy", Needs::kObject, [&] {
        if (!find<TextureReference>(reference)->variable) // a module's reference is destroyed with
                                                          // the module
            references<TextureReference>().remove(reference);
    });
}

SUNSTONE_EXPORT CUresult cuTexRefSetArray(CUtexref reference, CUarray array, unsigned int flags) {
    return set("cuTexRefSetArray", reference, [&](Reference& r) {
        require(flags <= CU_TRSA_OVERRIDE_FORMAT, "unknown flags");
        bind(r, CU_RESOURCE_TYPE_ARRAY, arrayOf(array)->descriptor);
        r.resource.res.array.hArray = array;
    });
}
SUNSTONE_EXPORT CUresult cuTexRefSetMipmappedArray(CUtexref reference, CUmipmappedArray mipmap,
                                                   unsigned int flags) {
    return set("cuTexRefSetMipmappedArray", reference, [&](Reference& r) {
        require(flags <= CU_TRSA_OVERRIDE_FORMAT, "unknown flags");
        bind(r, CU_RESOURCE_TYPE_MIPMAPPED_ARRAY, mipmapOf(mipmap)->levels[0]->descriptor);
        r.resource.res.mipmap.hMipmappedArray = mipmap;
    });
}
SUNSTONE_EXPORT CUresult cuTexRefSetAddress(size_t* offset, CUtexref reference, CUdeviceptr address,
                                            size_t bytes) {
    return set("cuTexRefSetAddress", reference, [&](Reference& r) {
        const size_t past = address % kBaseAlignment;
        require(offset || past == 0, "the address is not aligned, and offset is null");
        const size_t texel = formatOf(r.format, r.channels).elementBytes();
        require(bytes / texel <= kMostTexels, "more than 2^28 texels");
        bind(r, CU_RESOURCE_TYPE_LINEAR, {0, 0, 0, r.format, r.channels, 0});
        r.resource.res.linear = {address - past, r.format, r.channels, bytes + past};
        if (offset)
            *offset = past;
    });
}
SUNSTONE_EXPORT CUresult cuTexRefSetAddress2D(CUtexref reference,
                                              const CUDA_ARRAY_DESCRIPTOR* shape,
                                              CUdeviceptr address, size_t pitch) {
    return set("cuTexRefSetAddress2D", reference, [&](Reference& r) {
        require(shape, "shape is null");
        const size_t texel = formatOf(shape->Format, shape->NumChannels).elementBytes();
        size_t row = 0;
        require(!__builtin_mul_overflow(shape->Width, texel, &row) && row <= pitch &&
                    pitch % 32 == 0 && pitch <= kMaxPitch,
                "the pitch is shorter than a row or no multiple of 32");
        require(address % kBaseAlignment == 0, "the address is no multiple of 512");
        bind(r, CU_RESOURCE_TYPE_PITCH2D, {0, 0, 0, shape->Format, shape->NumChannels, 0});
        r.resource.res.pitch2D = {address,      shape->Format, shape->NumChannels,
                                  shape->Width, shape->Height, pitch};
    });
}
#undef cuTexRefSetAddress2D
SUNSTONE_EXPORT CUresult cuTexRefSetAddress2D_v2(CUtexref reference,
                                                 const CUDA_ARRAY_DESCRIPTOR* shape,
                                                 CUdeviceptr address, size_t pitch) {
    return cuTexRefSetAddress2D_v3(reference, shape, address, pitch);
}

SUNSTONE_EXPORT CUresult cuTexRefSetFormat(CUtexref reference, CUarray_format format,
                                           int channels) {
    return set("cuTexRefSetFormat", reference, [&](Reference& r) {
        require(channels == 1 || channels == 2 || channels == 4, "channels must be 1, 2 or 4");
        r.format = format;
        r.channels = unsigned(channels);
    });
}
SUNSTONE_EXPORT CUresult cuTexRefSetAddressMode(CUtexref reference, int dimension,
                                                CUaddress_mode mode) {
    return set("cuTexRefSetAddressMode", reference, [&](Reference& r) {
        checkDimension(dimension);
        r.texture.addressMode[dimension] =
            unsigned(mode) <= CU_TR_ADDRESS_MODE_BORDER ? mode : CU_TR_ADDRESS_MODE_CLAMP;
    });
}
SUNSTONE_EXPORT CUresult cuTexRefSetFilterMode(CUtexref reference, CUfilter_mode mode) {
    return set("cuTexRefSetFilterMode", reference,
               [&](Reference& r) { r.texture.filterMode = mode; });
}
SUNSTONE_EXPORT CUresult cuTexRefSetMipmapFilterMode(CUtexref reference, CUfilter_mode mode) {
    return set("cuTexRefSetMipmapFilterMode", reference,
               [&](Reference& r) { r.texture.mipmapFilterMode = mode; });
}
SUNSTONE_EXPORT CUresult cuTexRefSetMipmapLevelBias(CUtexref reference, float bias) {
    return set("cuTexRefSetMipmapLevelBias", reference,
               [&](Reference& r) { r.texture.mipmapLevelBias = bias; });
}
SUNSTONE_EXPORT CUresult cuTexRefSetMipmapLevelClamp(CUtexref reference, float least, float most) {
    return set("cuTexRefSetMipmapLevelClamp", reference, [&](Reference& r) {
        r.texture.minMipmapLevelClamp = least;
        r.texture.maxMipmapLevelClamp = most;
    });
}
SUNSTONE_EXPORT CUresult cuTexRefSetMaxAnisotropy(CUtexref reference, unsigned int most) {
    return set("cuTexRefSetMaxAnisotropy", reference,
               [&](Reference& r) { r.texture.maxAnisotropy = most; });
}
SUNSTONE_EXPORT CUresult cuTexRefSetBorderColor(CUtexref reference, float* color) {
    return set("cuTexRefSetBorderColor", reference, [&](Reference& r) {
        require(color, "color is null");
        std::copy_n(color, 4, r.texture.borderColor);
    });
}
SUNSTONE_EXPORT CUresult cuTexRefSetFlags(CUtexref reference, unsigned int flags) {
    return set("cuTexRefSetFlags", reference, [&](Reference& r) {
        constexpr unsigned kKnown = CU_TRSF_READ_AS_INTEGER | CU_TRSF_NORMALIZED_COORDINATES |
                                    CU_TRSF_SRGB | CU_TRSF_DISABLE_TRILINEAR_OPTIMIZATION;
        require((flags & ~kKnown) == 0, "unknown flags");
        r.texture.flags = flags;
    });
}

SUNSTONE_EXPORT CUresult cuTexRefGetAddress(CUdeviceptr* address, CUtexref reference) {
    return askBound("cuTexRefGetAddress", reference, address,
                    {CU_RESOURCE_TYPE_LINEAR, CU_RESOURCE_TYPE_PITCH2D},
                    [](const CUDA_RESOURCE_DESC& resource) {
                        return resource.resType == CU_RESOURCE_TYPE_LINEAR
                                   ? resource.res.linear.devPtr
                                   : resource.res.pitch2D.devPtr;
                    });
}
SUNSTONE_EXPORT CUresult cuTexRefGetArray(CUarray* array, CUtexref reference) {
    return askBound("cuTexRefGetArray", reference, array, {CU_RESOURCE_TYPE_ARRAY},
                    [](const CUDA_RESOURCE_DESC& resource) { return resource.res.array.hArray; });
}
SUNSTONE_EXPORT CUresult cuTexRefGetMipmappedArray(CUmipmappedArray* mipmap, CUtexref reference) {
    return askBound(
        "cuTexRefGetMipmappedArray", reference, mipmap, {CU_RESOURCE_TYPE_MIPMAPPED_ARRAY},
        [](const CUDA_RESOURCE_DESC& resource) { return resource.res.mipmap.hMipmappedArray; });
}
SUNSTONE_EXPORT CUresult cuTexRefGetFormat(CUarray_format* format, int* channels,
                                           CUtexref reference) {
    return ask("cuTexRefGetFormat", reference, format, [&](const Reference& r) {
        if (channels)
            *channels = int(r.channels);
        return r.format;
    });
}
SUNSTONE_EXPORT CUresult cuTexRefGetAddressMode(CUaddress_mode* mode, CUtexref reference,
                                                int dimension) {
    return ask("cuTexRefGetAddressMode", reference, mode, [&](const Reference& r) {
        checkDimension(dimension);
        return r.texture.addressMode[dimension];
    });
}
SUNSTONE_EXPORT CUresult cuTexRefGetFilterMode(CUfilter_mode* mode, CUtexref reference) {
    return ask("cuTexRefGetFilterMode", reference, mode,
               [](const Reference& r) { return r.texture.filterMode; });
}
SUNSTONE_EXPORT CUresult cuTexRefGetMipmapFilterMode(CUfilter_mode* mode, CUtexref reference) {
    return ask("cuTexRefGetMipmapFilterMode", reference, mode,
               [](const Reference& r) { return r.texture.mipmapFilterMode; });
}
SUNSTONE_EXPORT CUresult cuTexRefGetMipmapLevelBias(float* bias, CUtexref reference) {
    return ask("cuTexRefGetMipmapLevelBias", reference, bias,
               [](const Reference& r) { return r.texture.mipmapLevelBias; });
}
SUNSTONE_EXPORT CUresult cuTexRefGetMipmapLevelClamp(float* least, float* most,
                                                     CUtexref reference) {
    return ask("cuTexRefGetMipmapLevelClamp", reference, least, [&](const Reference& r) {
        if (most)
            *most = r.texture.maxMipmapLevelClamp;
        return r.texture.minMipmapLevelClamp;
    });
}
SUNSTONE_EXPORT CUresult cuTexRefGetMaxAnisotropy(int* most, CUtexref reference) {
    return ask("cuTexRefGetMaxAnisotropy", reference, most,
               [](const Reference& r) { return int(r.texture.maxAnisotropy); });
}
SUNSTONE_EXPORT CUresult cuTexRefGetBorderColor(float* color, CUtexref reference) {
    return ask("cuTexRefGetBorderColor", reference, color, [&](const Reference& r) {
        std::copy_n(r.texture.borderColor + 1, 3, color + 1);
        return r.texture.borderColor[0];
    });
}
SUNSTONE_EXPORT CUresult cuTexRefGetFlags(unsigned int* flags, CUtexref reference) {
    return ask("cuTexRefGetFlags", reference, flags,
               [](const Reference& r) { return r.texture.flags; });
}

SUNSTONE_EXPORT CUresult cuSurfRefSetArray(CUsurfref reference, CUarray array, unsigned int flags) {
    return guarded("cuSurfRefSetArray", Needs::kObject, [&] {
        const auto surface = find<SurfaceReference>(reference);
        require(flags == 0, "flags must be 0");
        CUDA_RESOURCE_DESC resource = {};
        resource.resType = CU_RESOURCE_TYPE_ARRAY;
        resource.res.array.hArray = array;
        const uint64_t made = createSurface(resource);
        cpu::streams().synchronizeAll(); // queued work uses the previous object
        surface->drop();
        surface->isBound = true;
        surface->resource = resource;
        surface->object = *surface->variable = made;
    });
}
SUNSTONE_EXPORT CUresult cuSurfRefGetArray(CUarray* array, CUsurfref reference) {
    return guarded("cuSurfRefGetArray", Needs::kObject, [&] {
        require(array, "array is null");
        const auto surface = find<SurfaceReference>(reference);
        require(surface->isBound, "the reference is not bound");
        *array = surface->resource.res.array.hArray;
    });
}

SUNSTONE_EXPORT CUresult cuParamSetTexRef(CUfunction function, int unit, CUtexref reference) {
    return guarded("cuParamSetTexRef", Needs::kObject, [&] {
        liveFunctionOf(function);
        find<TextureReference>(reference);
        require(unit == CU_PARAM_TR_DEFAULT, "unit must be CU_PARAM_TR_DEFAULT");
    });
}
