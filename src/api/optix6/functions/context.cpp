// SPDX-License-Identifier: Apache-2.0
// Entry points of contexts (sections 5.2 and 5.3).
#include "api/optix6/call.h"
#include "api/optix6/gl/share.h"
#include "api/optix6/scene.h"
#include "base/log.h"
#include "base/threads/cpu_limits.h"

#include <cstring>

using namespace sunstone;
using namespace sunstone::optix6;

SUNSTONE_API RTresult rtContextCreate(RTcontext* context) {
    return guarded(nullptr, __func__, [&] {
        requireNonNull(context, "context");
        *context = nullptr;
        watchForks();
        auto object = std::make_shared<Context>();
        object->scene = std::make_unique<Scene>(*object); // may fail, so the handle follows
        *context = static_cast<RTcontext>(objects().add(std::move(object)));
    });
}

SUNSTONE_API RTresult rtContextDestroy(RTcontext handle) {
    bool failed = false;
    const RTresult result = callContext(__func__, handle, [&](Context& context) {
        failed = context.launchFailed;
        const auto self = context.self();
        objects().removeIf([&](const Object& object) { return object.context() == self; });
        context.scene = nullptr;
    });
    return result == RT_SUCCESS && failed ? RT_ERROR_LAUNCH_FAILED : result;
}

SUNSTONE_API RTresult rtContextValidate(RTcontext handle) {
    return callContext(
        __func__, handle,
        [](Context& context) {
            gl::Share share(context);
            context.scene->update();
        },
        RT_ERROR_INVALID_CONTEXT);
}

SUNSTONE_API void rtContextGetErrorString(RTcontext handle, RTresult code, const char** text) {
    if (!text)
        return;
    *text = textOf(code);
    if (refusesForkedChild()) {
        if (code == RT_ERROR_UNKNOWN)
            *text = kForkedChildText;
        return;
    }
    if (code == RT_SUCCESS)
        return;
    const auto isOf = [&](const std::string& failure) { return failure.starts_with(textOf(code)); };
    if (isOf(failureWithoutContext()))
        *text = failureWithoutContext().c_str();
    const std::shared_ptr<Object> found = handle ? objects().find(handle) : nullptr;
    if (!found || found->kind != Kind::kContext)
        return;
    auto& context = static_cast<Context&>(*found);
    const auto lock = enter(context);
    if (isOf(context.lastError) && !isOf(failureWithoutContext()))
        *text = context.keep(context.lastError);
}

SUNSTONE_API RTresult rtContextSetStackSize(RTcontext handle, RTsize bytes) {
    return callContext(__func__, handle, [&](Context& context) { context.stackSize = bytes; });
}
SUNSTONE_API RTresult rtContextGetStackSize(RTcontext handle, RTsize* bytes) {
    return callContext(__func__, handle, [&](Context& c) { store(bytes, "bytes", c.stackSize); });
}
SUNSTONE_API RTresult rtContextSetMaxTraceDepth(RTcontext handle, unsigned depth) {
    return callContext(__func__, handle, [&](Context& context) {
        if (depth > kMostTraceDepth)
            refuse(RT_ERROR_INVALID_VALUE, "maxDepth = ", depth, " is above ", kMostTraceDepth);
        context.maxTraceDepth = depth;
        context.isTraceDepthSet = true;
    });
}
SUNSTONE_API RTresult rtContextGetMaxTraceDepth(RTcontext handle, unsigned* depth) {
    return callContext(__func__, handle,
                       [&](Context& c) { store(depth, "maxDepth", c.maxTraceDepth); });
}
SUNSTONE_API RTresult rtContextSetMaxCallableProgramDepth(RTcontext handle, unsigned depth) {
    return callContext(__func__, handle, [&](Context& c) {
        c.maxCallableDepth = depth;
        c.isCallableDepthSet = true;
    });
}
SUNSTONE_API RTresult rtContextGetMaxCallableProgramDepth(RTcontext handle, unsigned* depth) {
    return callContext(__func__, handle,
                       [&](Context& c) { store(depth, "maxDepth", c.maxCallableDepth); });
}

// Without effect, as in the manual.
SUNSTONE_API RTresult rtContextSetTimeoutCallback(RTcontext handle, RTtimeoutcallback, double) {
    return callContext(__func__, handle, [](Context&) {});
}

SUNSTONE_API RTresult rtContextSetUsageReportCallback(RTcontext handle,
                                                      RTusagereportcallback callback, int verbosity,
                                                      void* data) {
    return callContext(__func__, handle, [&](Context& context) {
        if (verbosity < 0 || verbosity > 3)
            refuse(RT_ERROR_INVALID_VALUE, "verbosity = ", verbosity, " is outside 0..3");
        if (verbosity > 0)
            requireNonNull(reinterpret_cast<void*>(callback), "callback");
        context.reportCallback = verbosity > 0 ? callback : nullptr;
        context.reportVerbosity = verbosity;
        context.reportData = data;
    });
}

// ---- entry points, ray types ------------------------------------------------------------------

namespace {

EntryPoint& entryOf(Context& context, unsigned index) {
    if (index >= context.entryPoints.size())
        refuse(RT_ERROR_INVALID_VALUE, "entryPointIndex = ", index, " of ",
               context.entryPoints.size(), " entry points");
    return context.entryPoints[index];
}

void setProgram(Context& context, Ref<Program>& slot, RTprogram handle,
                compiler::ProgramKind kind) {
    const auto program = requireOf<Program>(context, handle, "program", RT_ERROR_TYPE_MISMATCH);
    checkKind(*program, kind, "program");
    slot = program;
    context.noteStructure();
}

} // namespace

SUNSTONE_API RTresult rtContextSetEntryPointCount(RTcontext handle, unsigned count) {
    return callContext(__func__, handle, [&](Context& context) {
        context.entryPoints.resize(count);
        context.noteStructure();
    });
}
SUNSTONE_API RTresult rtContextGetEntryPointCount(RTcontext handle, unsigned* count) {
    return callContext(__func__, handle, [&](Context& context) {
        store(count, "count", unsigned(context.entryPoints.size()));
    });
}
SUNSTONE_API RTresult rtContextSetRayGenerationProgram(RTcontext handle, unsigned index,
                                                       RTprogram program) {
    return callContext(__func__, handle, [&](Context& context) {
        setProgram(context, entryOf(context, index).rayGeneration, program,
                   compiler::ProgramKind::kRaygen);
    });
}
SUNSTONE_API RTresult rtContextGetRayGenerationProgram(RTcontext handle, unsigned index,
                                                       RTprogram* program) {
    return callContext(__func__, handle, [&](Context& context) {
        const EntryPoint& entry = entryOf(context, index);
        store(program, "program", static_cast<RTprogram>(handleOf(entry.rayGeneration)));
    });
}
SUNSTONE_API RTresult rtContextSetExceptionProgram(RTcontext handle, unsigned index,
                                                   RTprogram program) {
    return callContext(__func__, handle, [&](Context& context) {
        setProgram(context, entryOf(context, index).exception, program,
                   compiler::ProgramKind::kException);
    });
}
SUNSTONE_API RTresult rtContextGetExceptionProgram(RTcontext handle, unsigned index,
                                                   RTprogram* program) {
    return callContext(__func__, handle, [&](Context& context) {
        const EntryPoint& entry = entryOf(context, index);
        store(program, "program", static_cast<RTprogram>(handleOf(entry.exception)));
    });
}
SUNSTONE_API RTresult rtContextSetRayTypeCount(RTcontext handle, unsigned count) {
    return callContext(__func__, handle, [&](Context& context) {
        context.misses.resize(count);
        context.noteStructure();
    });
}
SUNSTONE_API RTresult rtContextGetRayTypeCount(RTcontext handle, unsigned* count) {
    return callContext(__func__, handle, [&](Context& context) {
        store(count, "rayTypeCount", unsigned(context.misses.size()));
    });
}

namespace {

Ref<Program>& missOf(Context& context, unsigned index) {
    if (index >= context.misses.size())
        refuse(RT_ERROR_INVALID_VALUE, "rayTypeIndex = ", index, " of ", context.misses.size(),
               " ray types");
    return context.misses[index];
}

} // namespace

SUNSTONE_API RTresult rtContextSetMissProgram(RTcontext handle, unsigned index, RTprogram program) {
    return callContext(__func__, handle, [&](Context& context) {
        setProgram(context, missOf(context, index), program, compiler::ProgramKind::kMiss);
    });
}
SUNSTONE_API RTresult rtContextGetMissProgram(RTcontext handle, unsigned index,
                                              RTprogram* program) {
    return callContext(__func__, handle, [&](Context& context) {
        const Ref<Program>& miss = missOf(context, index);
        store(program, "program", static_cast<RTprogram>(handleOf(miss)));
    });
}

// ---- exceptions, printing ---------------------------------------------------------------------

SUNSTONE_API RTresult rtContextSetExceptionEnabled(RTcontext handle, RTexception exception,
                                                   int enabled) {
    return callContext(__func__, handle, [&](Context& context) {
        const int bit = exceptionBit(exception);
        if (bit < 0 && exception != RT_EXCEPTION_ALL)
            refuse(RT_ERROR_INVALID_VALUE, "exception = ", unsigned(exception), " is unknown");
        const unsigned bits = bit < 0 ? kAllExceptions : 1u << bit;
        context.exceptions = enabled ? context.exceptions | bits : context.exceptions & ~bits;
        if (bits >> exceptionBit(RT_EXCEPTION_STACK_OVERFLOW) & 1)
            context.wantsStackChecks = enabled;
    });
}
SUNSTONE_API RTresult rtContextGetExceptionEnabled(RTcontext handle, RTexception exception,
                                                   int* enabled) {
    return callContext(__func__, handle, [&](Context& context) {
        const int bit = exceptionBit(exception);
        if (bit < 0 && exception != RT_EXCEPTION_ALL)
            refuse(RT_ERROR_INVALID_VALUE, "exception = ", unsigned(exception), " is unknown");
        const unsigned bits = bit < 0 ? kAllExceptions : 1u << bit;
        store(enabled, "enabled", int((context.exceptions & bits) == bits));
    });
}
SUNSTONE_API RTresult rtContextSetPrintEnabled(RTcontext handle, int enabled) {
    return callContext(__func__, handle, [&](Context& c) { c.printEnabled = enabled != 0; });
}
SUNSTONE_API RTresult rtContextGetPrintEnabled(RTcontext handle, int* enabled) {
    return callContext(__func__, handle,
                       [&](Context& c) { store(enabled, "enabled", int(c.printEnabled)); });
}
SUNSTONE_API RTresult rtContextSetPrintBufferSize(RTcontext handle, RTsize bytes) {
    return callContext(__func__, handle, [&](Context& context) {
        if (context.launched)
            refuse(RT_ERROR_INVALID_VALUE, "the context has been launched: the size of the print "
                                           "buffer cannot change any more");
        context.printBytes = bytes;
    });
}
SUNSTONE_API RTresult rtContextGetPrintBufferSize(RTcontext handle, RTsize* bytes) {
    return callContext(__func__, handle,
                       [&](Context& c) { store(bytes, "bufferSizeBytes", c.printBytes); });
}
SUNSTONE_API RTresult rtContextSetPrintLaunchIndex(RTcontext handle, int x, int y, int z) {
    return callContext(__func__, handle, [&](Context& context) {
        context.printIndex[0] = x;
        context.printIndex[1] = y;
        context.printIndex[2] = z;
    });
}
SUNSTONE_API RTresult rtContextGetPrintLaunchIndex(RTcontext handle, int* x, int* y, int* z) {
    return callContext(__func__, handle, [&](Context& context) {
        int* const places[] = {x, y, z};
        for (int i = 0; i < 3; ++i)
            if (places[i])
                *places[i] = context.printIndex[i];
    });
}

// ---- devices ----------------------------------------------------------------------------------

SUNSTONE_API RTresult rtContextSetDevices(RTcontext handle, unsigned count, const int* devices) {
    return callContext(__func__, handle, [&](Context& context) {
        requireNonNull(devices, "devices");
        const unsigned all = deviceCount();
        if (count == 0 || count > all)
            refuse(RT_ERROR_INVALID_VALUE, "count = ", count, ", but the number of devices is ",
                   all);
        for (unsigned i = 0; i < count; ++i)
            if (devices[i] < 0 || unsigned(devices[i]) >= all)
                refuse(RT_ERROR_INVALID_DEVICE, "devices[", i, "] = ", devices[i],
                       ", but the number of devices is ", all);
        if (count > 1)
            sunstone::log(LogLevel::kWarning, "optix6",
                          message("rtContextSetDevices: launches run on devices[0] = ", devices[0],
                                  " alone"));
        context.setDevice(devices[0]);
    });
}
SUNSTONE_API RTresult rtContextGetDevices(RTcontext handle, int* devices) {
    return callContext(
        __func__, handle, [&](Context& context) { store(devices, "devices", context.device); },
        RT_ERROR_INVALID_CONTEXT);
}
SUNSTONE_API RTresult rtContextGetDeviceCount(RTcontext handle, unsigned* count) {
    return callContext(
        __func__, handle, [&](Context&) { store(count, "count", 1u); }, RT_ERROR_INVALID_CONTEXT);
}

// ---- ids --------------------------------------------------------------------------------------

namespace {

template <class T, class Handle>
void fromId(const IdList<T>& list, int id, const char* parameter, Handle* result, const char* out) {
    requireNonNull(result, out);
    *result = nullptr;
    const std::shared_ptr<T> object =
        id > 0 && size_t(id) < list.size() ? list[size_t(id)].lock() : nullptr;
    if (!object)
        refuse(RT_ERROR_INVALID_VALUE, parameter, " = ", id, " is not the id of a live ",
               nameOf(T::kKind));
    *result = static_cast<Handle>(object->handle());
}

} // namespace

SUNSTONE_API RTresult rtContextGetBufferFromId(RTcontext handle, int id, RTbuffer* buffer) {
    return callContext(__func__, handle, [&](Context& context) {
        fromId(context.buffers, id, "bufferId", buffer, "buffer");
    });
}
SUNSTONE_API RTresult rtContextGetTextureSamplerFromId(RTcontext handle, int id,
                                                       RTtexturesampler* sampler) {
    return callContext(__func__, handle, [&](Context& context) {
        fromId(context.samplers, id, "samplerId", sampler, "sampler");
    });
}
SUNSTONE_API RTresult rtContextGetProgramFromId(RTcontext handle, int id, RTprogram* program) {
    return callContext(__func__, handle, [&](Context& context) {
        fromId(context.programs, id, "programId", program, "program");
    });
}

// ---- launches ---------------------------------------------------------------------------------

void sunstone::optix6::launchEntry(Context& context, unsigned entry, RTsize width, RTsize height,
                                   RTsize depth) {
    checkLaunch(context, entry, width, height, depth);
    checkUnmapped(context, true);
    context.launched = true;
    noteFailure(context, [&] {
        context.scene->launch(entry, uint32_t(width), uint32_t(height), uint32_t(depth));
    });
    context.launchFailed = false;
}

namespace {

RTresult launch(const char* function, RTcontext handle, unsigned entry, RTsize width, RTsize height,
                RTsize depth) {
    return callContext(
        function, handle,
        [&](Context& context) {
            gl::Share share(context);
            launchEntry(context, entry, width, height, depth);
            share.giveBack();
        },
        RT_ERROR_INVALID_CONTEXT);
}

} // namespace

SUNSTONE_API RTresult rtContextLaunch1D(RTcontext context, unsigned entry, RTsize width) {
    return launch(__func__, context, entry, width, 1, 1);
}
SUNSTONE_API RTresult rtContextLaunch2D(RTcontext context, unsigned entry, RTsize width,
                                        RTsize height) {
    return launch(__func__, context, entry, width, height, 1);
}
SUNSTONE_API RTresult rtContextLaunch3D(RTcontext context, unsigned entry, RTsize width,
                                        RTsize height, RTsize depth) {
    return launch(__func__, context, entry, width, height, depth);
}

// Without effect, as in the manual.
SUNSTONE_API RTresult rtContextCompile(RTcontext handle) {
    return callContext(__func__, handle, [](Context&) {});
}
