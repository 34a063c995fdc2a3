// SPDX-License-Identifier: Apache-2.0
// Registration by compilers before main: fat binaries, kernels by their host stubs, variables by
// their host shadows. A fat binary is loaded at the first use of its contents.
#include "api/cuda/runtime/runtime.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sunstone::cudart {

namespace {

struct FatBinary {
    const void* wrapper = nullptr;
    CUmodule module = nullptr;
    cudaError_t error = cudaSuccess; // of loading; stays
    std::vector<void**> managed;     // host shadows
};

// The files that have registered a kernel or variable. Files and libraries share inline ones, and
// each registers them; the first file's are used.
class Owners {
public:
    FatBinary& first() const { return *files_.front(); }
    void add(FatBinary* file) {
        if (std::find(files_.begin(), files_.end(), file) == files_.end())
            files_.push_back(file);
    }
    // Whether it was one of them.
    bool remove(FatBinary* file) { return std::erase(files_, file) != 0; }
    bool empty() const { return files_.empty(); }

private:
    std::vector<FatBinary*> files_;
};

// __cudaGetKernel returns its address as the handle.
struct Kernel {
    Owners owners;
    std::string name;
    CUfunction function = nullptr;
};

struct Variable {
    Owners owners;
    std::string name;
    size_t size = 0;
};

struct Registry {
    std::recursive_mutex mutex;
    std::map<void**, std::unique_ptr<FatBinary>> binaries;
    std::map<const void*, std::unique_ptr<Kernel>> kernels;
    std::map<const void*, Variable> variables;
    std::map<const Kernel*, const void*> handles;
    std::map<const void*, cudaLibrary_t> libraryKernels; // those that the program has looked up
};

Registry& registry() {
    // Constructed by the first registration, which may run before our own constructors.
    static Registry* const instance = new Registry;
    return *instance;
}

void addVariable(FatBinary* binary, const void* host, const char* name, size_t size) {
    Variable& variable = registry().variables[host];
    variable.owners.add(binary);
    variable.name = name;
    variable.size = size;
}

FatBinary* binaryOf(void** handle) {
    auto found = registry().binaries.find(handle);
    return found == registry().binaries.end() ? nullptr : found->second.get();
}

// The struct that compilers register: a wrapper around the image. For relocatable device code the
// image is the device linker's result (empty if linking is left to us), and a list has its pieces.
struct Wrapper {
    uint32_t magic, version;
    const void* image;
    void* const* pieces; // version 2: images, up to a null
};
constexpr uint32_t kWrapperMagic = 0x466243B1;
constexpr uint32_t kWithPieces = 2;

// The size of a fat binary from its header; 0 if it is empty.
size_t sizeOf(const void* image) {
    struct Header {
        uint32_t magic;
        uint16_t version, headerSize;
        uint64_t size;
    };
    const auto* header = static_cast<const Header*>(image);
    return header->size ? header->headerSize + header->size : 0;
}

// Whether a fat binary has an entry of PTX. Entries begin with kind, version, header size and
// payload size.
bool holdsPtx(const void* image) {
    struct Entry {
        uint16_t kind, version;
        uint32_t headerSize;
        uint64_t payloadSize;
    };
    constexpr uint16_t kPtx = 1;
    constexpr size_t kHeader = 16;
    for (size_t at = kHeader, size = sizeOf(image); at + sizeof(Entry) <= size;) {
        const auto* entry = reinterpret_cast<const Entry*>(static_cast<const char*>(image) + at);
        if (entry->kind == kPtx)
            return true;
        if (entry->headerSize == 0 || entry->payloadSize > size)
            return false;
        at += entry->headerSize + entry->payloadSize;
    }
    return false;
}

bool anyHoldsPtx(void* const* pieces) {
    for (; *pieces; ++pieces)
        if (holdsPtx(*pieces))
            return true;
    return false;
}

CUresult linkPieces(CUmodule* module, void* const* pieces) {
    const Driver& d = driver();
    CUlinkState state = nullptr;
    if (!d.cuLinkCreate)
        return CUDA_ERROR_NOT_SUPPORTED;
    CUresult result = d.cuLinkCreate(0, nullptr, nullptr, &state);
    if (result)
        return result;
    for (; *pieces && !result; ++pieces) {
        const size_t size = sizeOf(*pieces);
        if (size == 0)
            continue;
        result =
            d.cuLinkAddData(state, CU_JIT_INPUT_FATBINARY, *pieces, size, "", 0, nullptr, nullptr);
        // nvcc adds its own libraries, whose machine code the CPU device cannot load. A program
        // that calls them gets errors for missing symbols when the linker completes.
        if (result == CUDA_ERROR_NO_BINARY_FOR_GPU)
            result = CUDA_SUCCESS;
    }
    void* image = nullptr;
    size_t size = 0;
    if (!result)
        result = d.cuLinkComplete(state, &image, &size);
    if (!result)
        result = d.cuModuleLoadData(module, image);
    d.cuLinkDestroy(state);
    return result;
}

CUresult loadRegistered(CUmodule* module, const void* registered) {
    const auto* wrapper = static_cast<const Wrapper*>(registered);
    if (wrapper->magic != kWrapperMagic)
        return driver().cuModuleLoadData(module, registered);
    const bool hasPieces = wrapper->version == kWithPieces && wrapper->pieces;
    // nvcc's linker makes machine code, which the CPU device cannot load.
    if (hasPieces && driver().isCpuDevice && anyHoldsPtx(wrapper->pieces))
        return linkPieces(module, wrapper->pieces);
    if (!hasPieces || sizeOf(wrapper->image)) {
        const CUresult result = driver().cuModuleLoadData(module, wrapper->image);
        if (!hasPieces || result != CUDA_ERROR_NO_BINARY_FOR_GPU)
            return result;
    }
    return linkPieces(module, wrapper->pieces);
}

// Stores the address of a managed variable in its host shadow.
cudaError_t fillShadow(void** host, const Variable& variable) {
    CUdeviceptr address = 0;
    size_t size = 0;
    const CUresult result = driver().cuModuleGetGlobal(
        &address, &size, variable.owners.first().module, variable.name.c_str());
    if (!result)
        *host = reinterpret_cast<void*>(address);
    return fromDriver(result);
}

cudaError_t load(FatBinary& binary) {
    if (binary.module || binary.error != cudaSuccess)
        return binary.error;
    binary.error = fromDriver(loadRegistered(&binary.module, binary.wrapper));
    for (void** host : binary.managed) {
        const Variable& variable = registry().variables.at(host);
        if (binary.error == cudaSuccess && &variable.owners.first() == &binary)
            binary.error = fillShadow(host, variable);
    }
    return binary.error;
}

} // namespace

void forgetModules() {
    std::lock_guard lock(registry().mutex);
    for (auto& [handle, binary] : registry().binaries) {
        binary->module = nullptr;
        binary->error = cudaSuccess;
    }
    for (auto& [stub, kernel] : registry().kernels)
        kernel->function = nullptr;
}

cudaError_t findFunction(const void* symbol, CUfunction* function) {
    std::lock_guard lock(registry().mutex);
    Kernel* kernel = nullptr;
    if (auto found = registry().kernels.find(symbol); found != registry().kernels.end())
        kernel = found->second.get();
    else if (auto handle = registry().handles.find(static_cast<const Kernel*>(symbol));
             handle != registry().handles.end())
        kernel = registry().kernels[handle->second].get();
    if (!kernel) {
        CUkernel ofLibrary = nullptr;
        if (!isLibraryKernel(symbol, &ofLibrary))
            return cudaErrorInvalidDeviceFunction;
        return fromDriver(driver().cuKernelGetFunction(function, ofLibrary));
    }
    if (!kernel->function) {
        FatBinary& binary = kernel->owners.first();
        if (cudaError_t error = load(binary))
            return error;
        const CUresult result =
            driver().cuModuleGetFunction(&kernel->function, binary.module, kernel->name.c_str());
        if (result)
            return result == CUDA_ERROR_NOT_FOUND ? cudaErrorInvalidDeviceFunction
                                                  : fromDriver(result);
    }
    *function = kernel->function;
    return cudaSuccess;
}

void keepLibraryKernel(cudaKernel_t kernel, cudaLibrary_t library) {
    std::lock_guard lock(registry().mutex);
    registry().libraryKernels[kernel] = library;
}
void forgetLibrary(cudaLibrary_t library) {
    std::lock_guard lock(registry().mutex);
    std::erase_if(registry().libraryKernels, [&](auto& k) { return k.second == library; });
}
bool isLibraryKernel(const void* symbol, CUkernel* kernel) {
    std::lock_guard lock(registry().mutex);
    if (!registry().libraryKernels.contains(symbol))
        return false;
    *kernel = static_cast<CUkernel>(const_cast<void*>(symbol));
    return true;
}

const void* symbolOf(CUfunction function) {
    std::lock_guard lock(registry().mutex);
    for (const auto& [symbol, kernel] : registry().kernels)
        if (kernel->function == function)
            return symbol;
    return nullptr;
}

cudaError_t findVariable(const void* symbol, CUdeviceptr* address, size_t* size) {
    std::lock_guard lock(registry().mutex);
    auto found = registry().variables.find(symbol);
    if (found == registry().variables.end())
        return cudaErrorInvalidSymbol;
    const Variable& variable = found->second;
    FatBinary& binary = variable.owners.first();
    if (cudaError_t error = load(binary))
        return error;
    const CUresult result =
        driver().cuModuleGetGlobal(address, size, binary.module, variable.name.c_str());
    return result == CUDA_ERROR_NOT_FOUND ? cudaErrorInvalidSymbol : fromDriver(result);
}

} // namespace sunstone::cudart

using namespace sunstone::cudart;

SUNSTONE_CUDART void** __cudaRegisterFatBinary(void* wrapper) {
    std::lock_guard lock(registry().mutex);
    auto binary = std::make_unique<FatBinary>();
    binary->wrapper = wrapper;
    void** handle = reinterpret_cast<void**>(binary.get());
    registry().binaries[handle] = std::move(binary);
    return handle;
}
SUNSTONE_CUDART void __cudaRegisterFatBinaryEnd(void**) {}

SUNSTONE_CUDART void __cudaUnregisterFatBinary(void** handle) {
    if (isForkedChild())
        return;
    std::lock_guard lock(registry().mutex);
    FatBinary* binary = binaryOf(handle);
    if (!binary)
        return;
    // The context and its module may already be destroyed, so errors are ignored.
    if (binary->module && driver().status == cudaSuccess && ensureContext() == cudaSuccess)
        driver().cuModuleUnload(binary->module);
    for (auto& [host, variable] : registry().variables)
        variable.owners.remove(binary);
    std::erase_if(registry().variables, [](auto& v) { return v.second.owners.empty(); });
    std::erase_if(registry().kernels, [&](auto& k) {
        Kernel& kernel = *k.second;
        if (kernel.owners.remove(binary))
            kernel.function = nullptr;
        return kernel.owners.empty() && registry().handles.erase(&kernel);
    });
    const std::vector<void**> managed = std::move(binary->managed);
    registry().binaries.erase(handle);
    for (void** host : managed) // another file may have the same shadow
        if (const auto found = registry().variables.find(host);
            found != registry().variables.end() && found->second.owners.first().module)
            fillShadow(host, found->second);
}

SUNSTONE_CUDART void __cudaRegisterFunction(void** handle, const char* hostFunction, char*,
                                            const char* deviceName, int, uint3*, uint3*, dim3*,
                                            dim3*, int*) {
    std::lock_guard lock(registry().mutex);
    FatBinary* binary = binaryOf(handle);
    if (!binary || !hostFunction || !deviceName)
        return;
    std::unique_ptr<Kernel>& kernel = registry().kernels[hostFunction];
    if (!kernel) {
        kernel = std::make_unique<Kernel>();
        kernel->name = deviceName;
        registry().handles[kernel.get()] = hostFunction;
    }
    kernel->owners.add(binary);
}

SUNSTONE_CUDART void __cudaRegisterVar(void** handle, char* hostVariable, char*,
                                       const char* deviceName, int, size_t size, int, int) {
    std::lock_guard lock(registry().mutex);
    if (FatBinary* binary = binaryOf(handle); binary && hostVariable && deviceName)
        addVariable(binary, hostVariable, deviceName, size);
}

SUNSTONE_CUDART void __cudaRegisterManagedVar(void** handle, void** hostVariable, char*,
                                              const char* deviceName, int, size_t size, int, int) {
    std::lock_guard lock(registry().mutex);
    FatBinary* binary = binaryOf(handle);
    if (!binary || !hostVariable || !deviceName)
        return;
    binary->managed.push_back(hostVariable);
    addVariable(binary, hostVariable, deviceName, size);
}

// Host code calls it before its first access to a managed variable.
SUNSTONE_CUDART char __cudaInitModule(void** handle) {
    if (remember(ensureContext()) != cudaSuccess)
        return 0;
    std::lock_guard lock(registry().mutex);
    FatBinary* binary = binaryOf(handle);
    return binary && remember(load(*binary)) == cudaSuccess;
}

SUNSTONE_CUDART cudaError_t __cudaGetKernel(cudaKernel_t* kernel, const void* hostFunction) {
    if (isForkedChild())
        return remember(cudaErrorInitializationError);
    std::lock_guard lock(registry().mutex);
    if (!kernel)
        return remember(cudaErrorInvalidValue);
    auto found = registry().kernels.find(hostFunction);
    if (found == registry().kernels.end())
        return remember(cudaErrorInvalidDeviceFunction);
    *kernel = reinterpret_cast<cudaKernel_t>(found->second.get());
    return cudaSuccess;
}
SUNSTONE_CUDART cudaError_t cudaGetKernel(cudaKernel_t* kernel, const void* symbol) {
    return __cudaGetKernel(kernel, symbol);
}

SUNSTONE_CUDART cudaError_t cudaGetFuncBySymbol(cudaFunction_t* function, const void* symbol) {
    return call([&](const Driver&) {
        return function ? findFunction(symbol, function) : cudaErrorInvalidValue;
    });
}
cudaError_t sunstone::cudart::findInVariable(const void* symbol, size_t bytes, size_t offset,
                                             void** address) {
    CUdeviceptr base = 0;
    size_t size = 0;
    cudaError_t error = ensureContext();
    if (!error)
        error = findVariable(symbol, &base, &size);
    if (!error && (offset > size || bytes > size - offset))
        error = cudaErrorInvalidValue;
    *address = error ? nullptr : reinterpret_cast<void*>(base + offset);
    return remember(error);
}
SUNSTONE_CUDART cudaError_t cudaGetSymbolAddress(void** address, const void* symbol) {
    return call([&](const Driver&) {
        CUdeviceptr where = 0;
        size_t size = 0;
        if (!address)
            return cudaErrorInvalidValue;
        const cudaError_t error = findVariable(symbol, &where, &size);
        if (!error)
            *address = reinterpret_cast<void*>(where);
        return error;
    });
}
SUNSTONE_CUDART cudaError_t cudaGetSymbolSize(size_t* bytes, const void* symbol) {
    return call([&](const Driver&) {
        CUdeviceptr where = 0;
        size_t size = 0;
        if (!bytes)
            return cudaErrorInvalidValue;
        const cudaError_t error = findVariable(symbol, &where, &size);
        if (!error)
            *bytes = size;
        return error;
    });
}
