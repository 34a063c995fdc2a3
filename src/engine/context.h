// SPDX-License-Identifier: Apache-2.0
// The data that all objects of one API context share: the device, the log callback, and the counter
// that numbers program groups. Read next: module.h, pipeline.h, launch.h.
#pragma once

#include "base/handles.h"
#include "base/log.h"
#include "engine/backend.h"
#include "engine/compile_cache.h"
#include "engine/wording.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

namespace sunstone::engine {

struct Context {
    device::Device* device = nullptr; // the back end's
    // Harmless violations of rules are errors; otherwise the log has a warning.
    bool validation = false;
    std::shared_ptr<Backend> backend;
    // Receives each line for this context; may be called from any thread.
    std::function<void(LogLevel, std::string_view tag, std::string_view text)> log;
    // Code compiled before, by any process; null if the owner disables it.
    std::shared_ptr<CompileCache> cache;
    // SBT headers carry the numbers of program groups. The numbers of a context start at one of
    // 4,096 places, the next context's at another one, so that a pipeline notices records of groups
    // of another context.
    std::atomic<uint32_t> nextGroup{uint32_t(newSerial() % 4096) << 20 | 1};
    const Wording* wording = &plainWording(); // of messages
};

// Reports a harmless violation of a rule: an error in validation mode, otherwise the warning
// "PLACE: RULE; CONSEQUENCE" in the log.
void tolerate(const Context& context, const char* place, const std::string& rule,
              const char* consequence);

// For the CPU. Queues work on a stream. If the work fails, the context logs the failure under this
// tag, and the stream keeps it.
void enqueueLogged(const std::shared_ptr<Context>& context, void* stream, const char* tag,
                   std::function<void()> work);

} // namespace sunstone::engine
