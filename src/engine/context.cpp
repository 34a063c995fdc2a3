// SPDX-License-Identifier: Apache-2.0
#include "engine/context.h"

#include "base/error.h"
#include "base/readable.h"

namespace sunstone::engine {

void enqueueLogged(const std::shared_ptr<Context>& context, void* stream, const char* tag,
                   std::function<void()> work) {
    requireSharedMemory(*context, tag);
    context->device->enqueue(stream, [context, tag, work = std::move(work)] {
        beginReadableEpoch();
        try {
            work();
        } catch (const Error& error) {
            if (context->log)
                context->log(LogLevel::kError, tag, error.what());
            throw;
        }
    });
}

} // namespace sunstone::engine
