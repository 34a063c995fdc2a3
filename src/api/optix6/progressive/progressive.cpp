// SPDX-License-Identifier: Apache-2.0
#include "api/optix6/progressive/progressive.h"

#include "api/optix6/context.h"
#include "api/optix6/remote/archive.h"
#include "api/optix6/scene.h"
#include "base/log.h"
#include "base/process_end.h"

#include <algorithm>

namespace sunstone::optix6 {

namespace {

// Shortest time between two pictures; more pictures show no difference. Making pictures takes at
// most a twentieth of the time.
constexpr std::chrono::nanoseconds kInterval(33333333);
constexpr int kShare = 20;

unsigned componentsOf(const Buffer& source) {
    return bytesOf(source.format) / sizeof(float);
}

} // namespace

void checkStream(const Buffer& stream, const Buffer& source) {
    if (!stream.stream)
        refuse(RT_ERROR_INVALID_VALUE, "stream is not of type RT_BUFFER_PROGRESSIVE_STREAM");
    if (stream.format != RT_FORMAT_UNSIGNED_BYTE4)
        refuse(RT_ERROR_INVALID_VALUE, "the format of the stream buffer is ", nameOf(stream.format),
               ", not RT_FORMAT_UNSIGNED_BYTE4");
    if (source.typeBits() != RT_BUFFER_OUTPUT)
        refuse(RT_ERROR_INVALID_VALUE, "the source of a stream is not of type RT_BUFFER_OUTPUT");
    if (source.format != RT_FORMAT_FLOAT3 && source.format != RT_FORMAT_FLOAT4)
        refuse(RT_ERROR_INVALID_VALUE, "the format of the stream's source is ",
               nameOf(source.format), ", neither RT_FORMAT_FLOAT3 nor RT_FORMAT_FLOAT4");
}

Progressive::Picture Progressive::pictureOf(const std::shared_ptr<Buffer>& stream,
                                            const Parameters& parameters) const {
    const std::shared_ptr<Buffer> source = stream->stream->source.lock();
    checkStream(*stream, *source);
    const std::pair<const char*, const Buffer*> both[] = {{"stream buffer", stream.get()},
                                                          {"source of a stream", source.get()}};
    for (const auto& [name, buffer] : both)
        if (buffer->dimensions != 2 || buffer->extent(0, 0) != parameters.width ||
            buffer->extent(1, 0) != parameters.height)
            refuse(RT_ERROR_INVALID_VALUE, "the ", name, " has ", buffer->dimensions,
                   " dimensions and ", buffer->extent(0, 0), " by ", buffer->extent(1, 0),
                   " elements, but the launch is ", parameters.width, " by ", parameters.height);
    return {stream, source, PictureSum(size_t(parameters.width) * parameters.height),
            ToneMap(stream->stream->gamma), 0};
}

bool Progressive::matches(const Parameters& parameters) {
    std::lock_guard lock(failureMutex_);
    return isActive_ && parameters_ == parameters && !failure_;
}

void Progressive::start(const Parameters& parameters) {
    stop();
    throwFailure(true);
    std::vector<Picture> pictures;
    for (const Ref<Buffer>& ref : context_.allBuffers)
        if (const auto buffer = ref.lock();
            buffer && buffer->stream && !buffer->stream->source.expired())
            pictures.push_back(pictureOf(buffer, parameters));
    context_.scene->update();
    request_ = context_.scene->request(parameters.entry, parameters.width, parameters.height, 1);
    pictures_ = std::move(pictures);
    parameters_ = parameters;
    nextPublished_ = {};
    wantsEnd_ = false;
    isActive_ = true;
    try {
        distribute();
        context_.launchFailed = false;
        isGenerating_ = parameters.width != 0 && parameters.height != 0;
        if (isGenerating_)
            thread_ = std::thread([this] { work(); });
    } catch (...) {
        isGenerating_ = false;
        stop();
        throw;
    }
}

void Progressive::stop() {
    if (!isActive_)
        return;
    wantsEnd_ = true;
    if (thread_.joinable())
        thread_.join();
    isActive_ = false;
    subframes_.reset();
    copies_.release();
    request_ = {};
    pictures_.clear();
}

void Progressive::throwFailure(bool once) {
    std::lock_guard lock(failureMutex_);
    if (!failure_)
        return;
    const Failure failure = *failure_;
    if (once)
        failure_.reset();
    throw failure;
}

// The next call that starts the launch throws it. Errors without a code of the API count as a
// failed launch.
void Progressive::note(RTresult result, const std::string& text) {
    const std::string line = message("the progressive launch failed: ", text);
    log(LogLevel::kError, "optix6", line);
    context_.report(1, "ERROR", line);
    context_.launchFailed = true;
    std::lock_guard lock(failureMutex_);
    failure_.emplace(result, line);
}

void Progressive::work() {
    try {
        generate();
    } catch (const ProcessEnds&) {
        // No caller is left to read the result.
    } catch (const Failure& failure) {
        note(failure.result, failure.what());
    } catch (const std::bad_alloc&) {
        note(RT_ERROR_MEMORY_ALLOCATION_FAILED, "out of host memory");
    } catch (const std::exception& error) {
        note(RT_ERROR_LAUNCH_FAILED, error.what());
    }
    isGenerating_ = false;
}

// Selects the ranks that render subframes.
void Progressive::distribute() {
    SceneCopies::Launch launch{parameters_.entry, parameters_.width, parameters_.height, {}};
    for (const Picture& picture : pictures_)
        launch.sources.push_back(picture.source);
    const uint64_t number = copies_.start(launch);
    subframes_ =
        std::make_unique<Distribution>(copies_.ranks(), copies_.nodes(), number, parameters_.limit);
}

void Progressive::generate() {
    do {
        const std::optional<unsigned> subframe = subframes_->take();
        if (subframe)
            makeSubframe(*subframe);
        receive(subframe ? 0 : 1);
        if (std::chrono::steady_clock::now() >= nextPublished_)
            publish();
    } while (!wantsEnd_ && !subframes_->isDone());
    publish();
}

void Progressive::makeSubframe(unsigned subframe) {
    receive(0); // gives other ranks work meanwhile
    context_.scene->run(request_, subframe);
    for (Picture& picture : pictures_) {
        const Buffer& source = *picture.source;
        const auto* pixels = reinterpret_cast<const float*>(source.data());
        if (context_.isOnGpu()) {
            pixels_.resize(source.bytes() / sizeof(float));
            source.read(pixels_.data());
            pixels = pixels_.data();
        }
        picture.sum.add(pixels, componentsOf(source));
    }
    subframes_->noteOwn();
}

void Progressive::receive(int milliseconds) {
    subframes_->receive(milliseconds, [this](unsigned count, Reader& sums) {
        for (Picture& picture : pictures_) {
            pixels_.resize(picture.sum.values().size());
            sums.items(pixels_.data(), pixels_.size());
            picture.sum.addSum(pixels_.data(), count);
        }
    });
}

void Progressive::publish() {
    const auto begin = std::chrono::steady_clock::now();
    for (Picture& picture : pictures_) {
        const unsigned count = picture.sum.count();
        if (picture.published == count)
            continue;
        picture.stream->stream->publish(picture.sum.toneMapped(picture.toneMap), count,
                                        parameters_.limit);
        picture.published = count;
    }
    const auto end = std::chrono::steady_clock::now();
    nextPublished_ = std::max(begin + kInterval, end + kShare * (end - begin));
}

} // namespace sunstone::optix6
