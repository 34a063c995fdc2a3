// SPDX-License-Identifier: Apache-2.0
// See libraries.h.
#include "api/cuda/driver/modules/libraries.h"

#include "api/cuda/driver/modules/fat_binary.h"
#include "base/handles.h"

#include <algorithm>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace sunstone::api::cuda {

namespace {

class Library;

struct Kernel : Handled {
    std::weak_ptr<Library> library;
    std::string name;
    std::mutex mutex;
    std::map<CUfunction_attribute, int> attributes; // for all contexts
};

class Library : public Handled, public std::enable_shared_from_this<Library> {
public:
    explicit Library(ParsedImage image) : image_(std::move(image)) {}
    ~Library();

    void makeKernels();
    // The module in the current context.
    CUmodule moduleHere();
    std::shared_ptr<Kernel> kernel(const std::string& name) const;
    const std::map<std::string, std::shared_ptr<Kernel>>& kernels() const { return kernels_; }
    bool isManaged(const std::string& name) const;

private:
    const ParsedImage image_;
    std::map<std::string, std::shared_ptr<Kernel>> kernels_;
    std::mutex mutex_;
    std::map<const void*, CUmodule> modules_; // by context; handles for destroyed contexts are
                                              // invalid
};

HandleTable<Library>& libraryTable() {
    static auto* table = new HandleTable<Library>;
    return *table;
}
HandleTable<Kernel>& kernelTable() {
    static auto* table = new HandleTable<Kernel>;
    return *table;
}

void Library::makeKernels() {
    for (const auto& tree : image_.trees)
        for (const ptx::Function& function : tree->functions) {
            const std::string name(function.name);
            if (!function.isEntry || kernels_.contains(name))
                continue;
            auto kernel = std::make_shared<Kernel>();
            kernel->library = weak_from_this();
            kernel->name = name;
            kernels_[name] = kernel;
            kernelTable().add(std::move(kernel));
        }
}

Library::~Library() {
    for (const auto& [context, module] : modules_)
        unloadModule(module);
}

CUmodule Library::moduleHere() {
    const void* context = cpu::contexts().current();
    std::lock_guard lock(mutex_);
    CUmodule& module = modules_[context];
    if (!module || !findModule(module))
        module = makeModule(image_);
    return module;
}

std::shared_ptr<Kernel> Library::kernel(const std::string& name) const {
    const auto found = kernels_.find(name);
    if (found == kernels_.end())
        refuse(CUDA_ERROR_NOT_FOUND, "the library has no kernel ", name);
    return found->second;
}

bool Library::isManaged(const std::string& name) const {
    return std::any_of(image_.trees.begin(), image_.trees.end(), [&](const auto& tree) {
        const ptx::Variable* variable = tree->findVariable(name);
        return variable && variable->isManaged;
    });
}

std::shared_ptr<Library> libraryOf(CUlibrary handle) {
    auto found = libraryTable().find(handle);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(handle), " is not a live library");
    return found;
}
std::shared_ptr<Kernel> kernelOf(CUkernel handle) {
    auto found = kernelTable().find(handle);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(handle),
               " is not a kernel of a live library");
    return found;
}

std::shared_ptr<Function> functionHere(Kernel& kernel) {
    const std::shared_ptr<Library> library = kernel.library.lock();
    if (!library)
        refuse(CUDA_ERROR_INVALID_HANDLE, "the kernel's library was unloaded");
    const std::shared_ptr<Function> function = liveFunctionOf(
        static_cast<CUfunction>(moduleOf(library->moduleHere())->function(kernel.name)->handle()));
    std::lock_guard lock(kernel.mutex);
    for (const auto& [attribute, value] : kernel.attributes)
        setAttribute(*function, attribute, value);
    return function;
}

CUresult loadLibrary(const char* function, CUlibrary* library, CUjit_option* jitOptions,
                     void** jitValues, unsigned jitCount, CUlibraryOption* options, void** values,
                     unsigned count, const std::function<std::vector<std::string>()>& texts) {
    return guarded(function, Needs::kInit, [&] {
        require(library, "library is null");
        require((options && values) || count == 0, "options or values are null");
        for (unsigned i = 0; i < count; ++i)
            if (options[i] != CU_LIBRARY_BINARY_IS_PRESERVED)
                refuse(unsigned(options[i]) < CU_LIBRARY_NUM_OPTIONS ? CUDA_ERROR_NOT_SUPPORTED
                                                                     : CUDA_ERROR_INVALID_VALUE,
                       "option ", int(options[i]), " of libraries");
        const JitOptions jit(jitCount, jitOptions, jitValues);
        auto made = std::make_shared<Library>(parseImage(texts(), jit));
        made->makeKernels();
        *library = static_cast<CUlibrary>(libraryTable().add(std::move(made)));
    });
}

CUresult global(const char* function, CUdeviceptr* address, size_t* bytes, CUlibrary library,
                const char* name, bool managed) {
    return guarded(function, Needs::kContext, [&] {
        require((address || bytes) && name && *name,
                "nothing is asked for, or name is null or empty");
        const std::shared_ptr<Library> found = libraryOf(library);
        void* where = nullptr;
        uint64_t size = 0;
        if ((managed && !found->isManaged(name)) ||
            !moduleOf(found->moduleHere())->variable(name, &where, &size))
            refuse(CUDA_ERROR_NOT_FOUND, "the library has no ", managed ? "managed " : "",
                   "variable ", name);
        if (address)
            *address = reinterpret_cast<CUdeviceptr>(where);
        if (bytes)
            *bytes = size;
    });
}

} // namespace

std::shared_ptr<Function> functionOfKernel(const void* handle) {
    const std::shared_ptr<Kernel> kernel = kernelTable().find(handle);
    return kernel ? functionHere(*kernel) : nullptr;
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuLibraryLoadData(CUlibrary* library, const void* code,
                                           CUjit_option* jitOptions, void** jitValues,
                                           unsigned int jitCount, CUlibraryOption* options,
                                           void** values, unsigned int count) {
    return loadLibrary("cuLibraryLoadData", library, jitOptions, jitValues, jitCount, options,
                       values, count, [&] { return ptxOfImage(code); });
}
SUNSTONE_EXPORT CUresult cuLibraryLoadFromFile(CUlibrary* library, const char* file,
                                               CUjit_option* jitOptions, void** jitValues,
                                               unsigned int jitCount, CUlibraryOption* options,
                                               void** values, unsigned int count) {
    return loadLibrary("cuLibraryLoadFromFile", library, jitOptions, jitValues, jitCount, options,
                       values, count, [&] { return ptxOfFile(file); });
}
SUNSTONE_EXPORT CUresult cuLibraryUnload(CUlibrary library) {
    return guarded("cuLibraryUnload", Needs::kInit, [&] {
        const std::shared_ptr<Library> found = libraryOf(library);
        cpu::streams().synchronizeAll(); // queued work may use its code
        libraryTable().remove(library);
        for (const auto& [name, kernel] : found->kernels())
            kernelTable().remove(kernel->handle());
    });
}
SUNSTONE_EXPORT CUresult cuLibraryGetKernel(CUkernel* kernel, CUlibrary library, const char* name) {
    return guarded("cuLibraryGetKernel", Needs::kInit, [&] {
        require(kernel && name && *name, "kernel or name is null or empty");
        *kernel = static_cast<CUkernel>(libraryOf(library)->kernel(name)->handle());
    });
}
SUNSTONE_EXPORT CUresult cuLibraryGetKernelCount(unsigned int* count, CUlibrary library) {
    return guarded("cuLibraryGetKernelCount", Needs::kInit, [&] {
        require(count, "count is null");
        *count = unsigned(libraryOf(library)->kernels().size());
    });
}
SUNSTONE_EXPORT CUresult cuLibraryEnumerateKernels(CUkernel* kernels, unsigned int count,
                                                   CUlibrary library) {
    return guarded("cuLibraryEnumerateKernels", Needs::kInit, [&] {
        require(kernels, "kernels is null");
        const std::shared_ptr<Library> found = libraryOf(library);
        for (const auto& [name, kernel] : found->kernels()) {
            if (count-- == 0)
                break;
            *kernels++ = static_cast<CUkernel>(kernel->handle());
        }
    });
}
SUNSTONE_EXPORT CUresult cuLibraryGetModule(CUmodule* module, CUlibrary library) {
    return guarded("cuLibraryGetModule", Needs::kContext, [&] {
        require(module, "module is null");
        *module = libraryOf(library)->moduleHere();
    });
}
SUNSTONE_EXPORT CUresult cuLibraryGetGlobal(CUdeviceptr* address, size_t* bytes, CUlibrary library,
                                            const char* name) {
    return global("cuLibraryGetGlobal", address, bytes, library, name, false);
}
SUNSTONE_EXPORT CUresult cuLibraryGetManaged(CUdeviceptr* address, size_t* bytes, CUlibrary library,
                                             const char* name) {
    return global("cuLibraryGetManaged", address, bytes, library, name, true);
}
SUNSTONE_EXPORT CUresult cuLibraryGetUnifiedFunction(void** function, CUlibrary library,
                                                     const char* symbol) {
    return guarded("cuLibraryGetUnifiedFunction", Needs::kInit, [&] {
        require(function && symbol && *symbol, "function or symbol is null or empty");
        libraryOf(library);
        // CU_DEVICE_ATTRIBUTE_UNIFIED_FUNCTION_POINTERS is 0.
        refuse(CUDA_ERROR_NOT_FOUND, "no function of a library has one address on host and device");
    });
}

SUNSTONE_EXPORT CUresult cuKernelGetFunction(CUfunction* function, CUkernel kernel) {
    return guarded("cuKernelGetFunction", Needs::kContext, [&] {
        require(function, "function is null");
        *function = static_cast<CUfunction>(functionHere(*kernelOf(kernel))->handle());
    });
}
SUNSTONE_EXPORT CUresult cuKernelGetLibrary(CUlibrary* library, CUkernel kernel) {
    return guarded("cuKernelGetLibrary", Needs::kInit, [&] {
        require(library, "library is null");
        *library = static_cast<CUlibrary>(handleOrNull(kernelOf(kernel)->library.lock()));
    });
}
SUNSTONE_EXPORT CUresult cuKernelGetName(const char** name, CUkernel kernel) {
    return guarded("cuKernelGetName", Needs::kInit, [&] {
        require(name, "name is null");
        *name = kernelOf(kernel)->name.c_str();
    });
}
SUNSTONE_EXPORT CUresult cuKernelGetParamInfo(CUkernel kernel, size_t index, size_t* offset,
                                              size_t* size) {
    return guarded("cuKernelGetParamInfo", Needs::kObject, [&] {
        return cuFuncGetParamInfo(
            static_cast<CUfunction>(functionHere(*kernelOf(kernel))->handle()), index, offset,
            size);
    });
}
SUNSTONE_EXPORT CUresult cuKernelGetAttribute(int* value, CUfunction_attribute attribute,
                                              CUkernel kernel, CUdevice device) {
    return guarded("cuKernelGetAttribute", Needs::kObject, [&] {
        require(value, "value is null");
        requireDevice(device);
        *value = attributeOf(*functionHere(*kernelOf(kernel)), attribute);
    });
}
SUNSTONE_EXPORT CUresult cuKernelSetAttribute(CUfunction_attribute attribute, int value,
                                              CUkernel kernel, CUdevice device) {
    return guarded("cuKernelSetAttribute", Needs::kObject, [&] {
        requireDevice(device);
        const std::shared_ptr<Kernel> found = kernelOf(kernel);
        setAttribute(*functionHere(*found), attribute, value); // throws for invalid values
        std::lock_guard lock(found->mutex);
        found->attributes[attribute] = value;
    });
}
SUNSTONE_EXPORT CUresult cuKernelSetCacheConfig(CUkernel kernel, CUfunc_cache config,
                                                CUdevice device) {
    return guarded("cuKernelSetCacheConfig", Needs::kObject, [&] {
        requireDevice(device);
        kernelOf(kernel);
        require(unsigned(config) <= CU_FUNC_CACHE_PREFER_EQUAL, "unknown cache configuration");
    });
}
