// SPDX-License-Identifier: Apache-2.0
// Capturing in Streams; see graph.h. Rules and error numbers: CUDA Driver API, "Stream Management".
#include "device/cpu/stream.h"

#include <algorithm>
#include <unordered_set>

namespace sunstone::device::cpu {

namespace {

std::atomic<uint64_t> nextCaptureId{1};
thread_local Capture::Mode threadMode = Capture::kGlobal;

// Whether every node of `tips` is among `ends` or comes before one of them.
bool leadTo(const std::vector<GraphNode*>& tips, const std::vector<GraphNode*>& ends) {
    std::unordered_set<const GraphNode*> reached(ends.begin(), ends.end());
    std::vector<const GraphNode*> open(ends.begin(), ends.end());
    while (!open.empty()) {
        const GraphNode* node = open.back();
        open.pop_back();
        for (const GraphNode* before : node->after)
            if (reached.insert(before).second)
                open.push_back(before);
    }
    return std::all_of(tips.begin(), tips.end(),
                       [&](const GraphNode* tip) { return reached.contains(tip); });
}

} // namespace

Capture* Streams::validCapture(const StreamPtr& stream) {
    Capture* capture = stream->capture_.get();
    return capture && !capture->ended ? capture : nullptr;
}

bool Streams::isCapturing(const StreamPtr& stream) {
    std::lock_guard lock(order_);
    return validCapture(stream) != nullptr;
}

CapturedMark Streams::captureState(const StreamPtr& stream) {
    std::lock_guard lock(order_);
    if (!validCapture(stream))
        return {};
    return {stream->capture_, stream->capture_->graph, stream->tips_};
}

void Streams::setTips(const StreamPtr& stream, std::vector<GraphNode*> tips) {
    std::lock_guard lock(order_);
    if (!validCapture(stream))
        throw CaptureError(CaptureError::kIllegalState, "the stream does not capture");
    stream->tips_ = std::move(tips);
}

CompletionPtr Streams::capture(const StreamPtr& stream, std::function<void()> work, WorkInfo info) {
    static const CompletionPtr& finished = *[] {
        auto completion = std::make_shared<Completion>();
        completion->finish();
        return new CompletionPtr(std::move(completion));
    }();
    std::lock_guard graphLock(graphMutex());
    std::lock_guard lock(order_);
    Capture* capture = validCapture(stream);
    if (!capture || capture->invalidated)
        throw CaptureError(CaptureError::kInvalidated, "the stream's capture is invalid");
    GraphNode node;
    node.kind = info.kind;
    node.work = std::move(work);
    node.details = std::move(info.details);
    node.after = stream->tips_;
    stream->tips_ = {capture->graph->add(std::move(node))};
    return finished;
}

void Streams::beginCapture(const StreamPtr& stream, Capture::Mode mode,
                           std::shared_ptr<Graph> graph, std::vector<GraphNode*> after) {
    std::lock_guard lock(order_);
    if (stream == legacy_)
        throw CaptureError(CaptureError::kUnsupported,
                           "the legacy default stream cannot be captured");
    if (validCapture(stream))
        throw CaptureError(CaptureError::kIllegalState, "the stream captures already");
    auto capture = std::make_shared<Capture>();
    capture->id = nextCaptureId.fetch_add(1, std::memory_order_relaxed);
    capture->mode = mode;
    capture->thread = std::this_thread::get_id();
    capture->origin = stream.get();
    capture->graph = std::move(graph);
    captures_.push_back(capture);
    stream->capture_ = std::move(capture);
    stream->tips_ = std::move(after);
}

std::shared_ptr<Graph> Streams::endCapture(const StreamPtr& stream) {
    std::lock_guard graphLock(graphMutex());
    std::lock_guard lock(order_);
    Capture* capture = validCapture(stream);
    if (!capture)
        throw CaptureError(CaptureError::kIllegalState, "the stream does not capture");
    if (capture->origin != stream.get()) {
        capture->invalidated = true;
        throw CaptureError(CaptureError::kUnmatched, "the capture was begun on another stream");
    }
    if (capture->mode != Capture::kRelaxed && capture->thread != std::this_thread::get_id())
        throw CaptureError(CaptureError::kWrongThread, "the capture was begun by another thread");
    const std::shared_ptr<Capture> ended = stream->capture_;
    const std::vector<GraphNode*> ends = stream->tips_;
    bool joined = true;
    for (const StreamPtr& other : live_) {
        if (other->capture_ != ended)
            continue;
        joined = joined && leadTo(other->tips_, ends);
        other->capture_ = nullptr;
        other->tips_.clear();
    }
    ended->ended = true;
    std::shared_ptr<Graph> graph = std::move(ended->graph);
    std::erase(captures_, ended);
    if (ended->invalidated)
        throw CaptureError(CaptureError::kInvalidated, "the capture was invalidated earlier");
    if (!joined)
        throw CaptureError(CaptureError::kUnjoined,
                           "another stream joined the capture and did not come back");
    return graph;
}

void Streams::waitForCaptured(const StreamPtr& stream, const CapturedMark& mark) {
    std::lock_guard lock(order_);
    if (mark.capture->ended)
        throw CaptureError(CaptureError::kCapturedEvent,
                           "the event was recorded in a capture that has ended");
    if (mark.capture->invalidated)
        throw CaptureError(CaptureError::kInvalidated, "the event's capture is invalid");
    if (stream == legacy_) {
        mark.capture->invalidated = true;
        throw CaptureError(CaptureError::kImplicit, "the legacy default stream cannot be captured");
    }
    if (Capture* own = validCapture(stream)) {
        if (own != mark.capture.get()) {
            own->invalidated = mark.capture->invalidated = true;
            throw CaptureError(CaptureError::kMerge, "two captures would become one");
        }
    } else {
        stream->capture_ = mark.capture;
        stream->tips_.clear();
    }
    for (GraphNode* tip : mark.tips)
        if (std::find(stream->tips_.begin(), stream->tips_.end(), tip) == stream->tips_.end())
            stream->tips_.push_back(tip);
}

void Streams::dropCapture(const StreamPtr& stream) {
    const std::shared_ptr<Capture> capture = std::move(stream->capture_);
    if (!capture || capture->ended)
        return;
    capture->invalidated = true;
    if (capture->origin == stream.get()) {
        capture->ended = true; // the destroyed stream cannot end it
        std::erase(captures_, capture);
    }
}

void Streams::refuseImplicitJoin(const StreamPtr& stream) {
    if (stream != legacy_ || captures_.empty())
        return;
    bool found = false;
    for (const StreamPtr& other : live_)
        if (Capture* capture = other->isBlocking() ? validCapture(other) : nullptr) {
            capture->invalidated = true;
            found = true;
        }
    if (found)
        throw CaptureError(CaptureError::kImplicit,
                           "the legacy default stream would depend on a stream that captures");
}

void Streams::refuseCapturing(const StreamPtr& stream) {
    if (Capture* capture = validCapture(stream)) {
        capture->invalidated = true;
        throw CaptureError(CaptureError::kUnsupported,
                           "a stream that captures has nothing to wait for");
    }
    refuseImplicitJoin(stream);
}

void Streams::refuseDuringCapture() {
    if (threadMode == Capture::kRelaxed)
        return;
    std::lock_guard lock(order_);
    bool found = false;
    for (const auto& capture : captures_) {
        const bool own = capture->thread == std::this_thread::get_id();
        const bool forbids =
            own ? capture->mode != Capture::kRelaxed
                : capture->mode == Capture::kGlobal && threadMode == Capture::kGlobal;
        if (forbids) {
            capture->invalidated = true;
            found = true;
        }
    }
    if (found)
        throw CaptureError(CaptureError::kUnsupported,
                           "this call is not allowed while a stream captures");
}

Capture::Mode Streams::exchangeThreadMode(Capture::Mode mode) {
    return std::exchange(threadMode, mode);
}

} // namespace sunstone::device::cpu
