// SPDX-License-Identifier: Apache-2.0
#include "engine/context.h"

#include "base/error.h"
#include "base/readable.h"

namespace sunstone::engine {

void tolerate(const Context& context, const char* place, const std::string& rule,
              const char* consequence) {
    if (context.validation)
        fail(Code::kInvalidValue, rule);
    if (context.log)
        context.log(LogLevel::kWarning, "API", message(place, ": ", rule, "; ", consequence));
}

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
