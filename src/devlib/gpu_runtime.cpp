// SPDX-License-Identifier: Apache-2.0
#include "devlib/gpu_runtime.h"

// The file as bytes between two symbols.
#define SUNSTONE_BYTES(name, file)                                                                 \
    asm(R"(
    .pushsection .rodata.sunstone_gpu_runtime, "a", @progbits
    .balign 16
    .hidden )" #name R"(Begin
    .globl )" #name R"(Begin
)" #name R"(Begin:
    .incbin ")" file R"("
    .hidden )" #name R"(End
    .globl )" #name R"(End
)" #name R"(End:
    .byte 0
    .popsection
)");                                                                                               \
    extern "C" const char name##Begin[], name##End[]

SUNSTONE_BYTES(sunstoneGpuRuntime, SUNSTONE_GPU_RUNTIME);
SUNSTONE_BYTES(sunstoneGpuClassic, SUNSTONE_GPU_RUNTIME_CLASSIC);

namespace sunstone::devlib {

std::string_view gpuRuntime() {
    return {sunstoneGpuRuntimeBegin, size_t(sunstoneGpuRuntimeEnd - sunstoneGpuRuntimeBegin)};
}

std::string_view gpuClassicRuntime() {
    return {sunstoneGpuClassicBegin, size_t(sunstoneGpuClassicEnd - sunstoneGpuClassicBegin)};
}

} // namespace sunstone::devlib
