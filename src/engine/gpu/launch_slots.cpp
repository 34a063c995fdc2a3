// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/launch_slots.h"

#include "base/error.h"
#include "engine/exceptions.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>

namespace sunstone::engine {
namespace {

using namespace device::cuda;

// Offset of the report in page-locked memory, after the image of the block.
constexpr size_t kHostReport = (sizeof(devlib::LaunchBlock) + 63) / 64 * 64;

std::string nameOfFatal(int32_t code) {
    switch (code) {
    case devlib::kFatalRaygenRecord:
        return "the ray generation record holds no such program group of the pipeline";
    case devlib::kFatalExceptionRecord:
        return "the exception record holds no such program group of the pipeline";
    case devlib::kFatalGraphTooDeep:
        return "the structures on a path of the traversable graph are too deep together for "
               "GPUs: more than 16 of them, with trees as deep as they can be";
    case devlib::kFatalAssertion:
        return "failed assertion";
    case devlib::kFatalVisits:
        return message("more than ", devlib::kMostNestedVisits,
                       " visit programs of selectors are nested, the limit of GPUs");
    default:
        return {};
    }
}

// A failed assertion, in the form that it has on the CPU.
std::string assertionOf(const devlib::LaunchSaying& saying) {
    const auto text = [&](unsigned i) { return saying.texts[i][0] ? saying.texts[i] : "?"; };
    return message(text(1), ":", saying.line, ": ", text(2), ": Assertion `", text(0), "` failed");
}

std::string atIndex(uint64_t place, const devlib::LaunchState& launch) {
    const uint64_t width = launch.dimensions[0], height = launch.dimensions[1];
    return message(", at launch index (", place % width, ", ", place / width % height, ", ",
                   place / width / height, ")");
}

// A text in the pipeline's module, or empty where it cannot be read.
std::string readText(uint64_t address) {
    constexpr size_t kPiece = 16, kMost = 512;
    std::string text;
    while (address != 0 && text.size() < kMost) {
        char piece[kPiece];
        const size_t bytes = kPiece - address % kPiece; // never beyond the memory of the last byte
        if (driver().memcpyDtoH(piece, address, bytes) != CUDA_SUCCESS)
            return {};
        const size_t length = strnlen(piece, bytes);
        text.append(piece, length);
        if (length < bytes)
            break;
        address += bytes;
    }
    return text;
}

// The exception details of getters, if `words` belong to this exception. The texts live as long as
// the caller's copies.
struct Details {
    devlib::ExceptionInfo info{};
    std::string name, line;

    Details(int32_t code, const uint64_t* words, bool withTexts) {
        using namespace devlib;
        const auto word = [&](unsigned i) { return uint32_t(words[i]); };
        const auto address = [&](unsigned i) { return uint64_t(word(i + 1)) << 32 | word(i); };
        if (words[kWordCode] == kNoReport || int32_t(word(kWordCode)) != code)
            return;
        if (code == kExceptionInvalidRay) {
            for (unsigned i = 0; i < 9; ++i)
                info.ray[i] = std::bit_cast<float>(word(i));
        } else {
            info.traversable = address(kWordTraversable);
            info.sbtOffset = word(kWordSbtOffset);
            info.expectedWords = word(kWordExpected);
            info.passedWords = word(kWordExpected + 1);
            info.callableIndex = word(kWordExpected + 2);
            if (withTexts && !(name = readText(address(kWordName))).empty())
                info.callableName = name.c_str();
        }
        if (withTexts && !(line = readText(address(kWordLine))).empty())
            info.line = line.c_str();
    }
};

// A word of LaunchReport as text, or empty.
std::string describe(uint64_t word, const devlib::LaunchState& launch, const Wording& wording,
                     const uint64_t* details = nullptr, bool withTexts = false) {
    if (word == devlib::kNoReport)
        return {};
    const auto code = int32_t(uint32_t(word));
    std::string name = nameOfFatal(code);
    if (name.empty()) {
        devlib::ThreadState thread{};
        thread.exceptionCode = code;
        std::optional<Details> known; // describeException reads its texts
        if (details) {
            known.emplace(code, details, withTexts);
            thread.exception = known->info;
        }
        name = describeException(thread, wording);
    }
    return name + atIndex(word >> 32, launch);
}

std::string textOf(const devlib::LaunchSaying& saying, const Wording& wording) {
    if (saying.code == devlib::kFatalAssertion)
        return assertionOf(saying);
    devlib::ThreadState thread{};
    thread.exceptionCode = saying.code;
    return describeException(thread, wording) + saying.texts[0];
}

} // namespace

GpuLaunchSlots::Lease::Lease(GpuLaunchSlots& slots, const ContextPtr& context, CUstream stream,
                             size_t parameterBytes, bool validation)
    : slots_(slots), stream_(stream), isCaptured_(device::cuda::isCapturing(driver(), stream)) {
    constexpr unsigned kFew = 4; // bounds the cost of a launch
    slots.tellOfEnded(kFew);
    slot_ = &slots.take(parameterBytes);
    slot_->context = context;
    slot_->wording = context->wording;
    slot_->validation = validation;
    if (!isCaptured_)
        return;
    *slot_->report = devlib::emptyReport(); // the graph may never run
    try {
        watchGraph();
    } catch (...) {
        std::lock_guard lock(slots_.mutex_);
        slot_->state = State::kFree;
        throw;
    }
}

// Makes the graph own an object whose destructor sets graphDestroyed. The driver may call it at any
// time, also after the slot was freed with its context.
void GpuLaunchSlots::Lease::watchGraph() {
    using Flag = std::shared_ptr<std::atomic<bool>>;
    const Driver& known = driver();
    if (!known.userObjectCreate || !known.graphRetainUserObject || !known.streamGetCaptureInfo)
        return;
    CUstreamCaptureStatus status = CU_STREAM_CAPTURE_STATUS_NONE;
    CUgraph graph = nullptr;
    SUNSTONE_CU(streamGetCaptureInfo, stream_, &status, nullptr, &graph, nullptr, nullptr);
    auto destroyed = std::make_shared<std::atomic<bool>>(false);
    auto kept = std::make_unique<Flag>(destroyed);
    CUuserObject object = nullptr;
    const auto destroy = [](void* flag) {
        const std::unique_ptr<Flag> last(static_cast<Flag*>(flag));
        (*last)->store(true, std::memory_order_release);
    };
    SUNSTONE_CU(userObjectCreate, &object, kept.get(), destroy, 1,
                CU_USER_OBJECT_NO_DESTRUCTOR_SYNC);
    (void)kept.release(); // the object's
    const CUresult retained =
        known.graphRetainUserObject(graph, object, 1, CU_GRAPH_USER_OBJECT_MOVE);
    if (retained != CUDA_SUCCESS)
        known.userObjectRelease(object, 1);
    check(retained, DriverNames::graphRetainUserObject);
    slot_->graphDestroyed = std::move(destroyed);
}

// Work already queued may still read the slot.
GpuLaunchSlots::Lease::~Lease() {
    if (isQueued_)
        return;
    if (isCaptured_) { // some of it may be in the graph
        std::lock_guard lock(slots_.mutex_);
        slot_->state = State::kCaptured;
        return;
    }
    const bool recorded = driver().eventRecord(slot_->done, stream_) == CUDA_SUCCESS;
    if (!recorded)
        driver().streamSynchronize(stream_);
    std::lock_guard lock(slots_.mutex_);
    slot_->state = recorded ? State::kAbandoned : State::kFree;
}

void GpuLaunchSlots::Lease::queued() {
    if (isCaptured_) {
        std::lock_guard lock(slots_.mutex_);
        slot_->number = ++slots_.launches_;
        slot_->state = State::kCaptured;
    } else {
        slots_.record(*slot_, stream_, State::kQueued);
    }
    isQueued_ = true;
}

std::string GpuLaunchSlots::Lease::finish() {
    slots_.record(*slot_, stream_, State::kAwaited);
    const CUresult result = driver().eventSynchronize(slot_->done);
    if (result != CUDA_SUCCESS) {
        const char* name = nullptr;
        driver().getErrorName(result, &name);
        fail(Code::kLaunchFailure, "launch ", slot_->number, " ended with ",
             name ? name : "an unknown error", ", and so did its CUDA context");
    }
    isQueued_ = true;
    Lines lines;
    std::string failure = failureOf(*slot_, slot_->validation, true);
    {
        std::lock_guard lock(slots_.mutex_);
        settle(*slot_, lines);
    }
    tell(lines);
    return failure;
}

GpuLaunchSlots::~GpuLaunchSlots() {
    try {
        ContextScope scope(context_);
        driver().ctxSynchronize();
        tellOfEnded(~0u);
        for (auto& slot : slots_) {
            driver().memFree(slot->memory);
            driver().memFreeHost(slot->host);
            driver().eventDestroy(slot->done);
        }
    } catch (const Error&) { // the application has destroyed its context, and all memory with it
    }
}

void GpuLaunchSlots::tellOfEnded(unsigned mostPending) {
    Lines lines;
    {
        std::lock_guard lock(mutex_);
        collect(mostPending, lines);
        if (mostPending == ~0u)
            tellOfGraphs(lines);
    }
    tell(lines);
}

GpuLaunchSlots::Slot& GpuLaunchSlots::take(size_t parameterBytes) {
    std::lock_guard lock(mutex_);
    for (auto& slot : slots_)
        if (slot->state == State::kFree && slot->capacity >= parameterBytes) {
            slot->state = State::kTaken;
            return *slot;
        }
    auto slot = std::make_unique<Slot>();
    makeMemory(*slot, parameterBytes);
    slot->state = State::kTaken;
    slots_.push_back(std::move(slot));
    return *slots_.back();
}

void GpuLaunchSlots::makeMemory(Slot& slot, size_t parameterBytes) {
    slot.capacity = (parameterBytes + 1023) / 1024 * 1024;
    void* host = nullptr;
    try {
        SUNSTONE_CU(memAlloc, &slot.memory, kParameters + slot.capacity + 64);
        SUNSTONE_CU(memAllocHost, &host,
                    kHostReport + sizeof(devlib::LaunchReport) + slot.capacity);
        SUNSTONE_CU(eventCreate, &slot.done, CU_EVENT_DISABLE_TIMING);
    } catch (const Error&) {
        driver().memFreeHost(host);
        driver().memFree(slot.memory);
        throw;
    }
    slot.host = static_cast<devlib::LaunchBlock*>(host);
    slot.report = new (static_cast<std::byte*>(host) + kHostReport)
        devlib::LaunchReport(devlib::emptyReport());
    slot.extra = reinterpret_cast<std::byte*>(slot.report + 1);
}

void GpuLaunchSlots::record(Slot& slot, CUstream stream, State state) {
    SUNSTONE_CU(eventRecord, slot.done, stream);
    std::lock_guard lock(mutex_);
    slot.number = ++launches_;
    slot.state = state;
}

void GpuLaunchSlots::collect(unsigned mostPending, Lines& lines) {
    for (size_t i = 0; i < slots_.size() && mostPending != 0; ++i) {
        next_ = (next_ + 1) % slots_.size();
        Slot& slot = *slots_[next_];
        if (slot.state == State::kCaptured && slot.graphDestroyed && *slot.graphDestroyed)
            settle(slot, lines);
        if (slot.state != State::kQueued && slot.state != State::kAbandoned)
            continue;
        const CUresult result = driver().eventQuery(slot.done);
        if (result == CUDA_SUCCESS)
            settle(slot, lines);
        else if (result == CUDA_ERROR_NOT_READY)
            --mostPending;
        else
            return lose(result, lines);
    }
}

// The CUDA context has failed, and the launch that caused it can no longer be identified.
void GpuLaunchSlots::lose(CUresult reason, Lines& lines) {
    uint64_t first = ~uint64_t(0), last = 0;
    std::vector<std::weak_ptr<Context>> contexts; // usually one
    for (auto& slot : slots_) {
        if (slot->state == State::kQueued) {
            first = std::min(first, slot->number);
            last = std::max(last, slot->number);
            contexts.push_back(slot->context);
        }
        if (slot->state == State::kQueued || slot->state == State::kAbandoned)
            slot->state = State::kLost;
    }
    if (contexts.empty())
        return;
    const char* name = nullptr;
    driver().getErrorName(reason, &name);
    std::sort(contexts.begin(), contexts.end(), std::owner_less<>());
    const auto same = [](const auto& a, const auto& b) { return a.lock() == b.lock(); };
    contexts.erase(std::unique(contexts.begin(), contexts.end(), same), contexts.end());
    const std::string which = first == last ? message("launch ", first, " was")
                                            : message("launches ", first, " to ", last, " were");
    for (const auto& context : contexts)
        lines.push_back({context, LogLevel::kError,
                         message("the CUDA context failed with ", name ? name : "an unknown error",
                                 " while ", which,
                                 " under way: of them or other work of it one "
                                 "accessed memory that is not there, or faulted otherwise")});
}

static devlib::LaunchNotes notesOf(const devlib::LaunchReport& report) {
    devlib::LaunchNotes notes;
    notes.deepGraph = report.deepGraph;
    notes.deepTrace = report.deepTrace;
    notes.wideSbt = report.wideSbt;
    notes.outsideFlags = report.outsideFlags;
    notes.motion = report.motion;
    notes.unknown = report.unknown;
    notes.record = report.record;
    return notes;
}

std::string GpuLaunchSlots::failureOf(const Slot& slot, bool validation, bool withTexts) {
    const devlib::LaunchReport& report = *slot.report;
    const devlib::LaunchState& launch = slot.host->launch;
    std::string text = describe(report.fatal, launch, *slot.wording);
    if (!text.empty() && report.saying.by != 0)
        text = textOf(report.saying, *slot.wording) + atIndex(report.saying.by - 1, launch);
    if (text.empty() && validation)
        text = describe(report.raised, launch, *slot.wording, report.raisedDetails, withTexts);
    return text;
}

void GpuLaunchSlots::settle(Slot& slot, Lines& lines) {
    const bool abandoned = slot.state == State::kAbandoned;
    slot.state = State::kFree;
    const auto findings = std::exchange(slot.findings, {}).lock();
    slot.graphDestroyed = nullptr;
    if (abandoned)
        return;
    if (findings) {
        if (slot.report->usual != 0)
            findings->usualHandle = slot.report->usual;
        findings->patience.learn(slot.report->paces, slot.host->work);
    }
    const std::string where = message("launch ", slot.number, ": ");
    const devlib::LaunchReport& report = *slot.report;
    const std::string failure = failureOf(slot, slot.validation, false);
    const std::string unseen =
        describe(report.unseen, slot.host->launch, *slot.wording, report.unseenDetails);
    for (const auto& [level, text] : remarksOf(notesOf(report), slot.host->launch, *slot.wording))
        lines.push_back({slot.context, level, where + text});
    if (report.saying.code == devlib::kFatalAssertion) // as the CPU and other drivers do
        std::fprintf(stderr, "%s.\n", assertionOf(report.saying).c_str());
    if (!failure.empty())
        lines.push_back({slot.context, LogLevel::kError, where + failure});
    else if (!unseen.empty())
        lines.push_back(
            {slot.context, LogLevel::kWarning, where + "no exception program saw: " + unseen});
}

// Reports of graphs' launches whose pipeline has been destroyed. The graphs may still exist.
void GpuLaunchSlots::tellOfGraphs(Lines& lines) {
    for (auto& slot : slots_) {
        if (slot->state != State::kCaptured || !slot->findings.expired())
            continue;
        auto graphDestroyed = slot->graphDestroyed;
        settle(*slot, lines);
        *slot->report = devlib::emptyReport();
        slot->graphDestroyed = std::move(graphDestroyed);
        slot->state = State::kCaptured;
    }
}

void GpuLaunchSlots::tell(const Lines& lines) {
    for (const Line& line : lines)
        if (const std::shared_ptr<Context> context = line.context.lock(); context && context->log)
            context->log(line.level, "LAUNCH", line.text);
}

} // namespace sunstone::engine
