// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/code/code.h"

#include "base/error.h"
#include "base/log.h"
#include "devlib/flags.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <iterator>
#include <thread>

namespace sunstone::engine {

using namespace device::cuda;

LoadedGpuCode::LoadedGpuCode(CUcontext context, const compiler::GpuCode& code,
                             unsigned maxRegisters, std::string& log)
    : context_(context) {
    CUresult result = CUDA_ERROR_INVALID_IMAGE;
    if (!code.machineCode.empty())
        result = load(code.machineCode);
    if (result == CUDA_SUCCESS)
        return;
    if (!code.machineCode.empty())
        sunstone::log(LogLevel::kDebug, "engine",
                      message("the driver refuses machine code of its compiler (code ", int(result),
                              ") and gets the text"));
    compileText(code.ptx, maxRegisters, log);
    isOfText = true;
    const CUresult found = driver().moduleGetFunction(&kernel, module_, compiler::kGpuKernel);
    if (found != CUDA_SUCCESS)
        driver().moduleUnload(module_);
    check(found, DriverNames::moduleGetFunction);
}

// Machine code that refers to functions of the driver (queries of some properties of textures)
// loads as a module without its kernel.
CUresult LoadedGpuCode::load(const std::string& machineCode) {
    const auto checked = [](CUresult result, const char* name) {
        if (result == CUDA_ERROR_OUT_OF_MEMORY || result == CUDA_ERROR_ILLEGAL_ADDRESS)
            check(result, name); // not the code's fault
        return result;
    };
    const CUresult result =
        checked(driver().moduleLoadDataEx(&module_, machineCode.data(), 0, nullptr, nullptr),
                DriverNames::moduleLoadDataEx);
    if (result != CUDA_SUCCESS)
        return result;
    const CUresult found = driver().moduleGetFunction(&kernel, module_, compiler::kGpuKernel);
    if (found != CUDA_SUCCESS)
        driver().moduleUnload(module_);
    return checked(found, DriverNames::moduleGetFunction);
}

void LoadedGpuCode::compileText(const std::string& ptx, unsigned maxRegisters, std::string& log) {
    if (ptx.empty())
        fail(Code::kLinkError, "the driver refuses machine code that was kept");
    constexpr size_t kLogBytes = 256 << 10;
    std::string errors(8192, '\0');
    const auto told = std::make_unique_for_overwrite<char[]>(kLogBytes);
    CUjit_option options[] = {CU_JIT_ERROR_LOG_BUFFER, CU_JIT_ERROR_LOG_BUFFER_SIZE_BYTES,
                              CU_JIT_INFO_LOG_BUFFER,  CU_JIT_INFO_LOG_BUFFER_SIZE_BYTES,
                              CU_JIT_LOG_VERBOSE,      CU_JIT_MAX_REGISTERS};
    void* values[] = {errors.data(),
                      reinterpret_cast<void*>(errors.size()),
                      told.get(),
                      reinterpret_cast<void*>(kLogBytes),
                      reinterpret_cast<void*>(uintptr_t(1)),
                      reinterpret_cast<void*>(uintptr_t(maxRegisters))};
    told[0] = '\0';
    // Compiles the text as a whole, or finds the outcome in the driver's own cache and logs
    // nothing.
    const CUresult result = driver().moduleLoadDataEx(
        &module_, ptx.c_str(), unsigned(std::size(options)), options, values);
    if (result == CUDA_ERROR_OUT_OF_MEMORY || result == CUDA_ERROR_ILLEGAL_ADDRESS)
        check(result, DriverNames::moduleLoadDataEx); // not the text's fault
    if (result != CUDA_SUCCESS)
        fail(Code::kLinkError, "the driver cannot compile the pipeline: ", errors.c_str());
    const auto length = size_t(reinterpret_cast<uintptr_t>(values[3]));
    if (length + 1 < kLogBytes) // else some of it may be missing
        log.assign(told.get(), strnlen(told.get(), length));
}

LoadedGpuCode::~LoadedGpuCode() {
    try {
        ContextScope scope(context_);
        driver().moduleUnload(module_);
    } catch (const Error&) { // the application has destroyed its context, and the module with it
    }
}

namespace {

devlib::GraphKind graphKindOf(unsigned flags, unsigned depth) {
    if (flags == devlib::kAllowSingleGas)
        return devlib::kGraphGas;
    if (flags & devlib::kAllowSingleLevelInstancing)
        return devlib::kGraphSingleLevel;
    return depth <= GpuPipelineCode::kShallowDepth ? devlib::kGraphShallow : devlib::kGraphAny;
}

} // namespace

std::shared_ptr<GpuCodeObject>& GpuPipelineCode::find(devlib::GraphKind kind) {
    std::shared_ptr<GpuCodeObject>& any = codes_[devlib::kGraphAny];
    if (!codes_[kind] && !any)
        codes_[kind] = make(kind, nullptr);
    if (!codes_[kind] && !any)
        any = make(devlib::kGraphAny, nullptr);
    return codes_[kind] ? codes_[kind] : any;
}

std::shared_ptr<GpuCodeObject> GpuPipelineCode::make(devlib::GraphKind kind,
                                                     const GpuLaterCode* later) {
    std::shared_ptr<GpuCodeObject> code = make_({kind, motion_}, later);
    if (!code || !code->narrow)
        return code;
    const bool isReady = code->narrow->isReady; // from the disk cache
    narrow_.begin(code->narrowKind, std::move(code->narrow));
    if (isReady) // no launch can run yet that the load would wait for
        findNarrow(code->narrowKind, 0, [] { return true; });
    return code;
}

std::shared_ptr<GpuCodeObject> GpuPipelineCode::get(unsigned depth) {
    std::lock_guard lock(mutex_);
    return find(graphKindOf(flags_, depth));
}

namespace {

// Whether the stream has no work left. Copies of parameters and events, which applications queue
// just before a launch, end within the limit.
bool becomesIdle(CUstream stream, std::chrono::microseconds limit) {
    const auto start = std::chrono::steady_clock::now();
    do
        if (isIdle(driver(), stream))
            return true;
    while (!isCapturing(driver(), stream) && std::chrono::steady_clock::now() - start < limit);
    return false;
}

} // namespace

// Null if there is none yet.
std::shared_ptr<GpuCodeObject> GpuPipelineCode::findNarrow(GpuCodeKind kind, uint64_t indices,
                                                           const std::function<bool()>& isIdle) {
    if (!narrow_.areMade())
        return nullptr;
    const GpuNarrowCodes::Load load = [&](const GpuLaterCode& later) {
        return make_(kind, &later);
    };
    return narrow_.get(kind, indices, isIdle, load);
}

// Replaces code by that which has become ready.
void GpuPipelineCode::replace(std::shared_ptr<GpuCodeObject>& code) {
    const auto later = std::move(code->later);
    if (later->code.machineCode.empty())
        return; // it could not be compiled
    try {
        std::shared_ptr<GpuCodeObject> faster =
            make(devlib::GraphKind(&code - codes_), later.get());
        replaced_.push_back(std::move(code));
        code = std::move(faster);
    } catch (const Error& error) {
        sunstone::log(LogLevel::kWarning, "engine",
                      message("launches keep slower code: ", error.what()));
    }
}

std::shared_ptr<GpuCodeObject> GpuPipelineCode::getForLaunch(unsigned depth, const GpuGraphs& there,
                                                             CUstream stream, uint64_t indices) {
    std::lock_guard lock(mutex_);
    const GpuCodeKind all = {graphKindOf(flags_, depth), motion_};
    std::shared_ptr<GpuCodeObject>& code = find(all.graph);
    // A captured launch may run after other traversables have been built.
    const GpuCodeKind kind = isCapturing(driver(), stream) ? all : narrowed(all, there);
    const bool waits = code->waits.next(indices) && code->later;
    const auto isReady = [&] { return code->later && code->later->isReady; };
    const auto idle = [&] { return becomesIdle(stream, code->waits.patience()); };
    if (kind != all)
        if (auto narrow = findNarrow(kind, indices, idle)) {
            if (isReady() && idle())
                replace(code); // for captured launches
            return narrow;
        }
    if (!code->later || (!isReady() && !WaitsForWhole::isLarge(indices)) || !idle())
        return code;
    const GpuLaterCode* const narrow = kind != all ? narrow_.pending(kind) : nullptr;
    if (waits)
        waitFor(narrow ? *narrow : *code->later);
    if (waits && narrow)
        if (auto found = findNarrow(kind, indices, idle))
            return found;
    if (isReady())
        replace(code);
    return code;
}

GpuCodeObject::~GpuCodeObject() {
    try {
        ContextScope scope(context_);
        driver().ctxSynchronize(); // launches may still run it
    } catch (const Error&) {       // the application has destroyed its context
    }
}

LoadedGpuCodes::Entry LoadedGpuCodes::find(const std::string& key) {
    std::lock_guard lock(mutex_);
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& entry) { return entry.key == key; });
    if (found == entries_.end())
        return {};
    std::rotate(found, found + 1, entries_.end());
    return entries_.back();
}

void LoadedGpuCodes::add(Entry entry) {
    Entry gone; // destroyed without the mutex
    std::lock_guard lock(mutex_);
    auto old = std::find_if(entries_.begin(), entries_.end(),
                            [&](const Entry& each) { return each.key == entry.key; });
    if (old == entries_.end() && entries_.size() == kMost)
        old = entries_.begin();
    if (old != entries_.end()) {
        gone = std::move(*old);
        entries_.erase(old);
    }
    entries_.push_back(std::move(entry));
}

} // namespace sunstone::engine
