// SPDX-License-Identifier: Apache-2.0
// The process of a rank that does not run the application: it keeps copies of scenes, and renders
// the subframes that the application's rank assigns to it (distribution.h).
#include "api/optix6/call.h"
#include "api/optix6/remote/archive.h"
#include "api/optix6/remote/channel.h"
#include "api/optix6/remote/replica.h"
#include "api/optix6/scene.h"
#include "base/log.h"

#include <unistd.h>

#include <chrono>
#include <deque>

namespace sunstone::optix6 {

namespace {

constexpr uint32_t kApplication = 0; // its rank

class Worker {
public:
    Worker(int socket, unsigned device) : channel_(socket), device_(device) {}
    // Returns when the channel is closed, because the application has ended.
    void serve();

private:
    struct Source {
        std::shared_ptr<Buffer> buffer;
        PictureSum sum;
    };
    struct Launch {
        uint64_t number = 0;
        Replica* replica = nullptr; // null: no launch
        engine::LaunchRequest request;
        std::vector<Source> sources;
        std::deque<std::pair<unsigned, unsigned>> ranges; // first, count
        unsigned made = 0;                                // of the first range
        double seconds = 0;
    };
    void handle(const Message& message);
    void update(uint64_t number, Reader& in);
    void start(Reader& in);
    void makeSubframe();
    void sendSums();
    void fail(const std::string& text);
    template <class Body>
    void tryTo(const Body& body);

    Channel channel_;
    const unsigned device_;
    std::map<uint64_t, std::unique_ptr<Replica>> replicas_;
    Launch launch_;
    std::vector<float> pixels_;
};

void Worker::serve() {
    Writer hello;
    hello.all(MessageKind::kHello,
              uint64_t(sysconf(_SC_PHYS_PAGES)) * uint64_t(sysconf(_SC_PAGE_SIZE)));
    channel_.send(kApplication, hello.bytes);
    for (;;) {
        const bool isBusy = launch_.replica && !launch_.ranges.empty();
        if (const std::optional<Message> message = channel_.receive(isBusy ? 0 : -1))
            handle(*message);
        else if (isBusy)
            tryTo([&] { makeSubframe(); });
    }
}

// Errors of the body fail the launch only on this rank.
template <class Body>
void Worker::tryTo(const Body& body) {
    try {
        body();
    } catch (const std::exception& error) {
        fail(error.what());
    }
}

void Worker::fail(const std::string& text) {
    log(LogLevel::kError, "optix6", message("this rank cannot take part in the launch: ", text));
    Writer out;
    out.all(MessageKind::kFailed, launch_.number, text);
    channel_.send(kApplication, out.bytes);
    launch_.replica = nullptr;
    launch_.ranges.clear();
}

void Worker::handle(const Message& message) {
    Reader in(message.bytes);
    const auto kind = in.get<MessageKind>();
    const auto number = in.get<uint64_t>();
    switch (kind) {
    case MessageKind::kScene:
        return update(number, in);
    case MessageKind::kDrop:
        if (launch_.replica && replicas_.count(number) &&
            launch_.replica == replicas_[number].get())
            launch_ = {};
        replicas_.erase(number);
        return;
    case MessageKind::kStart:
        launch_ = {};
        launch_.number = number;
        return tryTo([&] { start(in); });
    case MessageKind::kWork: {
        const auto first = in.get<unsigned>(), count = in.get<unsigned>();
        if (number == launch_.number && launch_.replica && count != 0)
            launch_.ranges.emplace_back(first, count);
        return;
    }
    case MessageKind::kStop:
        if (number == launch_.number)
            launch_ = {};
        return;
    default:
        return;
    }
}

// A copy that cannot be updated is dropped: the launch then finds none and fails.
void Worker::update(uint64_t number, Reader& in) {
    std::unique_ptr<Replica>& replica = replicas_[number];
    try {
        if (!replica)
            replica = std::make_unique<Replica>(device_);
        replica->apply(in.get<std::string>());
    } catch (const std::exception& error) {
        log(LogLevel::kError, "optix6",
            message("this rank has no copy of the scene: ", error.what()));
        replicas_.erase(number);
    }
}

void Worker::start(Reader& in) {
    const auto found = replicas_.find(in.get<uint64_t>());
    if (found == replicas_.end())
        sunstone::fail(Code::kInternal, "the launch is of an unknown scene");
    const auto entry = in.get<unsigned>();
    const auto width = in.get<uint32_t>(), height = in.get<uint32_t>();
    Context& context = found->second->context();
    checkLaunch(context, entry, width, height, 1);
    const auto numbers = in.get<std::vector<uint64_t>>();
    for (const uint64_t source : numbers) {
        const auto buffer = std::dynamic_pointer_cast<Buffer>(found->second->find(source));
        if (!buffer || buffer->bytes() < uint64_t(width) * height * 3 * sizeof(float))
            sunstone::fail(Code::kInternal, "the launch has an unknown source");
        launch_.sources.push_back({buffer, PictureSum(size_t(width) * height)});
    }
    context.scene->update();
    launch_.request = context.scene->request(entry, width, height, 1);
    launch_.replica = found->second.get();
}

void Worker::makeSubframe() {
    const auto begin = std::chrono::steady_clock::now();
    Context& context = launch_.replica->context();
    const auto [first, count] = launch_.ranges.front();
    context.scene->run(launch_.request, first + launch_.made);
    for (Source& source : launch_.sources) {
        pixels_.resize(source.buffer->bytes() / sizeof(float));
        source.buffer->read(pixels_.data());
        source.sum.add(pixels_.data(), bytesOf(source.buffer->format) / sizeof(float));
    }
    launch_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (++launch_.made == count)
        sendSums();
}

void Worker::sendSums() {
    const auto [first, count] = launch_.ranges.front();
    Writer out;
    out.all(MessageKind::kSums, launch_.number, first, count, launch_.seconds);
    for (Source& source : launch_.sources) {
        const std::vector<double>& values = source.sum.values();
        const std::vector<float> sums(values.begin(), values.end());
        out.items(sums.data(), sums.size());
        source.sum.clear();
    }
    channel_.send(kApplication, out.bytes);
    launch_.ranges.pop_front();
    launch_.made = 0;
    launch_.seconds = 0;
}

} // namespace

} // namespace sunstone::optix6

// For the command `sunstone`: serves the application's rank until it ends.
extern "C" __attribute__((visibility("default"))) void sunstone_serve_node(int socket,
                                                                           unsigned device) {
    try {
        sunstone::optix6::Worker(socket, device).serve();
    } catch (const std::exception& error) {
        sunstone::log(sunstone::LogLevel::kInfo, "optix6",
                      sunstone::message("the node ends: ", error.what()));
    }
}
