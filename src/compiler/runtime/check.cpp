// SPDX-License-Identifier: Apache-2.0
// The function that code compiled for the memory checker calls before an access; calls the
// launcher.
#include "compiler/runtime/runtime.h"

#include "devlib/abi.h"

namespace sunstone::compiler {

namespace {

using devlib::AccessPlace;
using devlib::CheckedAccess;

void checkKernel(devlib::KernelThread* thread, uint64_t address, const AccessPlace* place,
                 uint64_t object, uint64_t objectBytes) {
    if (!thread->block)
        return;
    const auto* functions = *static_cast<devlib::BlockFunctions* const*>(thread->block);
    const CheckedAccess access{address, place, object, objectBytes};
    if (functions->checkMemory)
        functions->checkMemory(thread, &access);
}

void checkProgram(devlib::RayState* state, uint64_t address, const AccessPlace* place,
                  uint64_t object, uint64_t objectBytes) {
    const CheckedAccess access{address, place, object, objectBytes};
    if (state->launch->checkMemory)
        state->launch->checkMemory(state, &access);
}

} // namespace

void addCheckSymbols(std::vector<RuntimeSymbol>& symbols) {
    symbols.push_back({"sunstone_check_kernel", reinterpret_cast<const void*>(checkKernel)});
    symbols.push_back({"sunstone_check_program", reinterpret_cast<const void*>(checkProgram)});
}

} // namespace sunstone::compiler
