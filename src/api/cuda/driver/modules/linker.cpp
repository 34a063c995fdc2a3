// SPDX-License-Identifier: Apache-2.0
// cuLink*: links pieces of PTX into one image; a piece may define a symbol that another declares
// extern. The image holds the texts of the pieces. Symbols are resolved at completion, which
// reports their errors, and again at loading. Also parses the options that linking and loading
// share.
#include "api/cuda/driver/modules/fat_binary.h"
#include "api/cuda/driver/modules/module.h"
#include "base/handles.h"
#include "compiler/kernels/kernel_module.h"

#include <cstring>

using namespace sunstone;
using namespace sunstone::api::cuda;

namespace {

struct LinkState {
    std::mutex mutex;
    JitOptions options;
    std::vector<std::string> texts;
    std::vector<std::shared_ptr<const ptx::Module>> trees;
    std::string warnings;
    std::string image; // result of cuLinkComplete
};

HandleTable<LinkState>& linkTable() {
    static auto* table = new HandleTable<LinkState>;
    return *table;
}

std::shared_ptr<LinkState> linkOf(CUlinkState state) {
    auto found = linkTable().find(state);
    if (!found)
        refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(state), " is not a live linker");
    return found;
}

void requireKnownInput(CUjitInputType type) {
    require(unsigned(type) < CU_JIT_NUM_INPUT_TYPES, "unknown input type");
    if (type == CU_JIT_INPUT_OBJECT || type == CU_JIT_INPUT_LIBRARY || type == CU_JIT_INPUT_NVVM)
        refuse(CUDA_ERROR_NOT_SUPPORTED, "input type ", int(type),
               "; PTX, fat binaries and linked images can be linked");
}

void addPieces(LinkState& state, std::vector<std::string> texts) {
    std::lock_guard lock(state.mutex);
    require(state.image.empty(), "the linker has completed");
    try {
        for (std::string& text : texts) {
            state.trees.push_back(parsePtx(text, &state.warnings));
            state.texts.push_back(std::move(text));
        }
    } catch (const Failure& failure) {
        state.options.report({}, failure.what(), 0);
        throw;
    }
}

void addData(CUlinkState state, CUjitInputType type, void* data, size_t size) {
    std::shared_ptr<LinkState> link = linkOf(state);
    requireKnownInput(type);
    addPieces(*link, ptxOfBytes(data, size));
}

} // namespace

namespace sunstone::api::cuda {

JitOptions::JitOptions(unsigned count, const CUjit_option* options, void** values) {
    require(count == 0 || (options && values), "options or values is null");
    for (unsigned i = 0; i < count; ++i) {
        switch (options[i]) {
        case CU_JIT_INFO_LOG_BUFFER:
            info_ = static_cast<char*>(values[i]);
            break;
        case CU_JIT_INFO_LOG_BUFFER_SIZE_BYTES:
            infoSize_ = &values[i];
            break;
        case CU_JIT_ERROR_LOG_BUFFER:
            error_ = static_cast<char*>(values[i]);
            break;
        case CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES:
            errorSize_ = &values[i];
            break;
        case CU_JIT_GENERATE_DEBUG_INFO:
            debug_ = values[i] != nullptr;
            break;
        case CU_JIT_WALL_TIME:
            wallTime_ = &values[i];
            break;
        default:
            // Options for a GPU's code generator have no effect.
            require(unsigned(options[i]) < 64, "unknown JIT option");
        }
    }
}

void JitOptions::report(const std::string& information, const std::string& errors,
                        float milliseconds) {
    const auto write = [](char* buffer, void** size, const std::string& text) {
        if (!size)
            return;
        const size_t room = size_t(*size);
        size_t length = 0;
        if (buffer && room) {
            length = std::min(text.size(), room - 1);
            std::memcpy(buffer, text.data(), length);
            buffer[length++] = 0;
        }
        *size = reinterpret_cast<void*>(length);
    };
    write(error_, errorSize_, errors);
    write(info_, infoSize_, information);
    if (wallTime_)
        std::memcpy(wallTime_, &milliseconds, sizeof milliseconds);
}

} // namespace sunstone::api::cuda

SUNSTONE_EXPORT CUresult cuLinkCreate(unsigned int count, CUjit_option* options, void** values,
                                      CUlinkState* state) {
    return guarded("cuLinkCreate", Needs::kContext, [&] {
        require(state, "state is null");
        auto link = std::make_shared<LinkState>();
        link->options = JitOptions(count, options, values);
        *state = static_cast<CUlinkState>(linkTable().add(std::move(link)));
    });
}
SUNSTONE_EXPORT CUresult cuLinkAddData(CUlinkState state, CUjitInputType type, void* data,
                                       size_t size, const char*, unsigned int count,
                                       CUjit_option* options, void** values) {
    return guarded("cuLinkAddData", Needs::kContext, [&] {
        JitOptions(count, options, values); // must be well-formed; they have no effect here
        addData(state, type, data, size);
    });
}
SUNSTONE_EXPORT CUresult cuLinkAddFile(CUlinkState state, CUjitInputType type, const char* path,
                                       unsigned int count, CUjit_option* options, void** values) {
    return guarded("cuLinkAddFile", Needs::kContext, [&] {
        JitOptions(count, options, values);
        std::shared_ptr<LinkState> link = linkOf(state);
        requireKnownInput(type);
        addPieces(*link, ptxOfFile(path));
    });
}
SUNSTONE_EXPORT CUresult cuLinkComplete(CUlinkState state, void** image, size_t* size) {
    return guarded("cuLinkComplete", Needs::kContext, [&] {
        require(image, "image is null");
        std::shared_ptr<LinkState> link = linkOf(state);
        std::lock_guard lock(link->mutex);
        require(!link->texts.empty(), "nothing was added");
        if (link->image.empty()) {
            try {
                compiler::checkKernels(link->trees);
            } catch (const Error& error) {
                link->options.report({}, error.what(), 0);
                throw;
            }
            link->options.report(link->warnings, {}, 0);
            link->image = makeLinkedImage(link->texts);
        }
        *image = link->image.data();
        if (size)
            *size = link->image.size();
    });
}
SUNSTONE_EXPORT CUresult cuLinkDestroy(CUlinkState state) {
    return guarded("cuLinkDestroy", Needs::kContext, [&] {
        if (!linkTable().remove(state))
            refuse(CUDA_ERROR_INVALID_HANDLE, static_cast<void*>(state), " is not a live linker");
    });
}
