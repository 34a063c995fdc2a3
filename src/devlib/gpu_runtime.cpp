// SPDX-License-Identifier: Apache-2.0
#include "devlib/gpu_runtime.h"

asm(R"(
    .pushsection .rodata.sunstone_gpu_runtime, "a", @progbits
    .balign 16
    .hidden sunstoneGpuRuntimeBegin
    .globl sunstoneGpuRuntimeBegin
sunstoneGpuRuntimeBegin:
    .incbin ")" SUNSTONE_GPU_RUNTIME R"("
    .hidden sunstoneGpuRuntimeEnd
    .globl sunstoneGpuRuntimeEnd
sunstoneGpuRuntimeEnd:
    .byte 0
    .popsection
)");

extern "C" const char sunstoneGpuRuntimeBegin[], sunstoneGpuRuntimeEnd[];

namespace sunstone::devlib {

std::string_view gpuRuntime() {
    return {sunstoneGpuRuntimeBegin, size_t(sunstoneGpuRuntimeEnd - sunstoneGpuRuntimeBegin)};
}

} // namespace sunstone::devlib
