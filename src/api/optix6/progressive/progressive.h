// SPDX-License-Identifier: Apache-2.0
// The progressive launch of a context: a thread that runs subframes, adds them up and publishes
// pictures in stream buffers.
//
// While the thread runs, it alone uses the scene: every call that could change anything ends the
// launch first (call.h). Calls that do not end it touch only data that a stream protects. The
// thread therefore takes no lock of the context, and a call that holds this lock may wait for the
// thread.
#pragma once

#include "api/optix6/object.h"
#include "api/optix6/progressive/picture_sum.h"
#include "api/optix6/remote/distribution.h"
#include "api/optix6/remote/scene_copies.h"
#include "engine/launch.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace sunstone::optix6 {

class Buffer;

// Throws Failure: the second buffer cannot be the source of the first.
void checkStream(const Buffer& stream, const Buffer& source);

class Progressive {
public:
    explicit Progressive(Context& context) : context_(context), copies_(context) {}
    ~Progressive() { stop(); }

    struct Parameters {
        unsigned entry;
        uint32_t width, height;
        unsigned limit; // of subframes; 0: none
        bool operator==(const Parameters&) const = default;
    };
    // Whether this launch is in progress, or has completed and no call has ended it.
    bool matches(const Parameters& parameters);
    // Starts a launch. Throws Failure.
    void start(const Parameters& parameters);
    // Ends the launch at the end of its current subframe; a launch makes at least one.
    void stop();
    bool isGenerating() const { return isGenerating_; }
    // Throws the error of a failed launch. `once`: only at the first call.
    void throwFailure(bool once);

private:
    // The picture of a stream buffer.
    struct Picture {
        std::shared_ptr<Buffer> stream, source;
        PictureSum sum;
        ToneMap toneMap;
        unsigned published = 0; // subframes in the newest picture
    };
    Picture pictureOf(const std::shared_ptr<Buffer>& stream, const Parameters& parameters) const;
    void work();
    void generate();
    void distribute();
    void makeSubframe(unsigned subframe);
    void receive(int milliseconds);
    void publish();
    void note(RTresult result, const std::string& text);

    Context& context_;
    bool isActive_ = false;
    Parameters parameters_{};
    std::thread thread_;
    std::atomic<bool> isGenerating_{false}, wantsEnd_{false};
    // Used by the thread alone while it runs.
    engine::LaunchRequest request_;
    std::vector<Picture> pictures_;
    std::vector<float> pixels_; // of a source that the host cannot read, or of another rank
    std::unique_ptr<Distribution> subframes_;
    std::chrono::steady_clock::time_point nextPublished_;

    SceneCopies copies_; // on other ranks
    std::mutex failureMutex_;
    std::optional<Failure> failure_;
};

} // namespace sunstone::optix6
